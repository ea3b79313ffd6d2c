"""Cycle after cycle of a running simulation, until the motion has settled."""

import math
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import lru_cache
from typing import Any, Final

import numpy as np

from quickreturn.cases.motion.cycle import ChannelMeasures, CycleMeasures, consensus_of
from quickreturn.cases.motion.settling import GREATEST_NUMBER, Cycle, Settling, cut_cycles
from quickreturn.cases.motion.time_scale import CHANNELS
from quickreturn.engines import progress
from quickreturn.engines.base import EngineFailure, Simulation, SteadyState
from quickreturn.engines.one_run import check_trajectory
from quickreturn.engines.start import Start
from quickreturn.engines.trajectory import Columns, Trajectory, join
from quickreturn.reference_model.mechanism import Mechanism
from quickreturn.reference_model.natural_modes import frozen_crank_modes
from quickreturn.reference_model.rigid import crank_pace
from quickreturn.reference_model.scene_values import changed

#: Samples in a period of the third mode, so that extremes are right to 1 % ...
SAMPLES: Final = 12
#: ... and their least and largest number in a turn: the modes of a stiff follower do not show.
ROWS: Final = (500, 2500)
#: Step without a mode and a speed, s.
ANY_STEP: Final = 5e-4

#: Least and largest number of rows of a cycle: with fewer it cannot be measured; a crank that takes more for a turn counts as at rest.
FEWEST_ROWS: Final = 20
MOST_ROWS: Final = 200_000
#: A cycle is advanced in pieces of at most so many rows: the time of a turn from rest is not known.
LONGEST_PIECE: Final = 20_000
#: Rows recorded after the end of a cycle, so that its last instant is not interpolated at the edge of the table.
ROWS_AFTER: Final = 4


def output_step(mechanism: Mechanism) -> float:
    """Step (s) at which a scene's cycles are recorded: 1, 2 or 5 times a power of ten.

    With too large a step for the vibrations cycles never repeat, because each samples them at other instants: a chain of 12 links at
    7 Hz with a follower of 230 Hz changes by 6e-5 from cycle to cycle for ever with 5e-4 s, by 3e-7 with 1e-4 s.
    """
    pace = crank_pace(mechanism)
    turn = 2.0 * math.pi / pace if pace > 0.0 else math.inf
    third = 0.0
    if not mechanism.follower.is_rigid and mechanism.slider.joint_stiffness > 0.0:
        third = _third_frequency(changed(mechanism, {"crank.prescribed_speed": 1.0}))
    step = min(max(1.0 / (SAMPLES * third) if third > 0.0 else ANY_STEP, turn / ROWS[1] if pace > 0.0 else 0.0), turn / ROWS[0])
    power = 10.0 ** math.floor(math.log10(step))
    return max(round(digit * power, 12) for digit in (1, 2, 5) if digit * power <= step * (1.0 + 1e-9))


@lru_cache(maxsize=4)
def _third_frequency(mechanism: Mechanism) -> float:
    """The highest of the third mode's over the turn, Hz, with the crank held: its drive does not matter."""
    return float(max(frozen_crank_modes(mechanism, angle, 3).frequencies[2] for angle in np.linspace(0.0, math.pi, 5)))


def is_determined(mechanism: Mechanism) -> bool:
    """Whether the crank's prescribed angle determines every place and speed: a disturbance does not even last for a cycle."""
    return mechanism.follower.is_rigid and mechanism.slider.is_rigid and not mechanism.crank_is_free


def settle(
    cycles: Iterable[Cycle],
    multiplier: float | None = None,
    rattles: bool = False,
    halve_step: Callable[[], None] = lambda: None,
    far: bool = False,
) -> tuple[tuple[Columns, ...], Settling]:
    """Take cycle after cycle until settled or hopeless, or until there are no more.

    Args:
        cycles: one after the other, with all columns of the trajectory.
        multiplier: largest Floquet multiplier of the steady state, if it is known.
        rattles: whether the slider's joint opens and closes, so that cycles may never repeat exactly.
        halve_step: halves the step between the rows of the cycles to come. It is called once where the changes are noise although nothing
            rattles: the rows of each cycle meet fast vibrations at other instants.
        far: whether the march did not begin in the orbit of another engine.

    Returns:
        The columns of the cycles to measure, and the settling. If the cycles settle, the last one is measured; if they keep changing, the
        last `AVERAGED`; otherwise the last one, or none if there is none.
    """
    settling, latest = Settling(multiplier=multiplier, far=far), deque[Columns](maxlen=AVERAGED)
    halved = False
    for cycle in cycles:
        latest.append(columns_of(cycle))
        progress.tell(cycle=settling.cycles + 1, most=GREATEST_NUMBER)
        if settling.feed(channels_of(latest[-1])) or settling.cycles >= GREATEST_NUMBER:
            break
        if settling.is_noise and not rattles and not halved:
            halve_step()
            halved = True
    if len(latest) == AVERAGED and settling.keeps_changing([channels_of(each) for each in latest], rattles):
        return tuple(latest), settling
    return tuple(latest)[-1:], settling


class March:
    """An endless iterator over the whole cycles of a simulation, with all its columns.

    Attributes:
        solve_seconds: wall time so far.
    """

    def __init__(self, simulation: Simulation, crank_speed: float, step: float, begun: Trajectory | None = None) -> None:
        """`crank_speed` (rad/s) at the beginning; `step` (s) between rows; `begun`: the rows of the simulation so far."""
        self._simulation, self._crank_speed, self._step, self._begun = simulation, crank_speed, step, begun
        self.solve_seconds = 0.0 if begun is None else begun.solve_seconds

    def present_start(self) -> Start | None:
        """The present state as a start, see `Simulation.present_start`."""
        return self._simulation.present_start()

    def halve_step(self) -> None:
        """From the next cycle on, halve the step between rows."""
        self._step /= 2.0

    def __iter__(self) -> Iterator[Cycle]:
        """Simulate on. EngineFailure: the run failed, or the crank is too slow or too fast for a measurement of cycles."""
        simulation, speed, rows = self._simulation, self._crank_speed, self._begun
        last_passage = simulation.time
        while True:
            step = self._step
            if rows is not None:
                cycles, speed = whole_cycles(rows), float(np.mean(rows["crank_speed"]))
                yield from cycles
                if cycles:
                    last_passage = simulation.time
                    # the next cycle begins where this one ended; a few rows before that keep the interpolation whole
                    first = max(0, int(np.searchsorted(rows["time"], cycles[-1].time[-1])) - 4)
                    rows = Trajectory({name: values[first:] for name, values in rows.columns.items()}, 0.0)
                elif simulation.time - last_passage > MOST_ROWS * step:
                    cause = f"the crank takes more than {MOST_ROWS * step:g} s for a turn"
                    raise EngineFailure(simulation.time, cause, "let it turn faster")
            turn = 2.0 * math.pi / abs(speed) if speed else math.inf
            stretch = step * math.ceil(min(turn / step, LONGEST_PIECE))
            piece = simulation.advance(stretch, step)
            check_trajectory(piece, stretch, step)
            self.solve_seconds += piece.solve_seconds
            rows = join([rows, piece]) if rows else piece


def whole_cycles(rows: Trajectory) -> list[Cycle]:
    """The whole cycles in a trajectory, with all its columns. EngineFailure: the crank turns back, or too fast for the rows recorded."""
    columns = dict(rows.columns)
    try:
        cycles = cut_cycles(columns.pop("time"), columns.pop("crank_angle"), columns)
    except ValueError as halted:
        raise EngineFailure(
            float(rows["time"][-1]), "the crank stands still or turns back", "let it turn one way, by torque or speed"
        ) from halted
    for cycle in cycles:
        if len(cycle.time) < FEWEST_ROWS:
            turn = float(cycle.time[-1] - cycle.time[0])
            cause = f"the crank takes {turn:.3g} s for a turn, much less than its drive says"
            raise EngineFailure(float(cycle.time[0]), cause, "let it begin at about the speed at which it goes on")
    return cycles


def periodic_cycle(found: SteadyState, step: float) -> tuple[Cycle, Trajectory]:
    """A whole cycle of a periodic state, recorded every `step` seconds, and its whole trajectory. Raises as `whole_cycles`."""
    duration = step * (math.ceil(found.period / step) + ROWS_AFTER)
    trajectory = found.simulation.advance(duration, step)
    check_trajectory(trajectory, duration, step)
    return whole_cycles(trajectory)[0], trajectory


def columns_of(cycle: Cycle) -> Columns:
    """A cycle as the columns of a trajectory."""
    return {"time": cycle.time, "crank_angle": cycle.crank_angle, **cycle.channels}


def channels_of(cycle: Columns, names: Iterable[str] = CHANNELS) -> Cycle:
    """Some columns of a cycle; by default those in which vibration is measured."""
    return Cycle(cycle["time"], cycle["crank_angle"], {name: cycle[name] for name in names})


#: Number of cycles for means if no cycle repeats.
AVERAGED: Final = 30
#: Number of groups of successive cycles whose means give the standard error. After the five cycles of a group a quarter of a disturbance or
#: less remains in the thesis' runs. Motions that repeat after two, three or six turns fill whole groups or pairs of them.
GROUPS: Final = 6
#: Part of a mean extreme's uncertainty that is due to scatter, in standard errors: for an extreme it is a bound, for other measures a
#: standard deviation.
BOUND: Final = 2.0
#: Part of the cycles that must resolve a first or second mode, so that the mean is not biased by selection.
RESOLVED: Final = 0.5


def standard_error(values: Sequence[float]) -> float:
    """Standard error of a mean of successive, correlated values, from the scatter of the means of `GROUPS` groups; 0 of a single value.

    It is too small if values are correlated over more than a group: by a third with a correlation of 0.77 from one to the next.
    """
    groups = [group.mean() for group in np.array_split(np.asarray(values), GROUPS) if group.size]
    return float(np.std(groups, ddof=1)) / math.sqrt(len(groups)) if len(groups) > 1 else 0.0


def mean_measures(cycles: Sequence[CycleMeasures]) -> CycleMeasures:
    """Means of the measures of successive cycles; those of a single cycle are its own.

    The uncertainty of a frequency or amplitude is the mean of the cycles', which is mostly the method's and the same in each, and the
    standard error of the mean, in quadrature; that of an extreme is `BOUND` standard errors more than the cycles' mean. A mode that less
    than `RESOLVED` of the cycles resolve is not resolved.

    Args:
        cycles: at least one; of the same channels.
    """
    measures = tuple(_mean([cycle.measures[place] for cycle in cycles]) for place in range(len(cycles[0].measures)))
    halves = dict.fromkeys(measure.half for measure in measures)
    return CycleMeasures(measures, tuple(consensus_of(half, [each for each in measures if each.half == half]) for half in halves))


def _mean(measures: Sequence[ChannelMeasures]) -> ChannelMeasures:
    """Mean of the measures of one channel in one half of successive cycles."""
    numbers: dict[str, Any] = {"half": measures[0].half, "channel": measures[0].channel}
    for name in ("first_mode_frequency", "first_mode_amplitude", "second_mode_frequency", "minimum", "maximum"):
        rows = [measure for measure in measures if getattr(measure, name) is not None]
        values, uncertainties = ([float(getattr(row, key, 0.0)) for row in rows] for key in (name, f"{name}_uncertainty"))
        resolved = len(rows) >= RESOLVED * len(measures)
        numbers[name] = float(np.mean(values)) if resolved else None
        if name == "second_mode_frequency":
            continue
        error = standard_error(values)
        uncertainty = None if not resolved else float(np.mean(uncertainties))
        if uncertainty is not None:
            uncertainty = uncertainty + BOUND * error if name in ("minimum", "maximum") else math.hypot(uncertainty, error)
        numbers[f"{name}_uncertainty"] = uncertainty
    for name in ("variation", "first_mode_frequency_gain", "first_mode_amplitude_gain"):
        known = [value for measure in measures if (value := getattr(measure, name)) is not None]
        numbers[name] = float(np.mean(known)) if known else None
    reasons = [measure.reason for measure in measures if measure.reason]
    unresolved = numbers["first_mode_frequency"] is None or numbers["first_mode_amplitude"] is None
    return ChannelMeasures(**numbers, reason=max(set(reasons), key=reasons.count) if unresolved else "")
