"""Rigid linkages described for `quickreturn.derive`, and their motion by quadrature of the energy: no equation of the program is in it."""

from collections.abc import Callable
from typing import Any

import casadi as ca
import numpy as np
from scipy.integrate import quad, solve_ivp

from quickreturn.derive import System, turned, vector

G = 9.81


def units(system: System) -> Any:
    """One metre, kilogram and second: factors that give numbers a unit."""
    return system.constants(m=(1.0, "m"), kg=(1.0, "kg"), s=(1.0, "s"))


def parallelograms(lengths: list[float], masses: list[float], arm: float, arm_mass: float) -> System:
    """A row of parallelograms: uniform arms, one more than couplers of given lengths (m) and masses (kg). All rods can be in line."""
    system = System("parallelograms")
    system.gravity = vector(0, -G)
    u, at, arms = units(system), 0.0, []
    arm, arm_mass = arm * u.m, arm_mass * u.kg
    for k in range(len(lengths) + 1):
        angle = system.coordinate(f"arm_{k}", "rad", guess=1.0)
        system.body(f"arm {k}", arm_mass, vector(at, 0) + turned(angle, arm / 2), arm_mass * arm**2 / 12, angle)
        arms.append((at, angle))
        at += lengths[min(k, len(lengths) - 1)] * u.m
    for k, (length, mass) in enumerate((length * u.m, mass * u.kg) for length, mass in zip(lengths, masses, strict=True)):
        (here, one), (there, other) = arms[k], arms[k + 1]
        turn = system.coordinate(f"coupler_{k}", "rad")
        begin = vector(here, 0) + turned(one, arm)
        system.body(f"coupler {k}", mass, begin + turned(turn, length / 2), mass * length**2 / 12, turn)
        gap = begin + turned(turn, length) - vector(there, 0) - turned(other, arm)
        system.loop(f"loop {k}", gap, gives=[turn, other])
    return system


def angle_of_parallelograms(masses: list[float], arm: float, arm_mass: float, start: tuple[float, float], times: Any) -> Any:
    """Angle of the arms (rad): one degree of freedom, arms about their pivots, couplers on circles."""
    inertia = (len(masses) + 1) * arm_mass * arm**2 / 3 + sum(masses) * arm**2
    moment = G * ((len(masses) + 1) * arm_mass * arm / 2 + sum(masses) * arm)
    solution = solve_ivp(
        lambda _, z: [z[1], -moment / inertia * np.cos(z[0])], (0, times[-1]), start, "DOP853", times, rtol=1e-12, atol=1e-12
    )
    return solution.y[0]


def scott_russell() -> System:
    """Two Scott-Russell linkages side by side carry a level platform: its ends move on vertical lines, at a height of 0.6 m sin(left)."""
    system = System("lift")
    system.gravity = vector(0, -G)
    u = units(system)
    half, apart, bar, platform, guess = 0.3 * u.m, u.m, 2 * u.kg, 10 * u.kg, {"left": 0.6, "right": np.pi - 0.6}
    x, y, tilt = system.coordinate("x", "m"), system.coordinate("y", "m", guess=0.34), system.coordinate("tilt", "rad")
    for side, at in (("left", 0), ("right", apart)):
        crank, turn = system.coordinate(side, "rad", guess=guess[side]), system.coordinate(f"{side}_bar", "rad", guess=np.pi - guess[side])
        foot = system.coordinate(f"{side}_foot", "m", guess=0.5)
        middle, top = vector(foot, 0) + turned(turn, half), vector(foot, 0) + turned(turn, 2 * half)
        system.loop(f"{side} crank", vector(at, 0) + turned(crank, half) - middle, gives=[turn, foot])
        system.body(f"{side} bar", bar, middle, bar * half**2 / 3, turn)
        if side == "left":
            system.loop("left top", vector(x, y) - top, gives=[x, y])
            system.spring("spring", foot - half, 400 * u.kg / u.s**2)
        else:
            system.loop("right top", y + apart * ca.sin(tilt) - top[1], gives=[tilt])
            system.loop("level", tilt, "rad", gives=[crank])
    system.body("platform", platform, vector(x, y) + turned(tilt, apart / 2), platform * apart**2 / 12, tilt)
    return system


def slider_crank(crank: float, rod: float, masses: tuple[float, float, float], free: str) -> System:
    """Crank, uniform rod and a block on n1; `free` is the coordinate that no loop gives: crank, rod or block."""
    system = System("slider-crank")
    system.gravity = vector(0, -G)
    u = units(system)
    crank, rod, masses = crank * u.m, rod * u.m, [mass * u.kg for mass in masses]
    each = {name: system.coordinate(name, unit) for name, unit in (("crank", "rad"), ("rod", "rad"), ("block", "m"))}
    pin, block = turned(each["crank"], crank), vector(each["block"], 0)
    system.body("crank", masses[0], pin / 2, masses[0] * crank**2 / 12, each["crank"])
    system.body("rod", masses[1], pin + turned(each["rod"], rod / 2), masses[1] * rod**2 / 12, each["rod"])
    system.body("block", masses[2], block)
    system.loop("pin", pin + turned(each["rod"], rod) - block, gives=[q for name, q in each.items() if name != free])
    return system


def four_bar(lengths: tuple[float, float, float, float], masses: tuple[float, float, float]) -> System:
    """Ground, crank, coupler and rocker, uniform rods; the loop gives coupler and rocker."""
    system = System("four-bar")
    u = units(system)
    ground, *rods = [length * u.m for length in lengths]
    system.gravity = vector(0, -G)
    angles = [system.coordinate(name, "rad", guess=guess) for name, guess in (("crank", 0.0), ("coupler", 0.3), ("rocker", 1.2))]
    begins = [vector(0, 0), turned(angles[0], rods[0]), vector(ground, 0)]
    for name, begin, length, mass, angle in zip(
        ("crank", "coupler", "rocker"), begins, rods, [m * u.kg for m in masses], angles, strict=True
    ):
        system.body(name, mass, begin + turned(angle, length / 2), mass * length**2 / 12, angle)
    gap = begins[1] + turned(angles[1], rods[1]) - begins[2] - turned(angles[2], rods[2])
    system.loop("loop", gap, gives=angles[1:])
    return system


#: Places of the rods' begins and ends as complex numbers, m, for a crank angle, and their derivatives by it.
Rods = Callable[[float], list[tuple[complex, complex, complex, complex]]]


def rods_of_slider_crank(crank: float, rod: float) -> Rods:
    """Crank and rod; the rod points towards +n1."""

    def rods(a: float) -> list[tuple[complex, complex, complex, complex]]:
        pin, pin_ = crank * np.exp(1j * a), 1j * crank * np.exp(1j * a)
        b = np.arcsin(-crank * np.sin(a) / rod)
        end_ = pin_ - 1j * rod * np.exp(1j * b) * crank * np.cos(a) / (rod * np.cos(b))
        return [(0, pin, 0, pin_), (pin, pin + rod * np.exp(1j * b), pin_, end_)]

    return rods


def rods_of_four_bar(ground: float, crank: float, coupler: float, rocker: float) -> Rods:
    """Crank, coupler and rocker, the joint of the two to the left of the line from the crank's end to the rocker's pivot."""

    def rods(a: float) -> list[tuple[complex, complex, complex, complex]]:
        pin, pin_ = crank * np.exp(1j * a), 1j * crank * np.exp(1j * a)
        chord = ground - pin
        c = abs(chord)
        along = (coupler**2 - rocker**2 + c**2) / (2 * c)
        joint = pin + chord / c * (along + 1j * np.sqrt(coupler**2 - along**2))
        one, other = joint - pin, joint - ground
        # the joint moves at right angles to the rocker; along the coupler as the pin
        direction = 1j * other / abs(other)
        joint_ = direction * (pin_ * np.conj(one)).real / (direction * np.conj(one)).real
        return [(0, pin, 0, pin_), (pin, joint, pin_, joint_), (ground, joint, 0, joint_)]

    return rods


def time_to(rods: Rods, masses: Any, block: float, start: tuple[float, float], angle: float) -> float:
    """Time (s) in which the crank turns from the start (rad, rad/s) to an angle, from the energy: dt = da sqrt(J / 2 (E - V)).

    `masses` of uniform rods, `block` at the last rod's end, which moves level; kg.
    """

    def energies(a: float) -> tuple[float, float]:
        inertia, potential = 0.0, 0.0
        for m, (begin, end, begin_, end_) in zip(masses, rods(a), strict=True):
            inertia += m / 3 * (abs(begin_) ** 2 + abs(end_) ** 2 + (begin_ * np.conj(end_)).real)
            potential += m * G * (begin + end).imag / 2
        return inertia + block * abs(rods(a)[-1][3]) ** 2, potential

    begun = energies(start[0])
    total = begun[0] * start[1] ** 2 / 2 + begun[1]

    def pace(a: float) -> float:
        inertia, potential = energies(a)
        return float(np.sqrt(inertia / (2 * (total - potential))))

    return abs(quad(pace, start[0], angle, epsabs=1e-13, epsrel=1e-12, limit=500)[0])
