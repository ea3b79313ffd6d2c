"""The constants of a scene for the equations of motion (DERIVATION.md, section 1)."""

import numpy as np

from quickreturn.reference_model.columns import PLACES
from quickreturn.reference_model.constants import constants, pace, unslowed
from quickreturn.reference_model.mechanism import Scene
from quickreturn.reference_model.motion.layout import BeamParameters, BeamTables, ShapeRow
from quickreturn.reference_model.native.memory import Vector
from quickreturn.reference_model.slider_constraint import BASE, CLOSED, ELIMINATED, SliderConstraint
from quickreturn.reference_model.spring import Spring


def parameters(
    scene: Scene,
    shapes: int,
    tables: BeamTables,
    reach: float,
    constraint: SliderConstraint = CLOSED,
    *,
    slowed_to: float | None = None,
) -> BeamParameters:
    """Constants of a scene.

    Args:
        scene: the mechanism, or the follower alone, whose base turns as prescribed.
        shapes: number of shapes n.
        tables: of the shapes.
        reach: slider position beyond which the slider counts as off the follower, m.
        constraint: of the slider; ignored for the follower alone.
        slowed_to: see `added_inertia`, rad/s; None adds no inertia.
    """
    kind = BASE if scene.crank is None else constraint.kind
    rollers, slider = constraint.rollers, scene.slider
    spring = scene.acting_spring or Spring(anchor=(0.0, 0.0))
    of_scene = constants(scene)
    of_scene["places"] = places(scene.follower.length, of_scene.pop("gauges"))
    return BeamParameters(
        **of_scene,
        constraint=kind,
        n=shapes,
        speeds=shapes + (1 if kind in (ELIMINATED, BASE) else 2),
        first=0 if scene.crank_is_free else 1,
        EI=scene.follower.bending_stiffness,
        base_friction=scene.base.friction_torque,
        base_friction_rate=scene.base.friction_rate,
        force_follows=int(scene.tip_body.follows),
        slide_friction=scene.tip_body.friction_force,
        slide_speed=scene.tip_body.friction_speed,
        plus=rollers.plus,
        minus=rollers.minus,
        plus_from=rollers.plus_from,
        minus_from=rollers.minus_from,
        contact_loss=rollers.loss,
        joint_damping=rollers.damping,
        friction=slider.friction,
        friction_force=slider.friction_force,
        friction_speed=slider.friction_speed,
        joint_inertia=constraint.inertia,
        stabilization=constraint.stabilization,
        bending_damping=constraint.bending_damping + scene.follower.material_damping if shapes else 0.0,
        feedback=pace(scene, shapes),
        is_held=int(spring.acts),
        anchor_1=spring.anchor[0],
        anchor_2=spring.anchor[1],
        spring_place=spring.place_on(scene.follower.length),
        spring=spring.law,
        added_inertia=np.zeros(shapes) if slowed_to is None else added_inertia(tables, shapes, slowed_to),
        reach=reach,
        knows_frequency=1 if tables.moves and kind == ELIMINATED else 0,
        tables=tables,
    )


def places(length: float, gauges: Vector) -> Vector:
    """Places of a row's moments and shape, then of its strains, m; and fillers, for places are read in fours."""
    return np.concatenate([length * np.arange(1, PLACES + 1) / (PLACES + 1), gauges, np.zeros(3)])


def added_inertia(tables: BeamTables, shapes: int, slowed_to: float) -> Vector:
    """Added inertia of each amplitude over its modal mass, which slows the higher half of the modes (equation 5.15), shape (n,).

    The modes stay as fast as the middle one at the slider's place where that is fastest, or as `slowed_to` (rad/s) if that is more.
    """
    middle = unslowed(shapes)
    if middle == shapes:
        return np.zeros(shapes)
    squares = ShapeRow.of(tables.coefficients[:, 3], shapes, tables).squares.max(axis=0)
    return np.maximum(squares / max(squares[middle - 1], slowed_to**2) - 1.0, 0.0)
