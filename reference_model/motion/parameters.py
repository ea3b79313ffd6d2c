"""The constants of a scene for the equations of motion (DERIVATION.md, section 1)."""

import numpy as np

from quickreturn.reference_model.columns import PLACES
from quickreturn.reference_model.constants import constants, pace
from quickreturn.reference_model.joint import BASE, CLOSED, ELIMINATED, SliderConstraint
from quickreturn.reference_model.mechanism import Scene
from quickreturn.reference_model.motion.layout import BeamParameters, BeamTables, ShapeRow
from quickreturn.reference_model.native.memory import Vector
from quickreturn.reference_model.spring import Spring


def parameters(
    scene: Scene,
    shapes: int,
    tables: BeamTables,
    reach: float,
    constraint: SliderConstraint = CLOSED,
    *,
    slowed_to: int = 0,
    slowed_above: float = 0.0,
) -> BeamParameters:
    """Constants of a scene.

    Args:
        scene: the mechanism, or the follower alone, whose base turns as prescribed.
        shapes: number of shapes n.
        tables: of the shapes.
        reach: slider position beyond which the slider counts as off the follower, m.
        constraint: of the slider; ignored for the follower alone.
        slowed_to: see `added_inertia`.
        slowed_above: see `added_inertia`.
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
        added_inertia=added_inertia(tables, shapes, slowed_to, slowed_above),
        reach=reach,
        knows_frequency=1 if tables.moves and kind == ELIMINATED else 0,
        tables=tables,
    )


def places(length: float, gauges: Vector) -> Vector:
    """Places of a row's moments and shape, then of its strains, m; and fillers, for places are read in fours."""
    return np.concatenate([length * np.arange(1, PLACES + 1) / (PLACES + 1), gauges, np.zeros(3)])


def added_inertia(tables: BeamTables, shapes: int, slowed_to: int, slowed_above: float = 0.0) -> Vector:
    """Added inertia of each amplitude over its modal mass, which slows the higher modes (equation 5.15), shape (n,).

    Args:
        tables: of the shapes.
        shapes: number of shapes n.
        slowed_to: number c of the mode, from 1 on, to whose frequency all higher ones are slowed, at the slider's place where that is
            highest; 0, n or more add no inertia.
        slowed_above: angular frequency below which no mode is slowed, rad/s.
    """
    if not 0 < slowed_to < shapes:
        return np.zeros(shapes)
    squares = ShapeRow.of(tables.coefficients[:, 3], shapes, tables).squares.max(axis=0)
    return np.maximum(squares / max(squares[slowed_to - 1], slowed_above**2) - 1.0, 0.0)
