"""Scenes drawn at random around the thesis' mechanism, for checks that must not know the scene beforehand, and which scenes are sensible.

Every quantity is drawn, most of them over a factor of three to thirty or more. Kept are sensible scenes: the slider stays on the follower's
inner 98 %, the tip deflects by less than an eighth of the follower's length, and the motion is well conditioned. Violent scenes are
not: they magnify a change of the bending stiffness so much that models of any fineness disagree by more than they err.
"""

import dataclasses
import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from typing import Final

import numpy as np
from numpy.random import Generator

from quickreturn.cases.files.case import Case
from quickreturn.engines.base import EngineFailure
from quickreturn.engines.one_run import run_once
from quickreturn.engines.own.reference import ReferenceEngine, ReferenceSettings
from quickreturn.engines.start import standard_start
from quickreturn.engines.trajectory import Trajectory
from quickreturn.reference_model.follower import Follower
from quickreturn.reference_model.mechanism import Base, Crank, Mechanism, PrescribedSpeed, TorqueDrive
from quickreturn.reference_model.natural_modes import stiffness_ratio
from quickreturn.reference_model.slider import Slider
from quickreturn.reference_model.tip import Tip

OUTPUT_STEP: Final = 1e-3  # s
LARGEST_SLIDER_POSITION: Final = 0.98  # of the follower's length
LARGEST_DEFLECTION: Final = 0.125  # of the follower's length
LARGEST_CONDITION: Final = 50.0  # run 24 has 13 over 2 s; at twice its crank speed 80
LEAST_STIFFNESS_RATIO: Final = 5.0  # first bending frequency over the crank's; run 24 has 4.1

#: Judges whether a scene around the thesis' mechanism is sensible; a few percent of error do no harm there.
_JUDGE: Final = ReferenceSettings(modes=4, tolerance=1e-7)
#: Judges the others: fewer modes do where the follower is stiff.
_ACCURACY: Final = 1e-3
_STIFFNESS_CHANGE: Final = 1e-3


@dataclass(frozen=True)
class Scene:
    """A scene to simulate from the standard start."""

    name: str  # says where it was drawn
    mechanism: Mechanism  # the scene
    duration: float  # s, a multiple of `OUTPUT_STEP`
    condition: float  # relative change of the tip deflection (RMS over the duration) per relative change of the bending stiffness
    largest_deflection: float  # of the tip, m

    @property
    def case(self) -> Case:
        """The case that it makes."""
        return Case(name=self.name, title="", tags=(), scene=self.mechanism, duration=self.duration, output_step=OUTPUT_STEP)


def random_scenes(seed: int) -> Iterator[Scene]:
    """Sensible scenes without end, the same ones for the same seed."""
    generator, number = np.random.default_rng(seed), 0
    while True:
        mechanism, duration = _mechanism(generator), _duration(generator)
        scene = judged(f"random-{number + 1:02d}", mechanism, duration)
        if scene is not None:
            number += 1
            yield scene


def condition_of(mechanism: Mechanism, duration: float, output_step: float = OUTPUT_STEP) -> tuple[float, Trajectory]:
    """Condition of a scene (see `Scene.condition`) and its motion with few modes."""
    stiffness = (1.0 + _STIFFNESS_CHANGE) * mechanism.follower.bending_stiffness
    changed = dataclasses.replace(mechanism, follower=dataclasses.replace(mechanism.follower, bending_stiffness=stiffness))
    engine, start = ReferenceEngine(), standard_start(mechanism)
    judge = _JUDGE if stiffness_ratio(mechanism) < LEAST_STIFFNESS_RATIO else engine.settings_for(_ACCURACY, mechanism)
    nominal, other = (run_once(engine, each, start, duration, output_step, judge).trajectory for each in (mechanism, changed))
    size = _rms(nominal["tip_deflection"])
    return _rms(other["tip_deflection"] - nominal["tip_deflection"]) / (_STIFFNESS_CHANGE * size), nominal


def judged(name: str, mechanism: Mechanism, duration: float) -> Scene | None:
    """The scene by that name, of that duration (s), or None if it is not sensible."""
    try:
        condition, motion = condition_of(mechanism, duration)
    except EngineFailure:
        return None
    length, deflection = mechanism.follower.length, float(np.abs(motion["tip_deflection"]).max())
    sensible = (
        motion["slider_position"].max() < LARGEST_SLIDER_POSITION * length
        and deflection < LARGEST_DEFLECTION * length
        and condition < LARGEST_CONDITION
    )
    return Scene(name, mechanism, duration, condition, deflection) if sensible else None


def log_uniform(generator: Generator, low: float, high: float) -> float:
    """A number that is drawn evenly over the orders of magnitude."""
    return float(math.exp(generator.uniform(math.log(low), math.log(high))))


def _duration(generator: Generator) -> float:
    return OUTPUT_STEP * round(generator.uniform(0.5, 1.0) / OUTPUT_STEP)


def _mechanism(generator: Generator) -> Mechanism:
    """A scene whose parts fit together; the thesis' values lie within the ranges."""
    uniform, between = generator.uniform, partial(log_uniform, generator)

    def sometimes(value: float) -> float:  # zero in half of the scenes
        return value if uniform() < 0.5 else 0.0

    length = uniform(0.5, 0.8)
    pivot_distance = uniform(0.68, 0.76) * length
    crank_length = uniform(0.3, 0.98) * (0.97 * length - pivot_distance)
    speed = uniform(3.0, 18.0) * (1.0 if uniform() < 0.8 else -1.0)
    gravity, direction = sometimes(9.81), uniform(0.0, 2.0 * math.pi)
    # a flywheel whose centre of mass is off the axis would swing under gravity rather than turn
    mass, center, inertia = between(2.0, 20.0), 0.0 if gravity else uniform(0.0, 0.1), between(0.03, 0.3)
    damping = between(0.02, 0.2)
    torque = TorqueDrive(torque=speed * damping, damping=damping, initial_speed=speed * uniform(0.9, 1.1))
    prescribed = uniform() < 0.25
    tip_mass, radius = between(0.01, 0.15), between(0.002, 0.02)
    return Mechanism(
        pivot_distance=pivot_distance,
        crank=Crank(
            length=crank_length,
            drive=PrescribedSpeed(speed=speed) if prescribed else torque,
            mass=mass,
            center_of_mass=center,
            inertia=inertia,
            # elsewhere than at a dead centre the straight start is a sudden load, which excites every mode
            initial_angle=math.pi + sometimes(uniform(-math.pi, math.pi)),
        ),
        base=Base(inertia=between(5e-6, 5e-5), damping=sometimes(between(1e-6, 1e-4))),
        follower=Follower(
            length=length,
            mass_per_length=between(0.15, 0.7),
            bending_stiffness=between(2.0, 25.0),
            thickness=uniform(0.0015, 0.005),
            width=0.0381,
            damping=sometimes(between(0.03, 1.0)),
            strain_gauges=(0.25 * length, 0.5 * length, 0.75 * length),
        ),
        tip=Tip(mass=tip_mass, inertia=tip_mass * radius**2, center_of_mass=sometimes(uniform(0.0, 0.03))) if uniform() < 0.8 else None,
        slider=Slider(mass=sometimes(between(0.01, 0.3))),
        gravity=(gravity * math.cos(direction), gravity * math.sin(direction)),
    )


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))
