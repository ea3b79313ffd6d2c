"""The constants of a scene for the equations of motion (DERIVATION.md, section 1)."""

import math

import numpy as np

from reference_model import tip_force
from reference_model.mechanism import FollowerAlone, Mechanism, Scene, TorqueDrive
from reference_model.motion.layout import Parameters, Tables
from reference_model.treatment import BASE, CLOSED, ELIMINATED, Treatment


def parameters(
    scene: Scene, shapes: int, tables: Tables, reach: float, treatment: Treatment = CLOSED, *, transverse_damping: bool = False
) -> Parameters:
    """Constants of a scene with shapes in tables.

    Args:
        scene: the mechanism, or the follower alone, whose base turns as prescribed.
        shapes: n.
        tables: of the shapes.
        reach: m, place of the slider at which it counts as leaving the follower.
        treatment: of the slider; not read for the follower alone.
        transverse_damping: the beam damping acts on the velocity across the base tangent alone.
    """
    follower, tip = scene.follower, scene.tip_body
    kind = BASE if isinstance(scene, FollowerAlone) else treatment.kind
    return Parameters(
        treatment=kind,
        n=shapes,
        speeds=shapes + (1 if kind in (ELIMINATED, BASE) else 2),
        first=0 if isinstance(scene, Mechanism) and scene.crank_is_free else 1,
        **_of_crank(scene),
        L=follower.length,
        base_inertia=scene.base.inertia,
        base_damping=scene.base.damping,
        rhoA=follower.mass_per_length,
        EI=follower.bending_stiffness,
        beam_damping=follower.damping,
        damps_along=0.0 if transverse_damping else 1.0,
        tip_mass=tip.mass,
        tip_inertia=tip.inertia,
        tip_offset=tip.center_of_mass,
        **tip_force.constants(tip),
        gravity_1=scene.gravity[0],
        gravity_2=scene.gravity[1],
        joint_stiffness=treatment.stiffness,
        joint_damping=treatment.damping,
        joint_inertia=treatment.inertia,
        stabilization=treatment.stabilization,
        bending_damping=treatment.bending_damping,
        thickness=follower.thickness,
        gauges=np.array(follower.strain_gauges, dtype=float),
        reach=reach,
        knows_frequency=1 if tables.kinds == 3 and kind == ELIMINATED else 0,
        tables=tables,
    )


def _of_crank(scene: Scene) -> dict[str, float]:
    names = ("d", "LA", "crank_inertia", "crank_moment", "torque", "crank_damping", "slider_inertia", "base_speed", "base_time")
    if isinstance(scene, FollowerAlone):
        return dict.fromkeys(names, 0.0) | {"base_speed": scene.spin_up.speed, "base_time": scene.spin_up.time}
    crank, slider, drive = scene.crank, scene.slider, scene.crank.drive
    free = drive if isinstance(drive, TorqueDrive) else TorqueDrive(torque=0.0, damping=0.0, initial_speed=drive.initial_speed)
    inertia, moment = scene.crank_inertia, scene.crank_moment
    of_mechanism = (scene.pivot_distance, crank.length, inertia, moment, free.torque, free.damping, slider.inertia, 0.0, 0.0)
    return dict(zip(names, of_mechanism, strict=True))


def characteristic_frequency(p: Parameters) -> float:
    """About the first bending frequency, 1/s, that sizes of rates are taken with; 1 for a rigid follower or one without mass."""
    return 10.0 * math.sqrt(p.EI / p.rhoA) / p.L**2 if p.n and p.rhoA > 0.0 else 1.0
