"""Machines drawn at random such as an engineer would bring, for checks that must not know the machine beforehand.

Kept are those that are sensible by the criteria of `random_scenes` and whose first bending frequency is five times the crank's or more.
"""

import dataclasses
import itertools
import math
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any, Final

import numpy as np
from numpy.random import Generator

from quickreturn.reference_model.follower import Follower
from quickreturn.reference_model.mechanism import Base, Crank, FollowerAlone, Mechanism, PrescribedSpeed, SpinUp, TorqueDrive
from quickreturn.reference_model.natural_modes import stiffness_ratio
from quickreturn.reference_model.rigid import crank_pace, static_deflection
from quickreturn.reference_model.slider import Slider
from quickreturn.reference_model.tip import Tip
from tests.verification.random_scenes import LEAST_STIFFNESS_RATIO, Scene, judged, log_uniform

MACHINE_DURATION: Final = 2.0  # s
COMBINED_DURATION: Final = 1.0  # s
BRAKED_DURATION: Final = 0.5  # s

#: Young's modulus (Pa), density (kg/m^3).
MATERIALS: Final = {"steel": (210e9, 7850.0), "aluminium": (70e9, 2700.0), "plastic": (3e9, 1200.0)}


def _machine(generator: Generator) -> Mechanism:
    """A machine such as an engineer would bring.

    Stroke of the tip 30 mm to 1.5 m, arm of steel, aluminium or plastic, 10 to 300 times as long as thick, crank at 5 to 600 rpm, tip body
    of 0 to 5 times the arm's mass, driven and prescribed. No gravity: under its own weight a straight start rings for thousands of cycles,
    and their phase is known to no model.
    """
    uniform, between = generator.uniform, partial(log_uniform, generator)

    stroke, swing, reach = between(0.03, 1.5), uniform(0.15, 0.6), uniform(0.6, 0.97)
    length = stroke / (2.0 * swing)  # the tip swings by asin(crank length / pivot distance) to either side
    pivot_distance = reach * length / (1.0 + swing)
    crank_length = swing * pivot_distance
    modulus, density = MATERIALS[generator.choice(tuple(MATERIALS))]
    thickness = length / between(10.0, 300.0)
    width = thickness * uniform(1.0, 5.0)
    mass_per_length, bending_stiffness = density * width * thickness, modulus * width * thickness**3 / 12.0
    arm = mass_per_length * length
    tip_mass = arm * uniform(0.0, 5.0) if uniform() < 0.75 else 0.0
    speed = between(5.0, 600.0) * math.pi / 30.0 * (1.0 if uniform() < 0.8 else -1.0)
    base_inertia = 0.01 * arm * length**2 * uniform(0.0, 1.0)
    # half to thirty times what the follower's inertia amounts to at the crank, turning on within 0.3 to 3 time constants a cycle
    inertia = between(0.5, 30.0) * (arm / 3.0 + tip_mass) * length**2 * swing**2
    damping = inertia * abs(speed) / (2.0 * math.pi) * between(0.3, 3.0)
    prescribed = uniform() < 0.5
    # 0.2 to 3 % of critical in the first bending vibration of a clamped arm, about
    rate = 3.52 * math.sqrt(bending_stiffness / mass_per_length) / length**2
    return Mechanism(
        pivot_distance=pivot_distance,
        crank=Crank(
            length=crank_length,
            drive=PrescribedSpeed(speed=speed) if prescribed else TorqueDrive(torque=damping * speed, damping=damping, initial_speed=speed),
            inertia=inertia,
        ),
        base=Base(inertia=base_inertia),
        follower=Follower(
            length=length,
            mass_per_length=mass_per_length,
            bending_stiffness=bending_stiffness,
            thickness=thickness,
            width=width,
            damping=2.0 * between(0.002, 0.03) * rate * mass_per_length,
            strain_gauges=(0.25 * length, 0.5 * length, 0.75 * length),
        ),
        tip=Tip(mass=tip_mass, inertia=tip_mass * (length * uniform(0.01, 0.08)) ** 2) if tip_mass else None,
    )


def _with_everything(generator: Generator) -> Mechanism:
    """A machine with all that can act on it.

    A slider with mass and in half of them with inertia, a compliant joint in half of them, 30 to 3000 times as stiff as the follower, a
    force on the tip over a part of the turn in half of them, gravity in most; the follower's damping is 0.2 to 300 % of critical.
    """
    machine, uniform, between = _machine(generator), generator.uniform, partial(log_uniform, generator)

    follower = machine.follower
    arm, length = follower.mass_per_length * follower.length, follower.length
    rate = 3.52 * math.sqrt(follower.bending_stiffness / follower.mass_per_length) / length**2
    stiffness = 3.0 * follower.bending_stiffness / length**3
    slider = Slider(
        mass=arm * uniform(0.0, 0.5),
        inertia=arm * (length * uniform(0.005, 0.03)) ** 2 if uniform() < 0.5 else 0.0,
        joint_stiffness=stiffness * between(30.0, 3000.0) if uniform() < 0.5 else math.inf,
    )
    tip = machine.tip or Tip(mass=arm * uniform(0.1, 1.0), inertia=arm * (length * uniform(0.01, 0.08)) ** 2)
    if uniform() < 0.5:
        force, direction = stiffness * length * between(1e-4, 1e-2), uniform(0.0, 2.0 * math.pi)
        acting: dict[str, Any] = {"force_from": math.pi - 1.5, "force_to": math.pi + 1.0, "force_ramp": 0.3}
        tip = dataclasses.replace(tip, force=(force * math.cos(direction), force * math.sin(direction)), **acting)
    weight, direction = 9.81 if uniform() < 0.6 else 0.0, uniform(0.0, 2.0 * math.pi)
    return dataclasses.replace(
        machine,
        slider=slider,
        tip=tip,
        gravity=(weight * math.cos(direction), weight * math.sin(direction)),
        follower=dataclasses.replace(follower, damping=2.0 * between(0.002, 3.0) * rate * follower.mass_per_length),
    )


def _braked(generator: Generator) -> Mechanism:
    """A machine with all that can act on it, whose pivot is braked and hardly has inertia.

    The damper lets the arm turn at its base in 0.1 to 100 % of the time of its first vibration, friction bends it by 1 to 30 % of its
    static deflection; there is one or the other, or both. Base inertia is 0 in half of them, else 1e-6 to 1e-3 times the arm's mass times
    its length squared.
    """
    machine, uniform, between = _with_everything(generator), generator.uniform, partial(log_uniform, generator)

    follower, pace = machine.follower, crank_pace(machine)
    length, arm = follower.length, follower.mass_per_length * follower.length
    # a moment at the base deflects the tip by about M L^2 / (3 EI)
    bending = 3.0 * follower.bending_stiffness / length**2 * static_deflection(machine, pace)
    rate = 3.52 * math.sqrt(follower.bending_stiffness / follower.mass_per_length) / length**2
    kind = generator.choice(("damping", "friction", "both"))
    return dataclasses.replace(
        machine,
        base=Base(
            inertia=arm * length**2 * between(1e-6, 1e-3) if uniform() < 0.5 else 0.0,
            damping=0.0 if kind == "friction" else 3.0 * follower.bending_stiffness / (length * rate) * between(1e-3, 1.0),
            friction_torque=0.0 if kind == "damping" else bending * between(0.01, 0.3),
        ),
        slider=dataclasses.replace(machine.slider, inertia=0.0),  # which no engine models that shares no equations with `reference`
        follower=_gauged_at_the_ends(follower, generator),
    )


def _gauged_at_the_ends(follower: Follower, generator: Generator) -> Follower:
    """The follower with a gauge within 3 % of either end and one between."""
    length, uniform = follower.length, generator.uniform
    gauges = length * uniform(0.001, 0.03), length * uniform(0.3, 0.7), length * uniform(0.97, 0.995)
    return dataclasses.replace(follower, strain_gauges=gauges)


def _loaded(generator: Generator) -> Mechanism:
    """A machine with all that can act on it, which works against a load.

    The base's damping takes some 5 to 60 % of what the crank's does; half of the arms have material damping, 0.2 to 10 % of critical in the
    first vibration; the tip body's centre is up to a tenth of the length inside or beyond the end; a third are without a tip body.
    """
    machine, uniform, between = _with_everything(generator), generator.uniform, partial(log_uniform, generator)

    drive = machine.crank.drive
    follower = _gauged_at_the_ends(machine.follower, generator)
    length = follower.length
    rate = 3.52 * math.sqrt(follower.bending_stiffness / follower.mass_per_length) / length**2
    damping = machine.base.damping
    if isinstance(drive, TorqueDrive):  # the base swings at up to the crank's pace over (pivot distance / crank length - 1)
        swing = machine.crank.length / (machine.pivot_distance - machine.crank.length)
        damping = drive.damping * between(0.05, 0.6) / swing**2
    tip = machine.tip if uniform() < 0.67 else None
    return dataclasses.replace(
        machine,
        base=dataclasses.replace(machine.base, damping=damping),
        slider=dataclasses.replace(machine.slider, inertia=0.0),  # as in `_braked`
        follower=dataclasses.replace(follower, material_damping=2.0 * between(2e-3, 0.1) / rate if uniform() < 0.5 else 0.0),
        tip=dataclasses.replace(tip, center_of_mass=length * uniform(-0.1, 0.1)) if tip else None,
    )


def _with_heavy_ends(generator: Generator) -> Mechanism:
    """A machine whose bodies at the ends bend the arm there.

    A tip body of 0.3 to 3 times the arm's mass, with its centre up to a sixth of the length beyond the end and a radius of gyration of 3 to
    20 % of it; a base with up to a tenth of the arm's inertia and, in half of them, damping.
    """
    machine, uniform = _machine(generator), generator.uniform
    length = machine.follower.length
    arm = machine.follower.mass_per_length * length
    mass, radius = arm * uniform(0.3, 3.0), length * uniform(0.03, 0.2)
    inertia = arm * length**2
    damping = 0.3 * inertia * abs(crank_pace(machine)) * uniform() if uniform() < 0.5 else 0.0
    return dataclasses.replace(
        machine,
        tip=Tip(mass=mass, inertia=mass * radius**2, center_of_mass=length * uniform(0.0, 1.0 / 6.0)),
        base=Base(inertia=inertia * uniform(0.0, 0.1), damping=damping),
    )


def _turning(generator: Generator) -> Mechanism:
    """A machine whose follower turns fully: crank and distance of the pivots are exchanged, the slider covers the same part of the arm."""
    machine = _machine(generator)
    crank = dataclasses.replace(machine.crank, length=machine.pivot_distance)
    return dataclasses.replace(machine, pivot_distance=machine.crank.length, crank=crank)


def _stiff_enough(name: str, duration: float, draw: Callable[[Generator], Mechanism], *stream: int) -> Callable[[int], Iterator[Scene]]:
    """By a seed: sensible scenes whose first bending frequency is `LEAST_STIFFNESS_RATIO` times the crank's or more, without end."""

    def machines(seed: int) -> Iterator[Scene]:
        generator, numbers = np.random.default_rng([seed, *stream]), itertools.count(1)
        sensible = (
            judged("", each, duration) for each in iter(lambda: draw(generator), None) if stiffness_ratio(each) >= LEAST_STIFFNESS_RATIO
        )
        return (dataclasses.replace(scene, name=name.format(next(numbers))) for scene in sensible if scene is not None)

    return machines


sensible_machines = _stiff_enough("machine-{:03d}", MACHINE_DURATION, _machine)
turning_machines = _stiff_enough("turning-{:02d}", MACHINE_DURATION, _turning, 13)
heavy_ends = _stiff_enough("heavy-{:03d}", MACHINE_DURATION, _with_heavy_ends, 11)
combined_machines = _stiff_enough("combined-{:02d}", COMBINED_DURATION, _with_everything, 7)
braked_machines = _stiff_enough("braked-{:02d}", BRAKED_DURATION, _braked, 11)
loaded_machines = _stiff_enough("loaded-{:02d}", BRAKED_DURATION, _loaded, 17)


def arms_alone(seed: int) -> Iterator[FollowerAlone]:
    """Arms of `loaded_machines` that a prescribed angle of their base spins up, without end, the same ones for the same seed."""
    generator = np.random.default_rng([seed, 19])
    while True:
        machine = _loaded(generator)
        follower = machine.follower
        pace = 3.52 * math.sqrt(follower.bending_stiffness / follower.mass_per_length) / follower.length**2
        yield FollowerAlone(
            spin_up=SpinUp(speed=pace * log_uniform(generator, 0.02, 0.5), time=2.0 * math.pi / pace * log_uniform(generator, 1.0, 10.0)),
            base=machine.base,
            follower=follower,
            tip=dataclasses.replace(machine.tip, force=(0.0, 0.0)) if machine.tip else None,
        )
