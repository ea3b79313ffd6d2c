"""A machine about rest as a linear system: follower straight, small motions, no gravity; with the dampings of the scene.

Coordinates q are the angle of the crank (of the base for a follower alone), if a torque on it is an input, and amplitudes of shapes. The
angle turns the follower as the rigid mechanism does; the shapes are those with the crank held (with the base clamped). A straight follower
moves across itself, so that the way of the slider along it has no part in the equations:

    M q'' + D q' + K q = F u         2 T = q'.M q',  2 U = q.K q,  F_k the work of a unit input on a unit of q_k

The shapes are the lowest natural modes, and for each input a shape with which its static response is exact (a residual vector: R. R. Craig
and A. J. Kurdila, Fundamentals of Structural Dynamics, 2nd edition, Wiley 2006, chapter 17; for a torque on crank or base the response to
the inertia of the turning follower). With modes alone the zeros of transfer functions would converge slowly.
"""

import dataclasses
import math
from collections.abc import Container, Sequence
from typing import Final

import numpy as np
import scipy  # whose parts are imported when they are used
from numpy.polynomial import legendre

from quickreturn.cases.files.case import Case
from quickreturn.cases.files.keys import PATHS
from quickreturn.engines.base import Refusal
from quickreturn.plugins.linear.model import LinearModel, chosen, named_states
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.columns import COLUMNS, MOMENTS, PLACES, SHAPE
from quickreturn.reference_model.constants import constants
from quickreturn.reference_model.mechanism import Scene
from quickreturn.reference_model.natural_modes import SPARE_SHAPES, BeamModes, HeldFollower, held_follower
from quickreturn.reference_model.rigid import RigidMotion, rigid_motion, stiffness_across
from quickreturn.reference_model.scene_values import value_at
from quickreturn.reference_model.spring import Spring

#: Name -> unit of the inputs: torque of the drive on the crank, force on the flexible end across the follower (along b2), torque on the
#: follower's base at P.
INPUTS: Final = {"torque": "N m", "tool_force": "N", "base_torque": "N m"}
#: Quantities that have no linear model at rest.
FRICTION: Final = ("slider.friction", "slider.friction_force", "base.friction_torque", "tip.friction_force")
#: Part of a static response beyond the modes, relative to the whole, below which it is taken for round-off.
ROUND_OFF: Final = 1e-7


def about_rest(case: Case, inputs: str | Sequence[str], outputs: str | Sequence[str], crank_angle: float | None, modes: int) -> LinearModel:
    """The linear model about rest; arguments, the angle in rad, and errors as of `linearise`."""
    scene, of_inputs = case.scene, chosen("inputs", inputs, INPUTS, "of the inputs of a linear model")
    _check(scene, of_inputs)
    free, of_scene = ("torque" if scene.crank else "base_torque") in of_inputs, constants(scene)
    angle, about = math.nan, f"at rest with the base {'free' if free else 'clamped'}"
    if scene.crank is not None:
        angle = scene.crank.initial_angle if crank_angle is None else crank_angle
        about = f"at rest with the crank {'free about' if free else 'held at'} {math.degrees(angle):.6g} deg"
    motion = _unit_turn(scene, angle)
    place, stiffness, damping = _spring(scene, angle)
    held = held_follower(scene, float(motion.slider_position), modes + SPARE_SHAPES, stiffness)
    rigid, unit = _turned(held), np.eye(len(held.M))
    inertia = held.M @ rigid
    loads = {"torque": inertia, "tool_force": unit[held.numbering[-1][2]], "base_torque": unit[1] if scene.crank else inertia}
    frequencies, shapes = _shapes(held, np.column_stack([loads[name] for name in of_inputs]), modes)
    basis = np.column_stack([motion.follower_speed * rigid, shapes][1 - free :])
    line = BeamModes(np.empty(basis.shape[1]), scene.follower.length, held.spans, held.by_span(basis))
    crank = free * np.eye(basis.shape[1])[0]
    forces = {"torque": crank, "tool_force": _at(line, scene.follower.length), "base_torque": _at(line, 0.0, 1)}
    F = np.column_stack([forces[name] for name in of_inputs])
    M = basis.T @ held.M @ basis + of_scene["crank_inertia"] * np.outer(crank, crank)
    K = np.diag(np.r_[[0.0] * free, (2.0 * math.pi * frequencies) ** 2])
    sprung = _at(line, place)
    D = _damping(scene, motion, held, line, crank) + damping * np.outer(sprung, sprung)
    rows = _outputs(scene, motion, line, crank, (place * stiffness * sprung, place * damping * sprung, inertia @ basis), tuple(of_inputs))
    of_outputs = chosen("outputs", outputs, {name: COLUMNS[name].unit for name in rows}, f"of the outputs of the linear model {about}")
    n, width = len(M), 2 * len(M) + len(of_inputs)
    accelerations = np.linalg.solve(M, np.hstack([-K, -D, F]))
    # q, q', q'' and u by states and inputs
    everything = np.vstack([np.eye(2 * n, width), accelerations, np.eye(len(of_inputs), width, 2 * n)])
    parts = everything[n : 3 * n], np.array([rows[name] for name in of_outputs]) @ everything
    (A, B), (C, D) = (np.hsplit(both, [2 * n]) for both in parts)
    turning = (("crank_angle", "crank_speed") if scene.crank else ("follower_angle", "follower_rate")) if free else ("", "")
    states = named_states(modes, len(frequencies) - modes, *turning)
    return LinearModel(case, about, A, B, C, D, states, of_inputs, of_outputs, angle, float(frequencies[modes - 1]))


def _check(scene: Scene, inputs: Container[str]) -> None:
    """Refusal: the scene has no linear model at rest, or not with this input."""
    if key := next((key for key in FRICTION if value_at(scene, key)), None):
        off = f'--set {key}="0 {PATHS[key].unit}"'
        raise Refusal(f"{key} = {value_at(scene, key):.6g}: friction sticks at rest, which no linear model shows; leave it out by {off}")
    if scene.follower.is_rigid:
        raise Refusal("follower.bending_stiffness = inf: the linear model is that of a flexible follower; give a finite stiffness")
    if "torque" in inputs and not scene.crank_is_free:
        why = "crank.prescribed_speed leaves it no effect, unlike crank.torque" if scene.crank else "there is no [crank]"
        raise Refusal(f"input torque: {why}; take another input")
    if "torque" in inputs and scene.acting_spring is not None:
        raise Refusal("input torque: with a [spring] a free crank does not rest at this angle; leave out the spring, or take another input")


def _unit_turn(scene: Scene, crank_angle: float) -> RigidMotion:
    """The rigid mechanism with unit speed of the crank; a follower alone with unit speed of its base, held from there to its end."""
    if scene.crank is None:
        return RigidMotion(*map(np.array, (scene.follower.length, 0.0, 0.0, 0.0, 1.0, 0.0)))
    return rigid_motion(scene, np.array(crank_angle), 1.0)


def _spring(scene: Scene, crank_angle: float) -> tuple[float, float, float]:
    """Arc length (m), stiffness (N/m) and damping (N s/m) of an acting spring across the straight follower; zeros without one."""
    if scene.crank is None or (spring := scene.acting_spring) is None:
        return 0.0, 0.0, 0.0
    # a damper is to speeds what a spring is to places
    damper = Spring(anchor=spring.anchor, place=spring.place, stiffness=spring.damping, free_length=scene.follower.length)
    stiffness, damping = (stiffness_across(dataclasses.replace(scene, spring=each), crank_angle) for each in (spring, damper))
    return spring.place_on(scene.follower.length), stiffness, damping


def _turned(held: HeldFollower) -> Array:
    """The straight follower turned about P by a unit angle, shape (size,)."""
    turned, nodes = np.zeros(len(held.M)), 2 * (len(held.spans) + 1)
    turned[:nodes:2] = [0.0, *(end for _, end in held.spans)]
    turned[1:nodes:2] = 1.0
    return turned


def _shapes(held: HeldFollower, loads: Array, modes: int) -> tuple[Array, Array]:
    """Frequencies (Hz) and mass-normalised shapes, (size, count): modes, then what the static responses to loads have beyond them."""
    frequencies, shapes = held.lowest(modes)
    free, beyond = held.free, np.zeros((len(held.M), loads.shape[1]))
    beyond[free] = scipy.linalg.solve(held.K[free[:, None], free], loads[free], assume_a="pos")
    beyond /= np.sqrt(np.sum(beyond * (held.M @ beyond), axis=0))
    for _ in range(2):  # the second time against round-off
        beyond -= shapes @ (shapes.T @ held.M @ beyond)
    squares, turn = np.linalg.eigh(beyond.T @ held.M @ beyond)
    kept = squares > ROUND_OFF**2
    beyond = beyond @ (turn[:, kept] / np.sqrt(squares[kept]))
    squares, turn = np.linalg.eigh(beyond.T @ held.K @ beyond)
    return np.r_[frequencies, np.sqrt(squares) / (2.0 * math.pi)], np.column_stack([shapes, beyond @ turn])


def _at(line: BeamModes, x: float, derivative: int = 0) -> Array:
    return line.deflection(np.array([x]), derivative)[:, 0]


def _damping(scene: Scene, motion: RigidMotion, held: HeldFollower, line: BeamModes, crank: Array) -> Array:
    """The matrix D: of the beam against its base frame and of its material, of pivot, crank and joint."""
    of_scene, slider, material = constants(scene), scene.slider, scene.follower.material_damping * scene.follower.bending_stiffness
    base, gap = _at(line, 0.0, 1), _at(line, float(motion.slider_position)) * (1.0 - crank)
    joint = slider.joint_damping + 2.0 * slider.contact_damping * slider.preload
    along = (of_scene["base_damping"], base), (of_scene["crank_damping"], crank), (joint, gap)
    D = np.sum([factor * np.outer(row, row) for factor, row in along], axis=0)
    points, weights = legendre.leggauss(len(held.numbering[0]))  # exact for the squares of shapes
    for start, end in held.spans:
        x, dx = 0.5 * (start + end + (end - start) * points), 0.5 * (end - start) * weights
        relative, curvature = line.deflection(x) - np.outer(base, x), line.deflection(x, 2)
        D += of_scene["beam_damping"] * (relative * dx) @ relative.T + material * (curvature * dx) @ curvature.T
    return D


def _outputs(
    scene: Scene, motion: RigidMotion, line: BeamModes, crank: Array, moments: Sequence[Array], inputs: Sequence[str]
) -> dict[str, Array]:
    """Column -> factors of q, q', q'' and u, one after the other.

    `moments`: about P, by unit values of q, q' and q'': of the spring, of its damper, and of the follower's inertia.
    """
    follower, length = scene.follower, scene.follower.length
    base, tip = _at(line, 0.0, 1), _at(line, length)

    def row(*parts: Array, order: int = 0) -> Array:
        """Factors of the derivative of q of this order, and of the next ones."""
        begin, given = order * len(base), np.concatenate(parts)
        return np.pad(given, (begin, 3 * len(base) + len(inputs) - begin - len(given)))

    rows = {
        "tip_x": row(-math.sin(motion.follower_angle) * tip),
        "tip_y": row(math.cos(motion.follower_angle) * tip),
        "tip_deflection": row(tip - length * base),
        "tip_acceleration": row(tip, order=2),
    }
    if scene.crank or "base_torque" in inputs:
        turning = ("follower_angle", "follower_rate", "follower_acceleration")
        rows |= {name: row(base, order=order) for order, name in enumerate(turning)}
    for number, gauge in enumerate(follower.strain_gauges, 1):
        rows[f"strain_{number}"] = row(follower.extreme_fibre * _at(line, gauge, 2))
    for x, shape, moment in zip(np.arange(1, PLACES + 1) * length / (PLACES + 1), SHAPE, MOMENTS, strict=True):
        bending = follower.bending_stiffness * _at(line, x, 2)
        rows |= {shape: row(_at(line, x) - x * base), moment: row(bending, follower.material_damping * bending)}
    # the moment about P that turns the follower: its work on a turn of the straight follower, in which inner forces have no part
    given = np.array([{"torque": 0.0, "tool_force": -length, "base_torque": -1.0}[name] for name in inputs])
    sprung, damped, inertia = moments
    moment_about_pivot = row(sprung, damped + scene.base.damping * base, inertia, given)
    if scene.crank is None:
        return rows if "base_torque" in inputs else rows | {"base_torque": moment_about_pivot}
    rows["slider_force"] = moment_about_pivot / motion.slider_position
    if "torque" in inputs:
        return rows | {"crank_angle": row(crank), "crank_speed": row(crank, order=1), "slider_position": row(motion.slider_speed * crank)}
    return rows | {"crank_torque": motion.follower_speed * moment_about_pivot}
