"""Third rung: what the engines' trajectories converge to.

Each engine solves a scene with three settings whose discretizations shrink by one ratio, in step and elements or links alike. With the
order observed in the tip deflection, p = log(|y2 - y1| / |y3 - y2|) / log ratio, Richardson's extrapolation y3 + (y3 - y2)/(ratio^p - 1)
takes away the leading error, and what remains is held against the converged reference.

Compared are running means over 4 ms: the straight follower of the start is no state of equilibrium and excites vibrations of every
frequency, of which each discretization has its own.
"""

import dataclasses
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import numpy as np
from numpy.typing import NDArray

from cases.case_file import load_case
from cases.ladder.row import Row, smoothed
from engines.exudyn.settings import ExudynSettings
from engines.mujoco.settings import ChainSettings
from engines.pseudo_coordinate.reference import ReferenceSettings
from engines.registry import engine
from engines.settings import Settings
from engines.start import standard_start
from engines.trajectory import Trajectory
from reference_model.mechanism import Mechanism, PrescribedSpeed

Array = NDArray[np.float64]

OUTPUT_STEP: Final = 2.5e-4  # s
MEAN: Final = 16  # rows of a running mean
CHANNELS: Final = ("tip_deflection", "tip_acceleration", "strain_1", "strain_2", "strain_3", "slider_force")
#: What extrapolated tip deflections must agree to, whatever the estimates allow.
AGREEMENT: Final = 2e-4
#: Least and most that an order is taken to be: beyond, two of the three runs agree by chance.
ORDERS: Final = (1.0, 4.0)


@dataclass(frozen=True)
class Ladder:
    """An engine with three settings, coarse to fine, and the ratio between them."""

    name: str
    settings: tuple[Settings, Settings, Settings]
    ratio: float


def ladders(elements: int, links: int) -> tuple[Ladder, Ladder]:
    """Of the general engines, by the number of elements (with 6 ms/elements as the step) and links of the coarse settings."""
    cable = [ExudynSettings(elements=elements * f, step=6e-3 / elements / f) for f in (1, 2, 4)]
    chain = [ChainSettings(links=n) for n in (links, round(1.5 * links), round(2.25 * links))]
    return Ladder("exudyn", (cable[0], cable[1], cable[2]), 2.0), Ladder("mujoco", (chain[0], chain[1], chain[2]), 1.5)


@dataclass(frozen=True)
class Limit:
    """What an engine's trajectories converge to.

    Attributes:
        engine: name.
        order: observed in the tip deflection.
        values: extrapolated, by channel.
        changes: RMS of what the last refinement changed, by channel.
    """

    engine: str
    order: float
    values: dict[str, Array]
    changes: dict[str, float]


def scene(name: str, speed: float | None = None) -> Mechanism:
    """Of the library; with a `speed` (rad/s) that the crank is given instead of a torque."""
    mechanism = load_case(name).mechanism
    if speed is None:
        return mechanism
    return dataclasses.replace(mechanism, crank=dataclasses.replace(mechanism.crank, drive=PrescribedSpeed(speed=speed)))


def trajectory_rows(label: str, mechanism: Mechanism, duration: float, climbing: Sequence[Ladder]) -> Iterator[Row]:
    """Extrapolated trajectories of each engine against the reference, and the engines' tip deflections against each other."""
    channels = CHANNELS if mechanism.crank_is_free else (*CHANNELS, "crank_torque")
    expected, coarser = (
        _channels(_solve("reference", ReferenceSettings(modes=modes, tolerance=1e-9), mechanism, duration), channels) for modes in (11, 9)
    )
    limits = [_limit(ladder, mechanism, duration, channels) for ladder in climbing]
    for limit in limits:
        for channel in channels:
            size = _rms(expected[channel])
            own = _rms(expected[channel] - coarser[channel])
            estimate = (limit.changes[channel] + own) / size
            reason = f"what the last refinement changed, and the reference's own {own / size:.1g}"
            if channel == "tip_deflection":
                estimate, reason = min(estimate, AGREEMENT), f"{reason}; at most {AGREEMENT:g}"
            yield Row(
                scene=label, engine=f"{limit.engine}, extrapolated at order {limit.order:.2f}", quantity=f"{channel}, RMS difference",
                value=_rms(limit.values[channel] - expected[channel]) / size, expected=0.0, scale=1.0, tolerance=estimate, reason=reason,
            )  # fmt: skip
    for one, other in pairwise(limits):
        size = _rms(expected["tip_deflection"])
        yield Row(
            scene=label, engine=f"{one.engine} and {other.engine}, extrapolated", quantity="tip_deflection, RMS difference",
            value=_rms(one.values["tip_deflection"] - other.values["tip_deflection"]) / size, expected=0.0, scale=1.0,
            tolerance=AGREEMENT, reason="the agreement asked for",
        )  # fmt: skip


def _limit(ladder: Ladder, mechanism: Mechanism, duration: float, channels: Sequence[str]) -> Limit:
    runs = [_channels(_solve(ladder.name, settings, mechanism, duration), channels) for settings in ladder.settings]
    first, second = (_rms(fine["tip_deflection"] - coarse["tip_deflection"]) for coarse, fine in pairwise(runs))
    order = math.log(first / second) / math.log(ladder.ratio)
    gain = ladder.ratio ** float(np.clip(order, *ORDERS)) - 1.0
    changes = {channel: runs[2][channel] - runs[1][channel] for channel in channels}
    values = {channel: runs[2][channel] + change / gain for channel, change in changes.items()}
    return Limit(ladder.name, order, values, {channel: _rms(change) for channel, change in changes.items()})


def _solve(name: str, settings: Settings, mechanism: Mechanism, duration: float) -> Trajectory:
    return engine(name).prepare(mechanism, standard_start(mechanism), settings).advance(duration, OUTPUT_STEP)


def _channels(trajectory: Trajectory, channels: Sequence[str]) -> dict[str, Array]:
    return {channel: smoothed(trajectory[channel], MEAN) for channel in channels}


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))
