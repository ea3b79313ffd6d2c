"""The columns of a trajectory, each with unit and meaning, and where compiled code lays them down in a row.

Meanings and signs are the same in every model and engine. The deflections `shape_01` to `shape_11` at the interior twelfths of the length
are for drawing: with the base and the tip they are thirteen places of the centre line.

Bending moments have the sign of the strains. Where a slider with rotary inertia makes the moment jump, the moment at the slider is the one
on its outboard side. A rigid follower has moments too, those that Newton and Euler require of it, but an engine that knows moments by
curvature alone leaves the columns out there.

Bearing forces are those that the ground exerts on the body. The torque of the drive, the bearings' friction and the damping of the beam
against its base are couples or internal forces: no bearing force contains them, except by the motion that they cause. The base block has
no mass here, only an inertia, so that its own weight is not in the force at P.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Final, TypeVar

T = TypeVar("T")


@dataclass(frozen=True)
class Observable:
    """What a column holds."""

    unit: str  # SI
    meaning: str  # in words
    required: bool = False  # whether every engine delivers it
    of_slider: bool = False  # whether it means nothing without crank and slider


#: Number of interior places of the centre line at which the deflection is given.
PLACES: Final = 11

#: Name -> column, in the order of tables: those that every engine delivers first.
COLUMNS: Final = MappingProxyType(
    {
        "time": Observable("s", "since the start", required=True),
        "crank_angle": Observable("rad", "q1, counter-clockwise from n1, continuous", required=True, of_slider=True),
        "crank_speed": Observable("rad/s", "of the crank", required=True, of_slider=True),
        "follower_angle": Observable("rad", "q2, tangent at the base, continuous, within 90 deg of 180 deg at the start", required=True),
        "slider_position": Observable("m", "arc length s of the slider from P", required=True, of_slider=True),
        "tip_x": Observable("m", "place of x = L from O along n1", required=True),
        "tip_y": Observable("m", "place of x = L from O along n2", required=True),
        "tip_deflection": Observable("m", "distance of x = L from the base tangent, along b2", required=True),
        "tip_acceleration": Observable("m/s^2", "absolute acceleration of x = L along the beam's normal there", required=True),
        "strain_1": Observable("1", "surface strain at the first gauge: curvature x thickness / 2, positive where W'' > 0", required=True),
        "strain_2": Observable("1", "at the second gauge", required=True),
        "strain_3": Observable("1", "at the third gauge", required=True),
        "slider_force": Observable(
            "N", "normal force on the follower at the slider, positive along the normal n = (-W', ...)", required=True, of_slider=True
        ),
        "crank_torque": Observable("N m", "torque of the drive on the crank (constant, or what a prescribed speed takes)", of_slider=True),
        "kinetic_energy": Observable("J", "all bodies"),
        "strain_energy": Observable("J", "follower (and joint spring)"),
        "dissipated_energy": Observable("J", "by all dampings since the start"),
        "constraint_gap": Observable("m", "distance of the slider from the centre line", of_slider=True),
        "gravity_energy": Observable("J", "potential energy of gravity, all bodies, zero at the height of O"),
        "drive_work": Observable("J", "work of the drive torque and of the force on the tip since the start"),
        "base_torque": Observable("N m", "torque that turns the base as prescribed"),
        "axial_stretch": Observable("m", "length of the centre line less that of the undeformed follower"),
        **{
            f"shape_{k:02d}": Observable("m", f"distance of x = {k}/{PLACES + 1} L from the base tangent, along b2")
            for k in range(1, PLACES + 1)
        },
        **{
            f"moment_{k:02d}": Observable("N m", f"bending moment at x = {k}/{PLACES + 1} L, positive where W'' > 0")
            for k in range(1, PLACES + 1)
        },
        "moment_slider": Observable("N m", "bending moment at the slider, on its outboard side", of_slider=True),
        "pivot_force_x": Observable("N", "force of the bearing P on the follower's base, along n1"),
        "pivot_force_y": Observable("N", "the same along n2"),
        "crank_force_x": Observable("N", "force of the bearing O on the crank, along n1", of_slider=True),
        "crank_force_y": Observable("N", "the same along n2", of_slider=True),
    }
)
SHAPE: Final = tuple(name for name in COLUMNS if name.startswith("shape_"))
#: Bending moments at the places of `SHAPE`.
MOMENTS: Final = tuple(name for name in COLUMNS if name.startswith("moment_") and name != "moment_slider")
#: All bending moments: what an engine leaves out for a rigid follower if it knows moments by curvature alone.
BENDING: Final = (*MOMENTS, "moment_slider")
BEARINGS: Final = ("pivot_force_x", "pivot_force_y", "crank_force_x", "crank_force_y")

#: Places in a row of what the compiled models tell of an instant; the caller adds the time. Shape and moments along the follower come last.
(
    CRANK_ANGLE, CRANK_SPEED, FOLLOWER_ANGLE, SLIDER_POSITION, TIP_X, TIP_Y, TIP_DEFLECTION, TIP_ACCELERATION,
    STRAIN_1, STRAIN_2, STRAIN_3, SLIDER_FORCE, CRANK_TORQUE, KINETIC_ENERGY, STRAIN_ENERGY, DISSIPATED_ENERGY,
    CONSTRAINT_GAP, GRAVITY_ENERGY, DRIVE_WORK, MOMENT_SLIDER, PIVOT_FORCE_X, PIVOT_FORCE_Y, CRANK_FORCE_X, CRANK_FORCE_Y, FIRST_OF_SHAPE,
) = range(25)  # fmt: skip
FIRST_OF_MOMENTS: Final = FIRST_OF_SHAPE + PLACES
#: Their names in that order.
OBSERVED: Final = (
    "crank_angle", "crank_speed", "follower_angle", "slider_position", "tip_x", "tip_y", "tip_deflection", "tip_acceleration",
    "strain_1", "strain_2", "strain_3", "slider_force", "crank_torque", "kinetic_energy", "strain_energy", "dissipated_energy",
    "constraint_gap", "gravity_energy", "drive_work", "moment_slider", "pivot_force_x", "pivot_force_y", "crank_force_x", "crank_force_y",
    *SHAPE, *MOMENTS,
)  # fmt: skip
#: What an open loop's joint does, behind those: rate of the gap (m/s), power of the slider's force on crank and follower together (W).
JOINT_COLUMNS: Final = ("gap_rate", "joint_power")
GAP_RATE, JOINT_POWER = len(OBSERVED), len(OBSERVED) + 1


def of_follower_alone(columns: Mapping[str, T]) -> dict[str, T]:
    """The columns of a follower alone, whose base is what the drive turns: without those of crank and slider."""
    kept = {name: values for name, values in columns.items() if name in COLUMNS and not COLUMNS[name].of_slider}
    return kept | {"base_torque": columns["crank_torque"]}
