"""The first row of a recorded table beside that of the standard start."""

import math
from collections.abc import Mapping
from typing import Final, NamedTuple

import numpy as np

from quickreturn.cases.files.instants import noise_of
from quickreturn.cases.files.recorded import RecordedTable
from quickreturn.cases.motion.time_scale import CHANNELS
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.mechanism import Mechanism
from quickreturn.reference_model.rigid import crank_pace, rigid_motion

#: Allowed departure, besides noise, of a first row from the standard start, as a part of a turn for time and crank angle and of the largest
#: magnitude for other columns ...
SAME: Final = 1e-3
#: ... and for the tip deflection, its acceleration and strains: a straight beam under load has strains if they come from equilibrium.
UNBENT: Final = 1e-2
#: Largest number of named columns in which a first row departs from the standard start.
MOST_ODD: Final = 3


class FirstRow(NamedTuple):
    """What the first row of a table shows."""

    begun: bool | None  # whether it is the standard start; None: no column distinguishes that from another turn
    odd: str = ""  # its departures in words
    late: float = 0.0  # its time, s, if it is the standard start in everything else


def standard_row(mechanism: Mechanism) -> dict[str, float]:
    """The first row of the standard start, without a simulation: places and speeds of the rigid mechanism, without bending."""
    crank, length = mechanism.crank, mechanism.follower.length
    motion = rigid_motion(mechanism, np.array(crank.initial_angle), crank.drive.initial_speed)
    angle = float(motion.follower_angle)
    return {
        "time": 0.0,
        "crank_angle": crank.initial_angle,
        "crank_speed": crank.drive.initial_speed,
        "follower_angle": angle,
        "slider_position": float(motion.slider_position),
        "tip_x": mechanism.pivot_distance + length * math.cos(angle),
        "tip_y": length * math.sin(angle),
        **dict.fromkeys(("tip_deflection", *CHANNELS[1:]), 0.0),
    }


def first_row(table: RecordedTable, columns: Mapping[str, Array], mechanism: Mechanism, rows: int) -> FirstRow:
    """Whether a table's first row is that of the standard start. `rows`: number of rows before the first gap, which show the noise.

    It is if time and crank angle agree with that start, and most of the columns that distinguish it from another turn: an offset of a
    gauge, or another origin of one column, is a mistake of that column. A recording may begin at any time: nothing in a scene depends on
    the time itself. So only the time may differ if crank angle and bending were recorded and all columns agree.
    """
    if table.declared.get("origin", "simulated") != "simulated":
        return FirstRow(False)
    standard = {name: value for name, value in standard_row(mechanism).items() if name in columns}
    pace, bending = crank_pace(mechanism), ("tip_deflection", *CHANNELS[1:])
    sizes = {name: float(np.max(np.abs(columns[name]))) for name in standard} | {"crank_angle": 2.0 * math.pi}
    if pace > 0.0:
        sizes["time"] = 2.0 * math.pi / pace
    noise = {name: noise_of(columns["time"][:rows], columns[name][:rows]) for name in standard}
    allowed = {name: (UNBENT if name in bending else SAME) * sizes[name] + noise[name] for name in standard}
    odd = [name for name, value in standard.items() if abs(float(columns[name][0]) - value) > allowed[name]]
    deciding = standard.keys() & ({"crank_speed"} if mechanism.follower.is_rigid else set(bending))
    if odd == ["time"] and deciding and "crank_angle" in table.columns:
        return FirstRow(True, late=float(columns["time"][0]))
    told = [f"{name} {float(columns[name][0]):.5g} instead of {round(standard[name], 12):.5g}" for name in odd[:MOST_ODD]]
    if deciding:
        begun: bool | None = not {"time", "crank_angle"} & set(odd) and 2 * len(deciding.intersection(odd)) < len(deciding)
    else:
        begun = False if odd else None
    return FirstRow(begun, ", ".join(told) + (f" and {len(odd) - MOST_ODD} more" if len(odd) > MOST_ODD else ""))
