"""Scenes with everything that the one beam has, slider constraints of every kind, and shapes that stay."""

import math
from dataclasses import replace
from typing import Final

import numpy as np

from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.entries import KERNEL
from quickreturn.reference_model.joint import CHORDS, LEVER, MULTIPLIER, ROLLERS, Rollers, SliderConstraint
from quickreturn.reference_model.mechanism import Mechanism, PrescribedSpeed
from quickreturn.reference_model.model import BeamModel
from quickreturn.reference_model.shapes import ShapeSet, clamped_free_modes, hermite_elements
from quickreturn.reference_model.slider import Slider
from quickreturn.reference_model.spring import Spring
from tests.engines.scenes import FOLLOWER_ALONE, INCH, run_24

EVERYTHING: Final = run_24(
    gravity=(3.0, -9.81),
    slider=Slider(mass=0.1, inertia=3e-4),
    tip={"center_of_mass": 0.0127, "force": (8.0, -5.0), "force_from": 0.7, "force_to": 5.2, "force_ramp": 1.1},
    follower={"damping": 2.0},
    base={"damping": 0.02},
)
#: Elements carry no slider with rotary inertia: their curvature jumps at the nodes.
ON_ELEMENTS: Final = replace(EVERYTHING, slider=Slider(mass=0.1))
#: With all frictions, at speeds over which they change; and with a material that damps, and a tool's force that turns with the end.
RUBBING: Final = replace(
    EVERYTHING,
    tip=replace(EVERYTHING.tip_body, friction_force=3.0, friction_speed=4.0),
    slider=replace(EVERYTHING.slider, friction=0.3, friction_force=2.0, friction_speed=1.5),
    base=replace(EVERYTHING.base, friction_torque=0.2),
)
DAMPED: Final = replace(
    RUBBING,
    tip=replace(RUBBING.tip_body, force=(0.0, 0.0), force_following=(8.0, -5.0), force_from=0.0, force_to=2.0 * math.pi),
    follower=replace(RUBBING.follower, material_damping=3e-4),
)
#: Held by a spring at a place that the slider passes, with a stop that is touched in some of the states.
HELD_BY_SPRING: Final = replace(
    DAMPED,
    spring=Spring(
        stiffness=300.0, anchor=(0.1, -0.3), place=0.43, preload=4.0, preload_length=0.25, damping=3.0, longest=0.3, stop_stiffness=2e3
    ),
)
BARE: Final = run_24(tip=None, base={"inertia": 0.0, "damping": 0.0}, follower={"damping": 0.0}, crank={"length": 6.0 * INCH})
ALONE: Final = replace(
    FOLLOWER_ALONE,
    base=replace(FOLLOWER_ALONE.base, friction_torque=0.3),
    follower=replace(FOLLOWER_ALONE.follower, strain_gauges=(0.15, 0.42, 0.6)),
)
SPRING: Final = Rollers(plus=2e3, minus=2e3, damping=8.0)
COMPLIANT: Final = SliderConstraint(kind=ROLLERS, rollers=SPRING)
HEAVY: Final = SliderConstraint(kind=ROLLERS, rollers=SPRING, inertia=0.05)
#: Rollers that differ in all, apart or pressed together by more than any of the states opens them, and with an inertia beside them.
APART: Final = SliderConstraint(
    kind=ROLLERS, rollers=Rollers(plus=4e3, minus=9e3, plus_from=5e-4, minus_from=4e-4, loss=0.1, damping=3.0), inertia=0.02
)
PRELOADED: Final = SliderConstraint(kind=ROLLERS, rollers=Rollers(plus=2e3, minus=5e3, plus_from=-5e-3, minus_from=-2e-3, loss=0.1))
FREE: Final = SliderConstraint(kind=ROLLERS, rollers=Rollers(plus=4e3, minus=9e3, plus_from=2e-2, minus_from=2e-2, loss=0.9, damping=3.0))
BY_FORCE: Final = SliderConstraint(kind=MULTIPLIER, stabilization=80.0)
BY_LEVER: Final = SliderConstraint(kind=LEVER, stabilization=60.0, bending_damping=2e-4)
ON_CHORDS: Final = SliderConstraint(kind=CHORDS, stabilization=40.0)


def rates(model: BeamModel, y: Array) -> Array:
    """dy/dt by the compiled equations; fills the workspace."""
    rate = np.zeros_like(y)
    p, w = model._at
    assert KERNEL(p.address, w.address, y.ctypes.data, rate.ctypes.data)
    return rate


def at_constant_speed(mechanism: Mechanism) -> Mechanism:
    return replace(mechanism, crank=replace(mechanism.crank, drive=PrescribedSpeed(speed=17.0)))


def modes_of(mechanism: Mechanism, count: int) -> ShapeSet:
    return clamped_free_modes(mechanism.follower.length, count)


def elements_of(mechanism: Mechanism, count: int) -> ShapeSet:
    return hermite_elements(mechanism.follower.length, count)
