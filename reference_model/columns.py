"""The columns of a trajectory, each with unit and meaning, and where compiled code lays them down in a row.

Meanings and signs are the same in every model and engine. The deflections `shape_01` to `shape_11` at the interior twelfths of the length
are for drawing: with the base and the tip they are thirteen places of the centre line.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Final, TypeVar

T = TypeVar("T")


@dataclass(frozen=True)
class Observable:
    """What a column holds.

    Attributes:
        unit: SI.
        meaning: in words.
        required: whether every engine delivers it.
        of_slider: whether it means nothing without crank and slider.
    """

    unit: str
    meaning: str
    required: bool = False
    of_slider: bool = False


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
    }
)
SHAPE: Final = tuple(name for name in COLUMNS if name.startswith("shape_"))

#: Places in a row of what the compiled models tell of an instant; the caller adds the time. The shape comes last.
(
    CRANK_ANGLE, CRANK_SPEED, FOLLOWER_ANGLE, SLIDER_POSITION, TIP_X, TIP_Y, TIP_DEFLECTION, TIP_ACCELERATION,
    STRAIN_1, STRAIN_2, STRAIN_3, SLIDER_FORCE, CRANK_TORQUE, KINETIC_ENERGY, STRAIN_ENERGY, DISSIPATED_ENERGY,
    CONSTRAINT_GAP, GRAVITY_ENERGY, DRIVE_WORK, FIRST_OF_SHAPE,
) = range(20)  # fmt: skip
#: Their names in that order.
OBSERVED: Final = (
    "crank_angle", "crank_speed", "follower_angle", "slider_position", "tip_x", "tip_y", "tip_deflection", "tip_acceleration",
    "strain_1", "strain_2", "strain_3", "slider_force", "crank_torque", "kinetic_energy", "strain_energy", "dissipated_energy",
    "constraint_gap", "gravity_energy", "drive_work", *SHAPE,
)  # fmt: skip
#: What an open loop's joint does, behind those: rate of the gap (m/s), power of the slider's force on crank and follower together (W).
JOINT_COLUMNS: Final = ("gap_rate", "joint_power")
GAP_RATE, JOINT_POWER = len(OBSERVED), len(OBSERVED) + 1


def of_follower_alone(columns: Mapping[str, T]) -> dict[str, T]:
    """The columns of a follower alone, whose base is what the drive turns: without those of crank and slider."""
    kept = {name: values for name, values in columns.items() if name in COLUMNS and not COLUMNS[name].of_slider}
    return kept | {"base_torque": columns["crank_torque"]}
