"""Checks of a clamped rod's rows: strains at rest against the closed form, and the end's acceleration against its deflection."""

import math
from typing import Final

import numpy as np
from scipy.integrate import cumulative_trapezoid

from quickreturn.cases.conformance.bench import TOLERANCE_FACTOR, Bench, Motion
from quickreturn.cases.conformance.checks import Fault
from quickreturn.cases.conformance.clamped import ring
from quickreturn.cases.mistakes.diagnosis import share_of
from quickreturn.engines.rod import RodEngine
from quickreturn.reference_model.mechanism import FollowerAlone

#: Error of a strain near the free end over that of the tip deflection, part that may be off besides, and of an engine without a claim.
_HARDER: Final = 3.0
_FLOOR: Final = 0.01
_UNCLAIMED: Final = 0.5
#: Range of the factor between the integral of the acceleration and the velocity, and part of gravity that its mean may be off. The rows are
#: too far apart for the fastest vibrations of a fine, undamped rod, which add up to 0.4 of it, and 0.01 g, in the ladders of four rods.
_FACTOR: Final = (0.6, 1.5)
_OF_GRAVITY: Final = 0.2
#: Part by which a mean acceleration may miss gravity, where gravity is what it lacks.
_NEAR: Final = 0.05


def strains(bench: Bench, motion: Motion) -> str:
    """Check where the three strains come to rest."""
    if isinstance(bench.engine, RodEngine):
        return "they are differences of the rod's points, which the sags and frequencies hold"
    scene, run = motion.scene, bench.run(motion)
    assert isinstance(scene, FollowerAlone)
    beam, worst = scene.follower, 0.0
    allowed = _FLOOR + TOLERANCE_FACTOR * _HARDER * bench.engine.default_accuracy if bench.claims else _UNCLAIMED
    for k, place in enumerate(beam.strain_gauges, 1):
        moment = scene.gravity[1] * beam.mass_per_length * (beam.length - place) ** 2 / 2.0
        times = ring(run[f"strain_{k}"], motion.output_step).rest * beam.bending_stiffness / (moment * beam.extreme_fibre)
        if abs(times - 1.0) > allowed:
            cause = f"strain_{k} comes to rest at {times:.4g} times the closed form"
            raise Fault(cause, "it is the curvature times the distance of the surface from the axis of bending, positive where W'' > 0")
        worst = max(worst, abs(times - 1.0))
    return f"off by {share_of(worst)}"


def acceleration(bench: Bench, motion: Motion) -> str:
    """Check that the acceleration of the end, integrated, is the rate of its deflection."""
    run, h = bench.run(motion), motion.output_step
    velocity = np.gradient(run["tip_deflection"], h)[1:-1]  # differences are one-sided at the ends
    integral = cumulative_trapezoid(run["tip_acceleration"], dx=h, initial=0.0)[1:-1]
    slope = float(np.polyfit(run["time"][1:-1], integral - velocity, 1)[0])
    gravity = math.hypot(*motion.scene.gravity)
    if abs(slope) > _OF_GRAVITY * gravity:
        lacks = "it lacks gravity, as an accelerometer does: add it" if abs(abs(slope) - gravity) < _NEAR * gravity else "look at its frame"
        raise Fault(f"tip_acceleration is {slope:.3g} m/s^2 too large on average", lacks)
    if not np.any(velocity):
        raise Fault("tip_deflection does not change", "it is the end's displacement along the base's normal, in m")
    times = float(integral @ velocity / (velocity @ velocity))
    if not _FACTOR[0] < times < _FACTOR[1]:
        cause = f"tip_acceleration is {times:.3g} times the second derivative of tip_deflection"
        raise Fault(cause, "it is that of the end along the rod's normal there, in m/s^2")
    return f"its integral is {times:.3g} times the rate of tip_deflection"
