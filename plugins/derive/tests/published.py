"""Mechanisms of benchmark libraries and textbooks, each with the numbers or the closed form that it was published with."""

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any, NamedTuple

import casadi as ca
import numpy as np
import pandas as pd
from numpy.polynomial import legendre
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from scipy.special import ellipe, ellipeinc, ellipj, ellipk, ellipkinc

from quickreturn.derive import Beam, System, turned, vector


class Published(NamedTuple):
    """A mechanism, its motion, and what is right: numbers of the last row, or of each row."""

    system: System
    start: Mapping[str, float]
    duration: float
    right: Callable[[pd.DataFrame], dict[str, Any]]
    tolerance: float  # of the comparison, relative to the largest number
    rows: int = 20
    looser: Mapping[str, float] = MappingProxyType({})  # part of a name -> its tolerance


def described(name: str, gravity: float = 0.0) -> tuple[System, Any]:
    """A system under gravity along -n2, and one metre, kilogram, second and radian: factors that give numbers a unit."""
    system = System(name)
    system.gravity = vector(0, -gravity)
    return system, system.constants(m=(1, "m"), kg=(1, "kg"), s=(1, "s"), rad=(1, "rad"))


def simple_pendulum() -> Published:
    """IFToMM library A01, in Cartesian coordinates; falls from the horizontal (elliptic functions)."""
    system, u = described("simple pendulum", 9.81)
    x, y = system.coordinate("x", "m", guess=1.0), system.coordinate("y", "m")
    system.body("bob", u.kg, vector(x, y))
    system.loop("rod", ca.sqrt(x**2 + y**2) - u.m, gives=[x])

    def right(found: pd.DataFrame) -> dict[str, Any]:
        modulus = 0.5
        sine = np.sqrt(modulus) * ellipj(ellipk(modulus) - np.sqrt(9.81) * found["time"], modulus)[0]
        angle = 2 * np.arcsin(sine)
        return {"x": np.sin(angle), "y": -np.cos(angle)}

    return Published(system, {"y": 0.0, "x": 1.0}, 4.0, right, 1e-6)


#: Test Set for Initial Value Problem Solvers, `andrews.f`: constants, start and end at 0.03 s.
ANDREWS = {
    "start": [-0.0617138900142764496, 0.0, 0.455279819163070380, 0.222668390165885885, 0.487364979543842550, -0.222668390165885885,
              1.23054744454982119],
    "end": [15.81077119629904, -15.75637105984298, 0.04082224013073101, -0.5347301163226948, 0.5244099658805304, 0.5347301163226948,
            1.048080741042263],
    "speeds": [1139.920302151208, -1424.379294994111, 11.03291221937134, 19.29337464421385, 0.5735699284790808, -19.29337464421385,
               0.3231791658026955],
    "multipliers": [199.1753333731910, -29.75531228015052, 23.06654119098399, 31.45271365475927, 22.64249232082739, 11.61740700019673],
}  # fmt: skip


def andrews_squeezer() -> Published:
    """Seven bodies, after E. Hairer and G. Wanner, Solving Ordinary Differential Equations II; IFToMM library A03."""
    system, u = described("Andrews' squeezer")
    names = ["beta", "theta", "gamma", "phi", "delta", "omega", "epsilon"]
    be, th, ga, ph, de, om, ep = (
        system.coordinate(name, "rad", guess=guess, size=0.1) for name, guess in zip(names, ANDREWS["start"], strict=True)
    )
    inertia, length = u.kg * u.m**2, u.m
    a, b, c = (vector(x * length, y * length) for x, y in ((-0.06934, -0.00227), (-0.03635, 0.03273), (0.014, 0.072)))

    def at(angle: Any, x: float, y: float = 0.0) -> ca.SX:
        return turned(angle, x * length, y * length)

    crank = at(be, 0.007)
    system.body("1", 0.04325 * u.kg, at(be, 0.00092), 2.194e-6 * inertia, be)
    system.body("2", 0.00365 * u.kg, crank - at(be + th, 0.0115), 4.410e-7 * inertia, be + th)
    system.body("3", 0.02373 * u.kg, b + at(ga, 0.01043, -0.01874), 5.255e-6 * inertia, ga)
    system.body("4", 0.00706 * u.kg, a + at(de, 0.04) + at(ph + de, 0.0, -0.00579), 5.667e-7 * inertia, ph + de)
    system.body("5", 0.07050 * u.kg, a + at(de, 0.02308, 0.00916), 1.169e-5 * inertia, de)
    system.body("6", 0.00706 * u.kg, a + at(ep, 0.0, -0.04) + at(om + ep, 0.00579), 5.667e-7 * inertia, om + ep)
    system.body("7", 0.05498 * u.kg, a + at(ep, 0.00449, -0.01228), 1.912e-5 * inertia, ep)
    system.load("motor", be, 0.033 * u.kg * u.m**2 / u.s**2)
    spring = b + at(ga, 0.02, -0.018) - c
    system.spring("spring", ca.sqrt(ca.dot(spring, spring)) - 0.07785 * length, 4530 * u.kg / u.s**2)
    pin = crank - at(be + th, 0.028)
    system.loop("b", pin - b - at(ga, 0.0, -0.035), gives=[th, ga])
    system.loop("a", pin - a - at(de, 0.04) - at(ph + de, 0.0, -0.02), gives=[ph, de])
    system.loop("c", pin - a - at(ep, 0.0, -0.04) - at(om + ep, 0.02), gives=[om, ep])

    def right(_: pd.DataFrame) -> dict[str, Any]:
        ends = dict(zip(names, ANDREWS["end"], strict=True))
        ends |= {f"{name}_rate": speed for name, speed in zip(names, ANDREWS["speeds"], strict=True)}
        forces = [f"{loop}_force_{k}" for loop in "bac" for k in (1, 2)]
        return ends | {name: -force for name, force in zip(forces, ANDREWS["multipliers"], strict=True)}

    # both forms agree to 1e-9 at tighter tolerances: the rest is the published program's, whose unknowns are of index 1, 2 and 3
    return Published(system, {"beta": ANDREWS["start"][0]}, 0.03, right, 1e-9, looser={"_rate": 1e-7, "_force": 2e-6})


def double_pendulum() -> Published:
    """Equal masses and threads: the equations of textbooks (L. Landau and E. Lifshitz, Mechanics, section 5), far from small motions."""
    system, u = described("double pendulum", 9.81)
    one, two = system.coordinate("one", "rad"), system.coordinate("two", "rad")
    first = turned(one, 0.0, -u.m)
    system.body("upper", u.kg, first)
    system.body("lower", u.kg, first + turned(two, 0.0, -u.m))

    def rates(_: float, z: Any) -> list[float]:
        a, b, v, w = z
        mass = [[2.0, np.cos(a - b)], [np.cos(a - b), 1.0]]
        force = [-np.sin(a - b) * w**2 - 2 * 9.81 * np.sin(a), np.sin(a - b) * v**2 - 9.81 * np.sin(b)]
        return [v, w, *np.linalg.solve(mass, force)]

    def right(found: pd.DataFrame) -> dict[str, Any]:
        z = solve_ivp(rates, (0, 3), [2.0, 1.0, 0.0, 0.0], "DOP853", found["time"], rtol=1e-12, atol=1e-12).y
        return {"one": z[0], "two": z[1]}

    return Published(system, {"one": 2.0, "two": 1.0}, 3.0, right, 1e-6)


def cart_pole() -> Published:
    """A. Barto, R. Sutton and C. Anderson, IEEE Transactions on Systems, Man, and Cybernetics 13 (1983), without friction."""
    system, u = described("cart-pole", 9.8)
    x, theta = system.coordinate("x", "m"), system.coordinate("theta", "rad")
    system.body("cart", u.kg, vector(x, 0))
    middle = vector(x, 0) + turned(theta, 0.0, 0.5 * u.m)
    system.body("pole", 0.1 * u.kg, middle, 0.1 / 12 * u.kg * u.m**2, theta)
    system.load("push", x, 10 * u.kg * u.m / u.s**2)
    for name, unit in (("x", "m/s^2"), ("theta", "rad/s^2")):
        q = next(c.q for c in system.coordinates if c.name == name)
        system.output(f"{name}_acceleration", system.rate(system.rate(q)), unit)

    def right(found: pd.DataFrame) -> dict[str, Any]:
        angle, rate, mass, half = -found["theta"], -found["theta_rate"], 1.1, 0.5  # theirs counts clockwise
        pushed = (-10 - 0.1 * half * rate**2 * np.sin(angle)) / mass
        turning = (9.8 * np.sin(angle) + np.cos(angle) * pushed) / (half * (4 / 3 - 0.1 * np.cos(angle) ** 2 / mass))
        return {
            "theta_acceleration": -turning,
            "x_acceleration": (10 + 0.1 * half * (rate**2 * np.sin(angle) - turning * np.cos(angle))) / mass,
        }

    return Published(system, {"theta": 0.3, "theta_rate": -2.0}, 1.0, right, 1e-10)


def elastic_pendulum() -> Published:
    """P. Lynch, Resonant motions of the three-dimensional elastic pendulum, Int. J. Non-Linear Mech. 37 (2002), in Cartesian places."""
    gravity, stiffness, length = np.pi**2, 4 * np.pi**2, 0.75  # stretched by its own weight to 1 m
    system, u = described("elastic pendulum", gravity)
    theta, r = system.coordinate("theta", "rad"), system.coordinate("r", "m")
    place = turned(theta, 0.0, -r)
    system.body("bob", u.kg, place)
    system.spring("spring", r - length * u.m, stiffness * u.kg / u.s**2)
    system.output("x", place[0], "m")
    system.output("y", place[1], "m")

    def rates(_: float, z: Any) -> list[float]:
        pull = stiffness * (length / np.hypot(z[0], z[1]) - 1.0)
        return [z[2], z[3], pull * z[0], pull * z[1] - gravity]

    def right(found: pd.DataFrame) -> dict[str, Any]:
        begin = [1.3 * np.sin(0.4), -1.3 * np.cos(0.4), 0.0, 0.0]
        z = solve_ivp(rates, (0, 6), begin, "DOP853", found["time"], rtol=1e-12, atol=1e-12).y
        return {"x": z[0], "y": z[1]}

    return Published(system, {"theta": 0.4, "r": 1.3}, 6.0, right, 1e-6)


def inversor() -> Published:
    """C.-N. Peaucellier and L. Lipkin: eight bars; the pen's distance from the pivot line is (a^2 - b^2) / (2 r)."""
    system, u = described("inversor", 9.81)
    crank, x, y = system.coordinate("crank", "rad"), system.coordinate("x", "m", guess=1.6), system.coordinate("y", "m", guess=0.8)
    arms = [system.coordinate(f"arm_{k}", "rad", guess=guess) for k, guess in enumerate((1.0, -0.2))]
    inner, pen = vector(0.5 * u.m, 0) + turned(crank, 0.5 * u.m), vector(x, y)
    corners = [turned(arm, 1.5 * u.m) for arm in arms]
    for name, mass, place in (("inner", 1.0, inner), ("pen", 2.0, pen), ("left", 0.5, corners[0]), ("right", 0.5, corners[1])):
        system.body(name, mass * u.kg, place)
    for k, corner in enumerate(corners):
        for name, end, gives in (("in", inner, arms[k]), ("out", pen, (x, y)[k])):
            system.loop(f"{name}_{k}", (ca.dot(corner - end, corner - end) - (0.7 * u.m) ** 2) / u.m, gives=[gives])
    return Published(system, {"crank": 0.8}, 0.6, lambda found: {"x": np.full(len(found), 1.5**2 - 0.7**2)}, 1e-9)


def falling_ladder() -> Published:
    """A rod slides down a wall: its push on the wall is 3/4 m g cos(a) (3 sin(a) - 2 sin(a0)), which ends at two thirds of its height."""
    system, u = described("falling ladder", 9.81)
    a, x, y = system.coordinate("a", "rad"), system.coordinate("x", "m"), system.coordinate("y", "m")
    system.body("rod", 2 * u.kg, vector(x, y), 2 / 12 * u.kg * u.m**2, a)
    half = turned(a, u.m / 2)
    system.loop("wall", x - half[0], gives=[x])
    system.loop("floor", y - half[1], gives=[y])

    def right(found: pd.DataFrame) -> dict[str, Any]:
        return {"wall_force": 1.5 * 9.81 * np.cos(found["a"]) * (3 * np.sin(found["a"]) - 2 * np.sin(1.3))}

    return Published(system, {"a": 1.3}, 0.5, right, 1e-8)


def two_link_arm() -> Published:
    """Torques of two joints for given motions: J. Craig, Introduction to Robotics, example of two point masses at the links' ends."""
    system, u = described("two-link arm", 9.81)
    one, two = system.coordinate("one", "rad"), system.coordinate("two", "rad")
    elbow = turned(one, 0.8 * u.m)
    system.body("elbow", 2 * u.kg, elbow)
    system.body("hand", 3 * u.kg, elbow + turned(one + two, 0.5 * u.m))
    t = system.time / u.s
    system.loop("shoulder", one - ca.sin(2 * t), "rad", gives=[one])
    system.loop("elbow", two - t**2, "rad", gives=[two])

    def right(found: pd.DataFrame) -> dict[str, Any]:
        time, m, n, k, h, g = found["time"], 2.0, 3.0, 0.8, 0.5, 9.81
        a, v, w = np.sin(2 * time), 2 * np.cos(2 * time), -4 * np.sin(2 * time)
        b, p, q = time**2, 2 * time, 2.0
        weight = n * h * g * np.cos(a + b)
        at_elbow = n * h**2 * (w + q) + n * k * h * (np.cos(b) * w + np.sin(b) * v**2) + weight
        at_shoulder = (
            n * h**2 * (w + q) + n * k * h * (np.cos(b) * (2 * w + q) - np.sin(b) * (p**2 + 2 * v * p)) + (m + n) * k**2 * w
            + weight + (m + n) * k * g * np.cos(a)
        )  # fmt: skip
        return {"elbow_force": at_elbow, "shoulder_force": at_shoulder}

    return Published(system, {}, 1.5, right, 1e-9)


def porter_governor(speed: float) -> System:
    """R. Khurmi and J. Gupta, Theory of Machines: arms of 250 mm on the axis, balls of 5 kg, a sleeve of 15 kg; speed in rpm."""
    system, u = described("Porter governor", 9.81)
    p = system.constants(speed=(speed, "rpm"))
    arm, length = system.coordinate("arm", "rad", guess=0.8), 0.25 * u.m
    ball = length * vector(ca.sin(arm), -ca.cos(arm))
    system.body("balls", 10 * u.kg, ball)
    system.body("sleeve", 15 * u.kg, vector(0, 2 * ball[1]))
    system.energy("turning", -5 * u.kg * (p.speed * ball[0]) ** 2)
    system.output("radius", ball[0], "mm")
    return system


def elastica(load: float) -> System:
    """K. Bisshopp and D. Drucker, Quarterly of Applied Mathematics 3 (1945): a cantilever far beyond small deflections; load in EI/L^2."""
    system, u = described("elastica")
    count, force = 7, load * u.kg * u.m / u.s**2
    eta = system.amplitudes("eta", count, "rad")

    def tangent(x: ca.SX) -> ca.SX:
        s = x / u.m
        shapes = [legendre.Legendre.basis(k, domain=[0.0, 1.0]).convert(kind=np.polynomial.Polynomial).coef for k in range(count)]
        return sum((eta[k] * s * sum(float(c) * s**j for j, c in enumerate(shape)) for k, shape in enumerate(shapes)), 0 * s)

    beam = Beam(
        system, "beam", origin=vector(0, 0), angle=0, edges=[0, u.m / 2, u.m], tangent=tangent, points=10,
        mass_per_length=u.kg / u.m, bending_stiffness=u.kg * u.m**3 / u.s**2,
    )  # fmt: skip
    system.load("end", beam.end(), vector(0, -force))
    system.output("drop", -beam.end()[1], "m")
    system.output("drawn_in", u.m - beam.end()[0], "m")
    system.output("slope", -beam.end_slope(), "rad")
    return system


def elastica_by_integrals(load: float) -> dict[str, float]:
    """Bisshopp and Drucker's closed form: the equation K(m) - F(first, m) = sqrt(load) gives m, and m the slope of the end."""

    def first(m: float) -> float:
        return float(np.arcsin(1 / np.sqrt(2 * m)))

    root = np.sqrt(load)
    m = brentq(lambda m: ellipk(m) - ellipkinc(first(m), m) - root, 0.5 + 1e-9, 1 - 1e-12)
    slope, drop = np.arcsin(2 * m - 1), 1 - 2 / root * (ellipe(m) - ellipeinc(first(m), m))
    return {"drop": drop, "drawn_in": 1 - np.sqrt(2 * np.sin(slope)) / root, "slope": slope}


def landau() -> System:
    """Two equal masses on equal threads: squares of the frequencies are (2 +- sqrt 2) g/l."""
    return double_pendulum().system


def rocking_half_cylinder() -> System:
    """A half cylinder rolls on its round side: w^2 = 8 g / ((9 pi - 16) R)."""
    system, u = described("half cylinder", 9.81)
    phi, radius = system.coordinate("phi", "rad"), 0.4 * u.m
    down = 4 / (3 * np.pi)
    inertia = 2 * u.kg * radius**2 * (0.5 - down**2)
    system.body("half", 2 * u.kg, radius * vector(-phi, 0) + turned(phi, 0.0, -down * radius), inertia, phi)
    return system
