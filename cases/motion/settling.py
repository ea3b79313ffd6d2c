"""Cuts a time series into whole cycles, and decides whether a sequence of cycles has settled."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from scipy.interpolate import CubicSpline

from quickreturn.reference_model.arrays import Array

TOLERANCE = 1e-3  # of the remaining error, relative to the signals' RMS
GREATEST_NUMBER = 60  # of cycles
FEWEST_CYCLES = 4  # least number of cycles to decide
GRID = 720  # crank angles per cycle on which cycles are compared
SAME_INSTANT = 1e-3  # of a cycle, by which the end of one and the beginning of the next may differ
AT_THE_END = 1e-9  # rad, by which a series may miss the farthest place and still begin or end there
TREND = 20  # number of changes for the trend, or half of all if that is less
CERTAIN = 3.0  # least slope of the changes' logarithms, in standard errors, that counts as shrinking
DRIFT = 0.7  # largest difference of the mean cycles of two halves, in median changes: scatter gives 0.1 to 0.4, a drift 15
#: The same limit if the slider rattles mildly: run 4 with a clearance of 0.2 mm wanders by 3 median changes of 0.7 %, ...
WANDER = 5.0
WANDERED = 0.03  # ... and its limit as a part of the signals' RMS, which is then the uncertainty of its means
BURSTS = 4.0  # largest ratio of its changes between the halves: 2.4 in run 5, 3.1 in run 7
SCATTER = 2.0  # largest ratio of a change to the median of all later ones, once changes no longer shrink


@dataclass(frozen=True)
class Cycle:
    """One turn of the crank from the slider's farthest place to the next."""

    time: Array  # s, shape (n,); the first and last instant are interpolated to the farthest place
    crank_angle: Array  # rad, shape (n,), continuous
    channels: dict[str, Array]  # name -> values, shape (n,)


def cut_cycles(time: Array, crank_angle: Array, channels: Mapping[str, Array]) -> list[Cycle]:
    """All whole cycles in a time series, in either direction of rotation.

    Args:
        time: s, increasing, shape (n,).
        crank_angle: rad, continuous, shape (n,).
        channels: name -> values, shape (n,).

    Raises:
        ValueError: the crank turns back.
    """
    if time.size < 4:
        return []
    progress = np.sign(crank_angle[-1] - crank_angle[0]) * crank_angle
    if not np.all(np.diff(progress) > 0.0):
        raise ValueError("the crank turns back: the series cannot be cut into cycles")
    first = np.ceil((progress[0] - np.pi - AT_THE_END) / (2.0 * np.pi))
    last = np.floor((progress[-1] - np.pi + AT_THE_END) / (2.0 * np.pi))
    passages = np.pi + 2.0 * np.pi * np.arange(first, last + 1)
    if passages.size < 2:
        return []
    instants = np.clip(CubicSpline(progress, time)(passages), time[0], time[-1])
    columns = {"crank_angle": crank_angle, **channels}
    at_ends = {"time": instants} | _splined(time, columns, instants)
    cycles = []
    step = (time[-1] - time[0]) / (time.size - 1)
    for i in range(passages.size - 1):
        # rows that all but coincide with an end would make steep interpolants of round-off
        inside = (time > instants[i] + 1e-6 * step) & (time < instants[i + 1] - 1e-6 * step)
        rows = {
            name: np.hstack([at_ends[name][i], values[inside], at_ends[name][i + 1]]) for name, values in {"time": time, **columns}.items()
        }
        angle = rows.get("follower_angle")
        if angle is not None and abs(angle[-1] - angle[0]) > np.pi:  # it turns fully: every turn begins near 180 deg
            rows["follower_angle"] = angle - 2.0 * np.pi * np.round(angle[0] / (2.0 * np.pi) - 0.5)
        cycles.append(Cycle(rows.pop("time"), rows.pop("crank_angle"), rows))
    return cycles


@dataclass(frozen=True)
class Outlook:
    """The trend of a sequence of cycles that has not settled."""

    change: float | None = None  # RMS change of the last cycle, relative to the signals' RMS; None before the second cycle
    remaining_error: float | None = (
        None  # estimated distance from the steady state, likewise relative; None where the changes do not shrink
    )
    ratio: float | None = None  # of successive changes, by their trend; None where they do not shrink
    cycles_needed: int | None = None  # in all, at this ratio; None where the changes do not shrink
    stalled_since: int | None = (
        None  # number of the cycle from which on the changes no longer shrink; None where they do, or are too few to tell
    )

    def sentence(self) -> str:
        """The trend in words, with advice."""
        if self.change is None:
            return "fewer than two cycles were made"
        seen = f"the last cycle differs from the one before by {self.change:.2g} of the signals' RMS"
        if self.ratio is not None:
            return (
                f"{seen}, which shrinks {self.ratio:.3f}-fold a cycle: about {self.remaining_error:.2g} is left, and {self.cycles_needed}"
                " cycles would be needed; more damping needs fewer, and engine reference none where its search finds the steady state"
            )
        if self.stalled_since is None:
            return f"{seen}, and there are too few cycles to decide whether this shrinks"
        return (
            f"{seen}, and this has not shrunk since cycle {self.stalled_since}; try finer settings (the noise of coarse ones does not die"
            " away), or more damping (the motion may have no period of one turn)"
        )


@dataclass
class Settling:
    """Judges cycle after cycle whether a simulation has reached its steady state.

    With c the RMS change of the channels from one cycle to the next and mu the ratio of successive changes, the remaining error is
    the geometric series c (mu + mu² + ...) = c mu/(1 - mu). The change alone is too small by a factor of three to four on the thesis' runs.
    mu is the larger of the last two ratios: after a fast transient, or with two beating modes, a single ratio would be too small. If the
    mechanism's largest Floquet multiplier is known, mu is no less than it: near a steady state a fast part of the change hides the slow
    one.

    Once the transient has died out, the changes are the noise of the computation and no longer shrink. If the multiplier m is known, the
    remaining error is at most that of the noise: the greatest of the last three changes over 1 - m. It is 0 for parts that move as the
    crank's prescribed angle alone says.

    In a march from afar the changes of two slow modes may cancel for a cycle or two while both are large. There the greatest of the last
    three changes counts, each less by m for every cycle since.
    """

    multiplier: float | None = None  # m, None where it is not known
    far: bool = False  # whether the march did not begin in the orbit of another engine
    cycles: int = field(default=0, init=False)  # number of cycles seen
    changes: list[float] = field(default_factory=list, init=False)  # c between successive cycles, one fewer than cycles
    _largest: list[dict[str, float]] = field(default_factory=list, init=False)  # change of each channel, in its own unit
    _last: dict[str, Array] = field(default_factory=dict, init=False)
    _end: float = field(default=0.0, init=False)

    def feed(self, cycle: Cycle) -> bool:
        """Take in the next cycle and answer whether it is settled.

        Raises:
            ValueError: the cycle does not begin where the one before ended (the same cycle twice would look settled).
        """
        if self.cycles and abs(cycle.time[0] - self._end) > SAME_INSTANT * (cycle.time[-1] - cycle.time[0]):
            raise ValueError(f"a cycle that begins at {cycle.time[0]:.6g} s does not follow one that ended at {self._end:.6g} s")
        present = on_common_grid(cycle)
        if self.cycles:
            self.changes.append(relative_change(self._last, present))
            self._largest.append({name: float(np.max(np.abs(present[name] - self._last[name]))) for name in present})
        self._last = present
        self._end = float(cycle.time[-1])
        self.cycles += 1
        return self.settled

    @property
    def ratio(self) -> float:
        """The observed mu; infinite before the fourth cycle."""
        if self.cycles < FEWEST_CYCLES:
            return np.inf
        observed = [new / old if old > 0.0 else 0.0 for old, new in pairwise(self.changes[-3:])]
        return max(self.multiplier or 0.0, *observed)

    @property
    def error_estimate(self) -> float:
        """Distance of the last cycle from the steady state relative to the signals' RMS; infinite where not yet known."""
        return min((factor * _greatest(self.changes, weights) for weights, factor in self._left), default=math.inf)

    @property
    def errors(self) -> dict[str, float]:
        """The error of each channel at any angle, in its own unit; no less than its last change, which may be noise."""
        left = self._left or [((1.0,), math.inf)]
        return {
            name: min(max(factor, 1.0) * _greatest([change[name] for change in self._largest], weights) for weights, factor in left)
            for name in self._last
        }

    @property
    def _left(self) -> list[tuple[tuple[float, ...], float]]:
        """Bounds of the remaining error: weights of the last changes, the greatest of which counts, and the ratio of the error to it."""
        bounds, ratio, m = list[tuple[tuple[float, ...], float]](), self.ratio, self.multiplier
        if ratio < 1.0:
            bounds.append(((1.0,) if m is None or not self.far else (m**2, m, 1.0), ratio / (1.0 - ratio)))
        if self.cycles >= FEWEST_CYCLES and m is not None and m < 1.0:
            bounds.append(((1.0, 1.0, 1.0), 1.0 / (1.0 - m)))
        return bounds

    @property
    def settled(self) -> bool:
        """Whether the last cycle is settled."""
        return self.error_estimate < TOLERANCE

    @property
    def is_noise(self) -> bool:
        """Whether the last changes are noise: they shrink by less than half as much as the known multiplier says."""
        if self.cycles < FEWEST_CYCLES or self.multiplier is None or not self.multiplier < 1.0:
            return False
        return self.changes[-1] > self.changes[-3] * ((1.0 + self.multiplier) / 2.0) ** 2

    def keeps_changing(self, cycles: Sequence[Cycle], rattles: bool = False) -> bool:
        """Whether the changes of the given last cycles neither shrink nor grow nor add up to a drift.

        Where the slider `rattles` they may come and go, and the motion may wander a little.
        """
        half, stalled = len(cycles) // 2, self.outlook.stalled_since
        still = stalled is not None and stalled <= self.cycles - 2 * half + 1
        if self.settled or half < 2 or not (still or rattles):
            return False
        parts = (self._largest[-2 * half + 1 : -half], self._largest[-half:])
        sizes = [{name: float(np.median([change[name] for change in part])) for name in self._last} for part in parts]
        scatter = max(max(pair) / max(min(pair), np.finfo(float).tiny) for pair in zip(*(size.values() for size in sizes), strict=True))
        grids = [on_common_grid(cycle) for cycle in cycles]
        means = [{name: np.mean([grid[name] for grid in part], axis=0) for name in self._last} for part in (grids[:half], grids[half:])]
        drift, change = relative_change(*means), float(np.median(self.changes[-half:]))
        if still and scatter <= SCATTER and drift <= DRIFT * change:
            return True
        return rattles and scatter <= BURSTS and drift <= min(WANDER * change, WANDERED)

    @property
    def outlook(self) -> Outlook:
        """The outlook from the changes so far. Their trend is a straight line through the logarithms of the last ones."""
        if not self.changes:
            return Outlook()
        change = self.changes[-1]
        logarithms = np.log(np.maximum(self.changes, np.finfo(float).tiny))[-min(TREND, max(4, len(self.changes) // 2)) :]
        if logarithms.size < 4:
            return Outlook(change)
        (slope, _), covariance = np.polyfit(np.arange(logarithms.size), logarithms, 1, cov=True)
        ratio = max(math.exp(slope), self.multiplier or 0.0)
        if slope < -CERTAIN * math.sqrt(covariance[0, 0]) and ratio < 1.0:
            left = change * ratio / (1.0 - ratio)
            more = math.ceil(math.log(max(left / TOLERANCE, 1.0)) / -math.log(ratio))
            return Outlook(change, left, ratio, self.cycles + more)
        stalled = next(i for i, c in enumerate(self.changes) if c <= SCATTER * float(np.median(self.changes[i:])))
        return Outlook(change, stalled_since=stalled + 2)


def _greatest(changes: Sequence[float], weights: Sequence[float]) -> float:
    """The greatest of the last changes, weighted."""
    return max(weight * change for weight, change in zip(weights[::-1], changes[::-1], strict=False))


def on_common_grid(cycle: Cycle) -> dict[str, Array]:
    """The channels at evenly spaced crank angles, each of shape (720,)."""
    turned = np.abs(cycle.crank_angle - cycle.crank_angle[0])
    grid = np.linspace(0.0, 2.0 * np.pi, GRID, endpoint=False)
    return _splined(turned, cycle.channels, grid)


def _splined(x: Array, columns: Mapping[str, Array], at: Array) -> dict[str, Array]:
    """Cubic splines through columns over `x`, evaluated at other places; all at once, which takes half the time of one by one."""
    values = CubicSpline(x, np.column_stack(list(columns.values())))(at) if columns else np.empty((at.size, 0))
    return dict(zip(columns, np.ascontiguousarray(values.T), strict=True))


def relative_change(before: Mapping[str, Array], now: Mapping[str, Array]) -> float:
    """RMS over channels of each channel's RMS change relative to its RMS; channels that are zero throughout do not count."""
    shares = [
        np.mean((now[name] - before[name]) ** 2) / mean_square for name in now if (mean_square := float(np.mean(now[name] ** 2))) > 0.0
    ]
    return float(np.sqrt(np.mean(shares))) if shares else 0.0
