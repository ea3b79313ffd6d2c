"""The problems described for `quickreturn.derive`, which derives their equations and integrates them."""

from typing import Any, NamedTuple

import casadi as ca
import numpy as np
from numpy.polynomial import legendre

from quickreturn.derive import Beam, Model, Statics, System, turned, vector
from quickreturn.derive.statics import Rest
from quickreturn.pack.make.values import BEAD, BRIDGE, CRANK, DECAY, FOUR_BAR, HUB, PENDULUM, SAG, SPIN_UP, Columns, G, times


class _Units(NamedTuple):
    """One metre, kilogram and second of a system: factors that give numbers a unit."""

    m: Any
    kg: Any
    s: Any

    @property
    def newton(self) -> Any:
        return self.kg * self.m / self.s**2


def _system(name: str, gravity: float = G) -> tuple[System, _Units]:
    system = System(name)
    constants = system.constants(m=(1.0, "m"), kg=(1.0, "kg"), s=(1.0, "s"))
    u = _Units(constants.m, constants.kg, constants.s)
    system.gravity = vector(0, -gravity * u.m / u.s**2)
    return system, u


def _legendre(z: Any, count: int) -> list[Any]:
    """Legendre polynomials of degree 0 to `count` - 1 at z, -1 to 1."""
    found = [1 + 0 * z, z]
    for k in range(1, count - 1):
        found.append(((2 * k + 1) * z * found[k] - k * found[k - 1]) / (k + 1))
    return found


def _strip(system: System, u: _Units, values: Any, shapes: int, origin: Any, angle: Any, damping: Any = 0.0) -> tuple[Beam, Any]:
    """An inextensible strip, `angle` being that of its tangent at its beginning, and its amplitudes: of Legendre polynomials along it."""
    length, eta = values.length * u.m, system.amplitudes("eta", shapes, "rad", size=0.01)

    def tangent(x: Any) -> Any:
        z = 2 * x / length - 1
        return sum((eta[k] * (each + (-1) ** k) for k, each in enumerate(_legendre(z, shapes + 1)[1:])), 0 * z)

    beam = Beam(
        system, "strip", origin=origin, angle=angle, edges=[0, length / 2, length], points=shapes + 3, tangent=tangent,
        mass_per_length=values.mass * u.kg / u.m, bending_stiffness=values.bending * u.newton * u.m**2, damping=damping,
    )  # fmt: skip
    return beam, eta


def _moved(system: System, start: dict[str, float], duration: float, rows: int, tolerance: float = 1e-9) -> Columns:
    """The named outputs of the motion from a start."""
    frame = Model(system).simulate(start, duration, duration / rows, tolerance)
    return {"time": times(duration, rows)} | {name: frame[name].to_numpy() for name in system.outputs}


def sag(rows: int, shapes: int = 9) -> Columns:
    """Equilibria under growing parts of weight and tip force."""
    system, u = _system("sag", gravity=0.0)
    part = system.constants(part=(1.0, "1")).part
    beam, _ = _strip(system, u, SAG, shapes, vector(0, 0), 0.0)
    weight = part * SAG.mass * G * u.newton / u.m
    system.load("force", beam.end(), vector(0, -part * SAG.force * u.newton))
    system.energy("weight", weight * ca.dot(beam.shares, beam.y))
    for name, value, unit in (
        ("tip_x", beam.end()[0], "m"), ("tip_y", beam.end()[1], "m"), ("tip_angle", beam.end_slope(), "rad"),
        ("middle_y", beam.end(0)[1], "m"),
    ):  # fmt: skip
        system.output(name, value, unit)
    model, rests = Model(system), list[Rest]()
    for each in times(1.0, rows):
        rests.append(Statics(model, parameters={"part": float(each)}).equilibrium(rests[-1] if rests else {}))
    return {"time": times(1.0, rows)} | {name: np.array([rest.outputs[name] for rest in rests]) for name in system.outputs}


def decay(rows: int, shapes: int = 8) -> Columns:
    """A small force on the tip from time 0 on; the deflection is exact, the damping that of Kelvin and Voigt and of the air."""
    system, u = _system("decay", gravity=0.0)
    drag = DECAY.damping * u.kg / u.m / u.s
    beam, eta = _strip(system, u, DECAY, shapes, vector(0, 0), 0.0, damping=drag)
    points, weights = legendre.leggauss(shapes + 3)
    slopes = np.array([legendre.legval(points, legendre.legder(np.eye(shapes + 1)[k + 1])) for k in range(shapes)]).T
    curvature = ca.DM(slopes * 2 / DECAY.length) @ eta / u.m
    system.damper("material", curvature, DECAY.material * u.s * DECAY.bending * u.newton * u.m**2 * DECAY.length / 2 * u.m * ca.DM(weights))
    system.load("force", beam.end(), vector(0, DECAY.force * u.newton))
    system.output("tip_deflection", beam.end()[1], "m")
    system.output("middle_deflection", beam.end(0)[1], "m")
    system.output("tip_speed", system.rate(beam.end()[1]), "m/s")
    return _moved(system, {}, DECAY.duration, rows)


def bending_pendulum(rows: int, shapes: int = 10) -> Columns:
    """Pinned at its beginning; it hangs down and is pushed."""
    system, u = _system("bending pendulum")
    beam, _ = _strip(system, u, PENDULUM, shapes, vector(0, 0), system.coordinate("angle", "rad"))
    middle, end = beam.end(0), beam.end()
    for name, value in (("tip_x", end[0]), ("tip_y", end[1]), ("middle_x", middle[0]), ("middle_y", middle[1])):
        system.output(name, value, "m")
    return _moved(system, {"angle": -np.pi / 2, "angle_rate": PENDULUM.rate}, PENDULUM.duration, rows)


def hub(rows: int, shapes: int = 8) -> Columns:
    """A torque of one sine on a hub that carries a strip."""
    system, u = _system("hub", gravity=0.0)
    angle, t = system.coordinate("hub_angle", "rad"), system.time
    system.body("hub", inertia=HUB.inertia * u.kg * u.m**2, angle=angle)
    beam, _ = _strip(system, u, HUB, shapes, turned(angle, HUB.radius * u.m), angle)
    torque = HUB.torque * u.newton * u.m * ca.sin(2 * ca.pi * t / (HUB.period * u.s))
    system.load("motor", angle, ca.if_else(t < HUB.period * u.s, torque, 0 * u.newton * u.m))
    end = beam.end()
    system.output("tip_x", end[0], "m")
    system.output("tip_y", end[1], "m")
    system.output("tip_deflection", ca.cos(angle) * end[1] - ca.sin(angle) * end[0], "m")
    system.output("angle", angle, "rad")
    found = _moved(system, {}, HUB.duration, rows)
    return found | {"hub_angle": found.pop("angle")}


def moving_load(rows: int, shapes: int = 20, sines: bool = True) -> Columns:
    """A mass rolls along a beam; sines, or polynomials that vanish at both supports."""
    system, u = _system("moving load", gravity=0.0)
    length, eta = BRIDGE.length * u.m, system.amplitudes("eta", shapes, "m", size=1e-3)

    def deflection(x: Any) -> Any:
        z = 2 * x / length - 1
        of = (
            [ca.sin((k + 1) * ca.pi * x / length) for k in range(shapes)] if sines else [(1 - z**2) * each for each in _legendre(z, shapes)]
        )
        return sum((eta[k] * each for k, each in enumerate(of)), 0 * z)

    beam = Beam(
        system, "bridge", origin=vector(0, 0), angle=0, edges=[0, length], points=2 * shapes + 4, deflection=deflection,
        foreshortening=False,
        mass_per_length=BRIDGE.mass * u.kg / u.m, bending_stiffness=BRIDGE.bending * u.newton * u.m**2,
    )  # fmt: skip
    contact = beam.place(BRIDGE.speed * u.m / u.s * system.time)
    system.body("load", BRIDGE.load * u.kg, contact)
    system.load("weight", contact, vector(0, -BRIDGE.load * G * u.newton))
    system.output("middle_y", deflection(length / 2), "m")
    system.output("quarter_y", deflection(length / 4), "m")
    system.output("load_y", contact[1], "m")
    return _moved(system, {}, BRIDGE.duration, rows)


def bead(rows: int) -> Columns:
    """A bead on a rod that swings, held by a spring."""
    system, u = _system("bead")
    angle, r = system.coordinate("angle", "rad"), system.coordinate("place", "m", guess=0.5)
    mass, length = BEAD.rod * u.kg, BEAD.length * u.m
    system.body("rod", mass, turned(angle, length / 2), mass * length**2 / 12, angle)
    system.body("bead", BEAD.bead * u.kg, turned(angle, r))
    system.spring("spring", r - length / 2, BEAD.stiffness * u.newton / u.m)
    system.output("rod_angle", angle, "rad")
    system.output("rod_speed", system.rate(angle), "rad/s")
    system.output("bead_place", r, "m")
    return _moved(system, {"place": BEAD.place}, BEAD.duration, rows, 1e-11)


def _begun(system: System, u: _Units, values: Any) -> Any:
    """The angle of what turns from rest to a steady speed within the time `ramp`."""
    t, ramp, speed = system.time, values.ramp * u.s, values.speed / u.s
    period = ramp / (2 * ca.pi)
    return ca.if_else(t < ramp, speed / ramp * (t**2 / 2 + period**2 * (ca.cos(t / period) - 1)), speed * (t - ramp / 2))


def spin_up(rows: int, shapes: int = 6) -> Columns:
    """A beam on a base that begins to turn."""
    system, u = _system("spin-up", gravity=0.0)
    angle = _begun(system, u, SPIN_UP)
    end = _strip(system, u, SPIN_UP, shapes, vector(0, 0), angle)[0].end()
    for name, value in (("tip_x", end[0]), ("tip_y", end[1]), ("tip_deflection", ca.cos(angle) * end[1] - ca.sin(angle) * end[0])):
        system.output(name, value, "m")
    return _moved(system, {}, SPIN_UP.duration, rows)


def slider_crank(rows: int, shapes: int = 8) -> Columns:
    """A rod that bends between a driven crank and a block."""
    system, u = _system("slider-crank", gravity=0.0)
    turn = _begun(system, u, CRANK)
    rod, x = system.coordinate("rod", "rad"), system.coordinate("block", "m", guess=CRANK.length)
    beam, _ = _strip(system, u, CRANK, shapes, turned(turn, CRANK.crank * u.m), rod)
    system.body("block", CRANK.block * u.kg, vector(x, 0))
    system.loop("pin", beam.end() - vector(x, 0), gives=[rod, x])
    chord = beam.end() - beam.origin
    across = beam.end(0) - (beam.origin + beam.end()) / 2
    system.output("block_x", x, "m")
    system.output("middle_x", beam.end(0)[0], "m")
    system.output("middle_y", beam.end(0)[1], "m")
    system.output("bow", (chord[0] * across[1] - chord[1] * across[0]) / ca.norm_2(chord), "m")
    return _moved(system, {}, CRANK.duration, rows)


def double_four_bar(rows: int) -> Columns:
    """Five equal rods; all of them are in line now and then."""
    system, u = _system("double four-bar")
    length, mass = FOUR_BAR.length * u.m, FOUR_BAR.mass * u.kg
    inertia, pivots = mass * length**2 / 12, [vector(k * length, 0) for k in range(3)]
    arms = [system.coordinate(f"arm_{k}", "rad", guess=np.pi / 2) for k in range(3)]
    for k, (pivot, arm) in enumerate(zip(pivots, arms, strict=True)):
        system.body(f"arm {k}", mass, pivot + turned(arm, length / 2), inertia, arm)
    for k in range(2):
        coupler, begin = system.coordinate(f"coupler_{k}", "rad"), pivots[k] + turned(arms[k], length)
        system.body(f"coupler {k}", mass, begin + turned(coupler, length / 2), inertia, coupler)
        system.loop(
            f"loop {k}", begin + turned(coupler, length) - pivots[k + 1] - turned(arms[k + 1], length), gives=[coupler, arms[k + 1]]
        )
    tip = turned(arms[0], length)
    for name, value, unit in zip(
        ("tip_x", "tip_y", "tip_vx", "tip_vy"),
        (tip[0], tip[1], system.rate(tip[0]), system.rate(tip[1])),
        ("m", "m", "m/s", "m/s"),
        strict=True,
    ):
        system.output(name, value, unit)
    return _moved(system, {"arm_0": np.pi / 2, "arm_0_rate": FOUR_BAR.rate}, FOUR_BAR.duration, rows, 1e-10)
