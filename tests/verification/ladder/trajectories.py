"""Third rung: what the engines' trajectories converge to.

Each engine solves a scene with settings refined three times along each direction of its discretization, the other held: step and
elements in Exudyn, whose errors have opposite signs and would hide each other's order, links in MuJoCo. With the order observed in the
tip deflection, p = log(|y2 - y1| / |y3 - y2|) / log ratio, Richardson's (y3 - y2)/(ratio^p - 1) of each direction is added to the finest
run, and what remains is held against the converged reference.

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

from quickreturn.cases.library import load_case
from quickreturn.engines.exudyn.settings import ExudynSettings
from quickreturn.engines.mujoco.settings import ChainSettings
from quickreturn.engines.own.reference import ReferenceSettings
from quickreturn.engines.registry import engine
from quickreturn.engines.settings import Settings
from quickreturn.engines.start import standard_start
from quickreturn.engines.trajectory import Trajectory
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.mechanism import Mechanism, PrescribedSpeed
from tests.verification.row import Row, smoothed

OUTPUT_STEP: Final = 2.5e-4  # s
MEAN: Final = 16  # rows of a running mean
CHANNELS: Final = ("tip_deflection", "tip_acceleration", "strain_1", "strain_2", "strain_3", "slider_force")
#: What extrapolated tip deflections must agree to, whatever the estimates allow.
AGREEMENT: Final = 2e-4
#: Least and most that an order is taken to be: beyond, two of the three runs agree by chance.
ORDERS: Final = (1.0, 4.0)


@dataclass(frozen=True)
class Direction:
    """One way of refining: three settings, coarse to fine, and the ratio between them."""

    name: str
    settings: tuple[Settings, Settings, Settings]
    ratio: float


@dataclass(frozen=True)
class Ladder:
    """An engine, its directions of refinement, and its finest settings, which end one of them."""

    engine: str
    directions: tuple[Direction, ...]
    finest: Settings


def ladders(elements: int, step: float, links: int) -> tuple[Ladder, Ladder]:
    """Of the general engines, by Exudyn's middle number of elements and finest step (s), and MuJoCo's coarsest number of links."""
    steps = [ExudynSettings(elements=elements, step=factor * step, newton_tolerance=1e-6) for factor in (4, 2, 1)]
    cables = [ExudynSettings(elements=count, step=step, newton_tolerance=1e-6) for count in (elements // 2, elements, 2 * elements)]
    chains = [ChainSettings(links=count) for count in (links, round(1.5 * links), round(2.25 * links))]
    refined = Direction("step", (steps[0], steps[1], steps[2]), 2.0), Direction("elements", (cables[0], cables[1], cables[2]), 2.0)
    return (
        Ladder("exudyn", refined, cables[2]),
        Ladder("mujoco", (Direction("links", (chains[0], chains[1], chains[2]), 1.5),), chains[2]),
    )


@dataclass(frozen=True)
class Limit:
    """What an engine's trajectories converge to."""

    engine: str
    orders: str  # observed in the tip deflection, in words
    values: dict[str, Array]  # extrapolated, by channel
    errors: dict[str, float]  # RMS of what the finest run may be off, if errors fall at least as each step, element or link


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
            estimate = (limit.errors[channel] + own) / size
            reason = f"that of the finest run, if errors fall at first order, and the reference's {own / size:.1g}"
            if channel == "tip_deflection":
                estimate, reason = min(estimate, AGREEMENT), f"{reason}; at most {AGREEMENT:g}"
            yield Row(
                scene=label, engine=f"{limit.engine}, extrapolated, order {limit.orders}", quantity=f"{channel}, RMS difference",
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
    wanted = dict.fromkeys(settings for direction in ladder.directions for settings in direction.settings)
    runs = {settings: _channels(_solve(ladder.engine, settings, mechanism, duration), channels) for settings in wanted}
    values, errors, orders = dict(runs[ladder.finest]), dict.fromkeys(channels, 0.0), []
    for direction in ladder.directions:
        coarse, middle, fine = (runs[settings] for settings in direction.settings)
        first, second = (_rms(b["tip_deflection"] - a["tip_deflection"]) for a, b in ((coarse, middle), (middle, fine)))
        order = math.log(first / second) / math.log(direction.ratio)
        orders.append(f"{order:.2f} in {direction.name}")
        for channel in channels:
            change = fine[channel] - middle[channel]
            values[channel] = values[channel] + change / (direction.ratio ** float(np.clip(order, *ORDERS)) - 1.0)
            errors[channel] += _rms(change) / (direction.ratio - 1.0)
    return Limit(ladder.engine, " and ".join(orders), values, errors)


def _solve(name: str, settings: Settings, mechanism: Mechanism, duration: float) -> Trajectory:
    return engine(name).prepare(mechanism, standard_start(mechanism), settings).advance(duration, OUTPUT_STEP)


def _channels(trajectory: Trajectory, channels: Sequence[str]) -> dict[str, Array]:
    return {channel: smoothed(trajectory[channel], MEAN) for channel in channels}


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))
