"""One trajectory type for all engines: the observables on a uniform time grid.

Meanings and signs are those of the column table below; they are the same in every engine.
"""

from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar, Final

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    import pandas as pd

#: Columns that every engine delivers, with unit and meaning.
REQUIRED: Final = MappingProxyType(
    {
        "time": "s since the start",
        "crank_angle": "rad, q1, counter-clockwise from n1, continuous",
        "crank_speed": "rad/s",
        "follower_angle": "rad, q2, tangent at the base, continuous, within 90 deg of 180 deg at the start",
        "slider_position": "m, arc length s of the slider from P",
        "tip_x": "m, place of x = L from O along n1",
        "tip_y": "m, place of x = L from O along n2",
        "tip_deflection": "m, distance of x = L from the base tangent, along b2",
        "tip_acceleration": "m/s^2, absolute acceleration of x = L along the beam's normal there",
        "strain_1": "1, surface strain at the first gauge: curvature x thickness / 2, positive where W'' > 0",
        "strain_2": "1, at the second gauge",
        "strain_3": "1, at the third gauge",
        "slider_force": "N, normal force on the follower at the slider, positive along the normal n = (-W', ...)",
    }
)
#: Columns that an engine delivers where it has them.
OPTIONAL: Final = MappingProxyType(
    {
        "crank_torque": "N m, torque of the drive on the crank (constant, or what a prescribed speed takes)",
        "kinetic_energy": "J, all bodies",
        "strain_energy": "J, follower (and joint spring)",
        "dissipated_energy": "J, by all dampings since the start",
        "constraint_gap": "m, distance of the slider from the centre line",
        "gravity_energy": "J, potential energy of gravity, all bodies, zero at the height of O",
        "drive_work": "J, work of the drive torque and of the force on the tip since the start",
        "base_torque": "N m, torque that turns the base as prescribed",
        "axial_stretch": "m, length of the centre line less that of the undeformed follower",
    }
)
#: Of the required columns those that mean nothing without crank and slider.
OF_CRANK_AND_SLIDER: Final = ("crank_angle", "crank_speed", "slider_position", "slider_force")


@dataclass(frozen=True)
class Trajectory:
    """Observables on a uniform grid.

    Attributes:
        columns: column name -> values, shape (n,). All of `REQUIRED`, any of `OPTIONAL`.
        solve_seconds: wall time from the prepared model to this table.
        statistics: what the solver counted, e.g. {"right_hand_side_calls": 12345}.
    """

    columns: dict[str, NDArray[np.float64]]
    solve_seconds: float
    statistics: dict[str, float] = field(default_factory=dict)
    required: ClassVar[tuple[str, ...]] = tuple(REQUIRED)

    def __post_init__(self) -> None:
        missing = [name for name in self.required if name not in self.columns]
        if missing:
            raise ValueError(f"trajectory lacks the columns {', '.join(missing)}")

    def __getitem__(self, name: str) -> NDArray[np.float64]:
        return self.columns[name]

    def __len__(self) -> int:
        return len(self.columns["time"])

    def table(self) -> "pd.DataFrame":
        """The trajectory as a table, required columns first, then the optional ones in fixed order."""
        import pandas as pd  # 0.2 s that nothing but a table needs

        names = [name for name in (*REQUIRED, *OPTIONAL) if name in self.columns]
        return pd.DataFrame({name: self.columns[name] for name in names})


class FollowerTrajectory(Trajectory):
    """Observables of a follower alone: the columns of crank and slider are absent, the follower's angle is the prescribed one."""

    required: ClassVar[tuple[str, ...]] = tuple(name for name in REQUIRED if name not in OF_CRANK_AND_SLIDER)


def join(pieces: list[Trajectory]) -> Trajectory:
    """Consecutive pieces of one simulation as one trajectory; each piece repeats the last row of the one before."""
    columns = {name: np.concatenate([piece[name][(0 if i == 0 else 1) :] for i, piece in enumerate(pieces)]) for name in pieces[0].columns}
    statistics = {key: sum(p.statistics.get(key, 0.0) for p in pieces) for key in pieces[0].statistics}
    return replace(pieces[0], columns=columns, solve_seconds=sum(p.solve_seconds for p in pieces), statistics=statistics)
