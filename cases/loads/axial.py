"""The normal force along the whole arm, from the columns of a trajectory; tension is positive.

An engine gives it at the base, on either side of the slider, and at the flexible end. Between two of these places, a and b, it is that of a
rigid arm through both values, with the weight w of a length along the arm; c follows from the value at b:

    N(x) = N(a) - w (x - a) + c (x^2 - a^2)

A bent arm departs from this: its tangent turns into the direction of the shear force, and its points move along it. Both are of the second
order in the deflection, and at most about the shear force times the angle by which the tangent turns: that is the error claimed between the
given places. Beside the stress of bending it is small: of the order of thickness times deflection over the square of the length.
"""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from quickreturn.cases.loads.arm import KnownMoments
from quickreturn.cases.loads.peak import ErrorAt, of_column
from quickreturn.cases.motion.number import Number
from quickreturn.reference_model.columns import AXIAL
from quickreturn.reference_model.mechanism import Scene

Array = NDArray[np.float64]


def is_known(scene: Scene, columns: Mapping[str, Array]) -> bool:
    """Whether an engine gives the normal force."""
    return {name for name in AXIAL if scene.crank is not None or name in ("axial_base", "axial_tip")} <= set(columns)


def axial_stress(scene: Scene, columns: Mapping[str, Array], claim: ErrorAt) -> Number | None:
    """Largest magnitude of the stress by the normal force, Pa: at one of the places where it is given; None where it is not known."""
    if not is_known(scene, columns):
        return None
    peaks = [peak for name in AXIAL if (peak := of_column(name, columns, claim)) is not None]
    return max(peaks, key=lambda peak: peak.value).times(1.0 / scene.follower.section.area())


def axial_forces(scene: Scene, columns: Mapping[str, Array], known: KnownMoments, x: Array) -> tuple[Array, Array]:
    """Normal force at arc lengths `x` (m, shape (m,)), N, and its interpolation error, shape (rows, m) each; zeros where it is not known.

    Args:
        scene: gives the mass of the arm, and gravity.
        columns: of the rows of `known`.
        known: the moments, which give the shear force and how far the tangent turns.
        x: places.
    """
    shape = (known.slider.size, x.size)
    if not is_known(scene, columns):
        return np.zeros(shape), np.zeros(shape)
    follower, angle = scene.follower, columns["follower_angle"]
    weight = follower.mass_per_length * (scene.gravity[0] * np.cos(angle) + scene.gravity[1] * np.sin(angle))[:, None]
    base, tip = columns["axial_base"], columns["axial_tip"]
    step, at = (np.zeros(base.size), 0.0) if known.pull is None else (known.pull.real, known.spring)  # of a spring, inboard of its place
    of_slider = np.where(known.slider < at, step, 0.0)
    begin, slider, end = np.zeros(base.size), np.minimum(known.slider, known.length), np.full(base.size, known.length)

    def between(a: Array, at_a: Array, b: Array, at_b: Array) -> Array:
        a, at_a, b, at_b = (each[:, None] for each in (a, at_a, b, at_b))
        square, change = b**2 - a**2, at_b - at_a + weight * (b - a)
        return at_a - weight * (x - a) + np.divide(change, square, out=np.zeros_like(change), where=square > 0.0) * (x**2 - a**2)

    inboard = between(begin, base - step, slider, columns.get("axial_inboard", tip) - of_slider)
    outboard = between(slider, columns.get("axial_slider", tip) - of_slider, end, tip)
    shear = np.abs(np.diff(known.twelfths, axis=1)).max(axis=1) / known.spacing
    turned = np.abs(known.twelfths).sum(axis=1) * known.spacing / follower.bending_stiffness
    left_out = shear * turned
    left_out = np.maximum(left_out, np.sqrt(np.mean(left_out**2)))  # the shear force passes through zero
    return np.where(x <= slider[:, None], inboard, outboard) + np.where(x < at, step[:, None], 0.0), np.broadcast_to(
        left_out[:, None], shape
    )
