"""One trajectory type for all engines: observables on a uniform time grid (`reference_model.columns`); and the distance of two columns."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, ClassVar, Final

import numpy as np

from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.columns import AXIAL, BENDING, COLUMNS, ENDS
from quickreturn.reference_model.mechanism import Scene

if TYPE_CHECKING:
    import pandas as pd

#: Column name -> values, shape (n,).
Columns = dict[str, Array]
#: Columns that every engine delivers.
REQUIRED: Final = tuple(name for name, column in COLUMNS.items() if column.required)
#: Columns that an engine delivers where it has them.
OPTIONAL: Final = tuple(name for name, column in COLUMNS.items() if not column.required)


@dataclass(frozen=True)
class Trajectory:
    """Observables on a uniform grid.

    Attributes:
        columns: column name -> values, shape (n,). All of `REQUIRED`, any of `OPTIONAL`; units as in `reference_model.columns`.
        solve_seconds: wall time from the prepared model to this table.
        statistics: counts and times of the solver, e.g. {"right_hand_side_calls": 12345}.
    """

    columns: Columns
    solve_seconds: float
    statistics: dict[str, float] = field(default_factory=dict)
    required: ClassVar[tuple[str, ...]] = REQUIRED

    def __post_init__(self) -> None:
        missing = [name for name in self.required if name not in self.columns]
        if missing:
            raise ValueError(f"trajectory lacks the columns {', '.join(missing)}")

    def __repr__(self) -> str:
        time = self.columns["time"]
        return f"{type(self).__name__}: {len(time)} rows from {time[0]:g} to {time[-1]:g} s; columns {', '.join(self.columns)}"

    def __getitem__(self, name: str) -> Array:
        return self.columns[name]

    def __len__(self) -> int:
        return len(self.columns["time"])

    def table(self) -> "pd.DataFrame":
        """The trajectory as a table, with the columns in the order of `reference_model.columns`."""
        import pandas as pd  # takes 0.2 s

        return pd.DataFrame({name: self.columns[name] for name in COLUMNS if name in self.columns})


class FollowerTrajectory(Trajectory):
    """Observables of a follower alone, without the columns of crank and slider; the follower's angle is as prescribed."""

    required: ClassVar[tuple[str, ...]] = tuple(name for name in REQUIRED if not COLUMNS[name].of_slider)


def trajectory_type(scene: Scene) -> type[Trajectory]:
    """The type of a scene's trajectories."""
    return FollowerTrajectory if scene.crank is None else Trajectory


def join(pieces: list[Trajectory]) -> Trajectory:
    """Consecutive pieces of one simulation as one trajectory, without the first row of each later piece, which repeats a row."""
    columns = {name: np.concatenate([piece[name][(0 if i == 0 else 1) :] for i, piece in enumerate(pieces)]) for name in pieces[0].columns}
    statistics = {key: sum(p.statistics.get(key, 0.0) for p in pieces) for key in pieces[0].statistics}
    return replace(pieces[0], columns=columns, solve_seconds=sum(p.solve_seconds for p in pieces), statistics=statistics)


def rms(values: Array) -> float:
    """Root mean square; 0 for an empty array."""
    return float(np.sqrt(np.mean(np.square(values)))) if values.size else 0.0


def scale(name: str, columns: Mapping[str, Array]) -> float:
    """Size that the error of a column is relative to, in its unit: its RMS.

    A moment at an end is tiny where the body there is light: its scale is the largest RMS of the moments along the arm; likewise for the
    normal forces in the arm. A gap at the slider is zero but for errors: its scale is the slider's distance from the pivot.
    """
    family = BENDING if name in ENDS else AXIAL if name in AXIAL else ("slider_position",) if name == "constraint_gap" else (name,)
    return max(rms(columns[each]) for each in (family if columns.keys() & {*family} else (name,)) if each in columns)


def relative_error(values: Array, truth: Array) -> float:
    """RMS of the difference over the RMS of the truth, both of shape (n,); infinite where the truth is zero throughout."""
    size = rms(truth)
    return rms(values - truth) / size if size > 0.0 else math.inf
