"""The columns of a trajectory, each with unit and meaning, and the record (`ROW`) that compiled code fills for one instant.

Meanings and signs are the same in every model and engine. The deflections `shape_01` to `shape_11` at the interior twelfths of the length
are for drawing: with the base and the tip they are thirteen places of the centre line.

Bending moments have the sign of the strains. Where a slider with rotary inertia, or friction off the centre line, makes the moment jump,
`moment_slider` is on its outboard side, `moment_inboard` on the other. Those at the ends are what the bodies there require: a model takes
them from the accelerations that it integrates, so that they do not depend on the spacing of rows. A rigid follower has moments too, those
that Newton and Euler require of it, but an engine that knows moments by curvature alone leaves the columns out for it.

Normal forces in the arm are positive where they pull. Like the moments they are those of the loads outboard: inertia, weight, damping, tip
body, tool and slider. They jump at a slider that rubs, or has rotary inertia on a bent arm.

Bearing forces are those that the ground exerts on the body. The torque of the drive, the bearings' friction and the damping of the beam
against its base are couples or internal forces: no bearing force contains them, except by the motion that they cause. The base block has
no mass here, only an inertia, so that its own weight is not in the force at P.
"""

from dataclasses import dataclass
from itertools import groupby
from types import MappingProxyType
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from quickreturn.reference_model.arrays import Array

#: Rows (k,) of `ROW`.
Rows = NDArray[Any]


@dataclass(frozen=True)
class Observable:
    """What a column holds."""

    unit: str  # SI
    meaning: str  # in words
    required: bool = False  # whether every engine delivers it
    of_slider: bool = False  # whether it means nothing without crank and slider
    recorded: bool = True  # whether it is in the rows that compiled models fill


#: Number of interior places of the centre line at which the deflection is given.
PLACES: Final = 11
#: Number of strain gauges.
GAUGES: Final = 3

#: Name -> column, in the order of tables: those that every engine delivers first.
COLUMNS: Final = MappingProxyType(
    {
        "time": Observable("s", "since the start", required=True, recorded=False),
        "crank_angle": Observable("rad", "q1, counter-clockwise from n1, continuous", required=True, of_slider=True),
        "crank_speed": Observable("rad/s", "of the crank", required=True, of_slider=True),
        "follower_angle": Observable(
            "rad", "q2, tangent at the base, continuous; with the crank at 180 deg it is near 180 deg", required=True
        ),
        "slider_position": Observable("m", "arc length s of the slider from P", required=True, of_slider=True),
        "tip_x": Observable("m", "place of x = L from O along n1", required=True),
        "tip_y": Observable("m", "place of x = L from O along n2", required=True),
        "tip_deflection": Observable("m", "distance of x = L from the base tangent, along b2", required=True),
        "tip_acceleration": Observable("m/s^2", "absolute acceleration of x = L along the beam's normal there", required=True),
        "strain_1": Observable(
            "1",
            "surface strain at the first gauge: curvature x its distance from the axis of bending, positive where W'' > 0",
            required=True,
        ),
        "strain_2": Observable("1", "at the second gauge", required=True),
        "strain_3": Observable("1", "at the third gauge", required=True),
        "slider_force": Observable(
            "N", "normal force on the follower at the slider, positive along the normal n = (-W', ...)", required=True, of_slider=True
        ),
        "crank_torque": Observable("N m", "torque of the drive on the crank (given, or what a prescribed motion takes)", of_slider=True),
        "kinetic_energy": Observable("J", "all bodies"),
        "strain_energy": Observable("J", "follower (and joint spring, and spring with its stops)"),
        "dissipated_energy": Observable("J", "by all dampings since the start"),
        "constraint_gap": Observable("m", "distance of the slider from the centre line", of_slider=True),
        "gravity_energy": Observable("J", "potential energy of gravity, all bodies, zero at the height of O"),
        "drive_work": Observable("J", "work of the drive torque and of the force on the tip since the start"),
        "base_torque": Observable("N m", "torque that turns the base as prescribed", recorded=False),
        "axial_stretch": Observable("m", "length of the centre line less that of the undeformed follower", recorded=False),
        **{
            f"shape_{k:02d}": Observable("m", f"distance of x = {k}/{PLACES + 1} L from the base tangent, along b2")
            for k in range(1, PLACES + 1)
        },
        **{
            f"moment_{k:02d}": Observable("N m", f"bending moment at x = {k}/{PLACES + 1} L, positive where W'' > 0")
            for k in range(1, PLACES + 1)
        },
        "moment_slider": Observable("N m", "bending moment at the slider, on its outboard side", of_slider=True),
        "moment_inboard": Observable("N m", "the same on its inboard side", of_slider=True),
        "moment_base": Observable("N m", "bending moment at the base, x = 0"),
        "moment_tip": Observable("N m", "bending moment at the flexible end, x = L"),
        "axial_base": Observable("N", "normal force in the arm at the base, x = 0, positive where it pulls"),
        "axial_inboard": Observable("N", "the same at the slider, on its inboard side", of_slider=True),
        "axial_slider": Observable("N", "the same on its outboard side", of_slider=True),
        "axial_tip": Observable("N", "the same at the flexible end, x = L"),
        "pivot_force_x": Observable("N", "force of the bearing P on the follower's base, along n1"),
        "pivot_force_y": Observable("N", "the same along n2"),
        "crank_force_x": Observable("N", "force of the bearing O on the crank, along n1", of_slider=True),
        "crank_force_y": Observable("N", "the same along n2", of_slider=True),
        "follower_rate": Observable("rad/s", "rate of `follower_angle`"),
        "follower_acceleration": Observable("rad/s^2", "rate of `follower_rate`"),
        "spring_force": Observable("N", "force of the spring with its damper and stops, positive where it pulls"),
    }
)
SHAPE: Final = tuple(name for name in COLUMNS if name.startswith("shape_"))
#: Bending moments at the places of `SHAPE`.
MOMENTS: Final = tuple(f"moment_{name.removeprefix('shape_')}" for name in SHAPE)
#: Bending moments at the ends of the arm, which are those that the bodies there ask for.
ENDS: Final = ("moment_base", "moment_tip")
#: All bending moments: what an engine leaves out for a rigid follower if it knows moments by curvature alone.
BENDING: Final = (*MOMENTS, "moment_slider", "moment_inboard", *ENDS)
#: Normal forces in the arm.
AXIAL: Final = ("axial_base", "axial_inboard", "axial_slider", "axial_tip")
BEARINGS: Final = ("pivot_force_x", "pivot_force_y", "crank_force_x", "crank_force_y")

#: Columns that the compiled models record.
OBSERVED: Final = tuple(name for name, column in COLUMNS.items() if column.recorded)
#: More, of a slider that may leave the centre line: rate of the gap (m/s), power of its force on crank and follower together (W).
JOINT_COLUMNS: Final = ("gap_rate", "joint_power")
_FIELDS: Final = {name: len([*group]) for name, group in groupby((*OBSERVED, *JOINT_COLUMNS), lambda name: name.rstrip("_0123456789"))}
#: The record of one instant: `OBSERVED`, then `JOINT_COLUMNS`. Numbered columns are one field, an array: `strains`, `shapes`, `moments`.
ROW: Final = np.dtype(
    (np.record, [(name, np.float64) if count == 1 else (f"{name}s", np.float64, (count,)) for name, count in _FIELDS.items()])
)
#: Numbers in it.
NUMBERS: Final = ROW.itemsize // 8


def by_column(rows: Rows) -> Array:
    """The numbers of rows (k,) of `ROW`, shape (`NUMBERS`, k)."""
    return rows.view(np.float64).reshape(len(rows), NUMBERS).T.copy()


def recorded_columns(
    table: Array, *, alone: bool = False, bends: bool = True, joint: bool = False, spring: bool = False
) -> dict[str, Array]:
    """Columns by name, each of shape (k,), of a table (`NUMBERS`, k).

    Args:
        table: as compiled code filled it.
        alone: whether the rows are those of a follower alone: `base_torque` then stands in for `crank_torque`, and the other columns of
            crank and slider are left out.
        bends: whether to include the bending moments, which a model that knows them by curvature cannot give for a rigid follower.
        joint: whether to include `JOINT_COLUMNS`.
        spring: whether to include `spring_force`.
    """
    columns = dict(zip((*OBSERVED, *JOINT_COLUMNS), table, strict=True))
    left_out = {*(() if joint else JOINT_COLUMNS), *(() if bends else BENDING), *(() if spring else ("spring_force",))}
    if alone:
        left_out |= {name for name in OBSERVED if COLUMNS[name].of_slider}
        columns["base_torque"] = columns["crank_torque"]
    return {name: column for name, column in columns.items() if name not in left_out}
