"""A recorded table treated like an engine: cut into turns of the crank, and one of them measured.

Engines are compared with it in the same state. A table that begins in the standard start and has not settled shows a transient: its last
whole turn is compared with the same turn of each engine (`RunRequest.turn`). Any other table is taken as the steady state, whether it
settles within the table, or the table has one turn, or turns that differ by noise.

No error is claimed for the table's model. Only the uncertainty of the measures counts, and what the noise of its rows does to them: the
departure of rows from a smooth course (noise, rounding, sampling). That of an extreme comes from it, too, and from the difference of the
last turn from the one before.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, Final

import numpy as np

from quickreturn.cases.comparison.first_row import first_row
from quickreturn.cases.files.case import Case
from quickreturn.cases.files.errors import CaseError
from quickreturn.cases.files.instants import noise_of, scatter
from quickreturn.cases.files.recorded import RecordedTable
from quickreturn.cases.files.units import in_si
from quickreturn.cases.motion.cycle import EXTREMES, VIBRATION, ChannelMeasures, measure_cycle
from quickreturn.cases.motion.endings import Ending
from quickreturn.cases.motion.estimates import MeasuredNumbers, mean_estimate
from quickreturn.cases.motion.marching import columns_of
from quickreturn.cases.motion.request import STANDARD, Approach, Recording, Run
from quickreturn.cases.motion.settling import AT_THE_END, GREATEST_NUMBER, TOLERANCE, Cycle, Settling, cut_cycles, on_common_grid
from quickreturn.cases.motion.time_scale import CHANNELS, SAMPLES, TURN, time_scale
from quickreturn.engines.trajectory import rms
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.columns import COLUMNS, SHAPE
from quickreturn.reference_model.mechanism import Mechanism
from quickreturn.reference_model.rigid import crank_pace, mean_crank_speed

#: Columns without extremes: they grow from turn to turn.
GROWING: Final = ("time", "crank_angle", "dissipated_energy", "drive_work")
#: Columns that are not compared: those of a model's own, and the centre line, which tip and gauges represent.
LEFT_OUT: Final = ("constraint_gap", *SHAPE)
#: Columns that decide whether a table has settled, if it has any of them.
VIBRATING: Final = (*CHANNELS, "tip_deflection", "slider_force")
#: Largest distance of rows, and largest missing part at the ends of a single turn, as a part of a turn.
LARGEST_GAP: Final = 0.01
#: Least number of rows in a period of the first mode for its measurement.
ROWS_PER_PERIOD: Final = 4.0
#: Least number of rows that show the noise of a column.
FEWEST_ROWS: Final = 5
#: Largest factor between the time of a turn and that of the drive.
OFF: Final = 2.0
#: Largest backward step of the recorded crank angle, rad: the noise of an encoder.
BACKLASH: Final = 0.02
#: Least change of a column's mean from the first turn to the last, as a part of its RMS, that counts as a drift.
DRIFTED: Final = 0.01
#: Largest part of that change by which the turns may differ otherwise.
STEADY: Final = 0.15
#: Least distance from the steady state, as a part of the signals' RMS, at which a table does not show it.
FAR: Final = 0.1
#: Largest ratio of a step of the crank angle between two rows to the usual step.
WRAPPED: Final = 100.0
NOTHING_TO_FIT: Final = "extremes alone are measured of this column"


def recorded_run(table: RecordedTable, case: Case) -> Run:
    """The run with the measures of a table on a case.

    Raises:
        CaseError: the table declares another case, has another crank speed than the drive, no whole turn, too few rows or a crank that
            turns back.
    """
    mechanism = case.mechanism
    if table.declared.get("case", case.name) != case.name:
        raise CaseError(table.shown, "case", f'"{table.declared["case"]}"', f'is not "{case.name}"', "compare it with the case it declares")
    columns, remarks = dict(table.columns), [*table.noted]
    if "crank_angle" not in columns:
        speed = mean_crank_speed(mechanism)
        columns["crank_angle"] = mechanism.crank.initial_angle + speed * columns["time"]
        start = math.degrees(mechanism.crank.initial_angle)
        evenly = case.units.of("rad/s").text(speed, ".6g")
        remarks.append(f"no crank_angle was recorded: the crank is taken to turn evenly at {evenly}, from {start:.6g} deg at time 0")
        if abs(first := float(columns["time"][0])) * crank_pace(mechanism) > 2.0 * math.pi * LARGEST_GAP:
            remarks.append(f"if it is there in the first row, at {first:.6g} s, {table.without('time', first)}")
    elif "crank_angle" in table.unwrapped:  # which turn it is in, the wrapped angle does not say
        _check_turns(table, columns["time"], crank_pace(mechanism))
        turns = round((mechanism.crank.initial_angle - float(columns["crank_angle"][0])) / (2.0 * math.pi))
        columns["crank_angle"] = columns["crank_angle"] + 2.0 * math.pi * turns
    _check_pace(table, columns, mechanism, case.name)
    begun, odd, late = first_row(table, columns, mechanism, _rows_before_gap(columns["time"], crank_pace(mechanism)))
    if late:
        columns["time"] = columns["time"] - late
        remarks.append(f"its time is counted from the first row, at {late:.6g} s: all else in it is the standard start")
    cycles = _cycles(table, columns)
    cycles, missing = _after_gaps(table, cycles[:GREATEST_NUMBER] if begun else cycles)
    remarks += missing
    drifts = {} if begun else _drifts(cycles)
    if left := [name for name in _deciding_columns(cycles[0]) if name not in drifts]:
        cycles = [replace(cycle, channels={name: each for name, each in cycle.channels.items() if name not in drifts}) for cycle in cycles]
    for name, slope in drifts.items():
        unit = case.units.of(COLUMNS[name].unit)
        told = f"{name} does not repeat: it drifts by {unit.text(slope, '.3g')} a second{' and is left out' if left else ''}"
        remarks.append(f"{told}; {table.without(name, slope, 'time')} to take a straight line off")
    settling = _settling(cycles)
    far = _is_far(settling, cycles[-1]) or not left
    settled = bool(left) and (settling.settled or _repeats(settling))
    begins = far if begun is None else begun
    if odd and begins:
        remarks.append(f"its first row is not that of the standard start: {odd}")
    last = columns_of(cycles[-1])
    turn = _turn_number(mechanism, last["crank_angle"]) if begins and left and not settled else None
    recording = Recording(table.shown, len(columns["time"]), table.declared, table.of_experiment, late, table.told)
    counted = columns["time"] >= cycles[0].time[0] if missing else slice(None)
    angle_noise = scatter(columns["time"][counted], columns["crank_angle"][counted])
    late = _lateness_of_cuts(last, angle_noise)
    errors = {name: noise_of(last["time"], last[name]) + _at_cuts(last, name, late) for name in last if name not in GROWING}
    if turn is None:
        errors = {name: error + _change(cycles, settling, name) for name, error in errors.items()}
        if left and not settled:
            remarks.append(_unsettled(settling, far, odd))
    unsettled = Ending.NOT_SETTLED if far else Ending.ASSUMED
    return Run(
        engine=table.name,
        method=table.declared.get("source", "recorded table"),
        version=table.declared.get("version"),
        estimate_of="recorded",
        status=Ending.TRANSIENT if turn is not None else Ending.SETTLED if settled else unsettled,
        remark="; ".join(remarks),
        recording=recording,
        approach=Approach(
            start=STANDARD if begins else None,
            turn=turn,
            settled=settling.settled,
            cycles=len(cycles),
            settling_error=settling.error_estimate if turn is None and math.isfinite(settling.error_estimate) else None,
            settling_errors=errors,
        ),
        measured=_measured(mechanism, last, recording.filtered, late),
        cycle=last,
    )


def _check_pace(table: RecordedTable, columns: Mapping[str, Array], mechanism: Mechanism, case: str) -> None:
    """Raise unless the crank turns about as fast as with its drive, and the same way."""
    time, angle = columns["time"], columns["crank_angle"]
    pace = crank_pace(mechanism)
    if pace <= 0.0 or len(time) < 2:
        return
    if (angle[-1] - angle[0]) * mean_crank_speed(mechanism) < 0.0:
        told = f"runs from {angle[0]:.6g} to {angle[-1]:.6g} rad, but the drive of {case} turns the crank the other way"
        raise CaseError(table.shown, "crank_angle", None, told, "angles count counter-clockwise")
    ratio = abs(float(angle[-1] - angle[0])) / float(time[-1] - time[0]) / pace  # of the table's crank speed to the drive's
    steps = np.abs(np.diff(angle))
    usual = float(np.median(steps[steps > 0.0])) if np.any(steps > 0.0) else 0.0  # an encoder may stand still from row to row
    jumps = np.where(steps > OFF * pace * np.diff(time), steps, 0.0)  # where rows are missing, the crank turned on
    if np.max(jumps) > WRAPPED * usual:
        at = int(np.argmax(jumps))
        told = f"jumps from {angle[at]:.6g} to {angle[at + 1]:.6g} rad after {time[at]:.6g} s"
        raise CaseError(table.shown, "crank_angle", None, told, "let it run on from turn to turn, and leave no gaps in time")
    if 1.0 / OFF <= ratio <= OFF:
        return
    turn = 2.0 * math.pi / pace
    told = f"a turn of the crank takes {turn / ratio if ratio else math.inf:.3g} s in it, but the drive of {case} turns it in {turn:.3g} s"
    raise CaseError(table.shown, "time, crank_angle", None, told, "check their units (none: SI), or give the case the drive of the table")


def _rows_before_gap(time: Array, pace: float) -> int:
    """Number of rows before the first gap of more than `LARGEST_GAP` of a turn; all rows if these are too few to show noise."""
    rows = int(np.argmax(np.append(np.diff(time) * pace > 2.0 * math.pi * LARGEST_GAP, True))) + 1
    return rows if rows >= FEWEST_ROWS else len(time)


def _check_turns(table: RecordedTable, time: Array, pace: float) -> None:
    """Raise if a wrapped crank angle may have passed any number of turns between two rows."""
    if pace * float(np.max(np.diff(time), initial=0.0)) > math.pi:
        at = int(np.argmax(np.diff(time)))
        told = f"has no row for {time[at + 1] - time[at]:.3g} s after {time[at]:.6g} s, and the wrapped crank_angle does not tell its turns"
        raise CaseError(table.shown, "time", None, told, "leave out the rows before, or give an angle that runs on from turn to turn")


def _after_gaps(table: RecordedTable, cycles: list[Cycle]) -> tuple[list[Cycle], list[str]]:
    """The turns after the last one that lacks rows, and a remark on those left out. CaseError: the last turn itself lacks rows."""
    steps = [np.diff(cycle.time) for cycle in cycles]
    lacking = [k for k, each in enumerate(steps) if np.min(each) <= 0.0 or np.max(each) > LARGEST_GAP * np.sum(each)]
    if not lacking:
        return cycles, []
    at, after = lacking[-1], len(cycles) - 1 - lacking[-1]
    most = LARGEST_GAP * float(cycles[-1].time[-1] - cycles[-1].time[0])
    accepted = f"at most {most:.3g} s, {LARGEST_GAP} of a turn, are accepted"
    if (usual := float(np.median(np.diff(table.columns["time"])))) > most:
        accepted += "; ignore a column with empty cells, whose rows are left out" * ("empty cell" in table.told)
        raise CaseError(table.shown, "time", None, f"has a row every {usual:.3g} s", accepted)
    gap, since = float(np.max(steps[at])), float(cycles[at].time[np.argmax(steps[at])])
    if not after:
        raise CaseError(table.shown, "time", None, f"{gap:.3g} s without a row after {since:.6g} s", accepted)
    turns = f"{len(lacking)} of its turns lack{'s' * (len(lacking) == 1)} rows for more than {most:.3g} s"
    return cycles[-after:], [f"{turns}: only the {after} turn{'s' * (after > 1)} after {cycles[at].time[-1]:.6g} s are used"]


def _cycles(table: RecordedTable, columns: Mapping[str, Array]) -> list[Cycle]:
    """All whole turns, with every column; a single turn that lacks little at its ends is closed, as if it repeated."""
    time, angle = columns["time"], _rising(table, columns["time"], columns["crank_angle"])
    channels = {name: values for name, values in columns.items() if name not in ("time", "crank_angle", *LEFT_OUT)}
    cycles = cut_cycles(time, angle, channels)
    turns = abs(float(angle[-1] - angle[0])) / (2.0 * math.pi)
    if not cycles and 1.0 - LARGEST_GAP <= turns < 1.0 + LARGEST_GAP and len(time) > 1:
        turn, period = math.copysign(2.0 * math.pi, angle[-1] - angle[0]), float(time[-1] - time[0]) / turns
        inside = abs(angle - angle[0]) < 2.0 * math.pi * (1.0 - 1e-9)
        around = {name: np.pad(values[inside], 1, mode="wrap") for name, values in channels.items()}
        time, angle = time[inside], angle[inside]
        ends = ([time[-1] - period], time, [time[0] + period]), ([angle[-1] - turn], angle, [angle[0] + turn])
        cycles = cut_cycles(np.concatenate(ends[0]), np.concatenate(ends[1]), around)
    if not cycles:
        told = f"covers {turns:.3g} turns of the crank, from {math.degrees(angle[0]):.4g} to {math.degrees(angle[-1]):.4g} deg"
        accepted = "a whole turn is needed, from the slider's farthest place (180 deg) to the next"
        raise CaseError(table.shown, "crank_angle", None, told, accepted)
    return cycles


def _turn_number(mechanism: Mechanism, crank_angle: Array) -> int:
    """Number of a whole turn since the standard start, counted from 1 as `cut_cycles` finds them there; from its crank angles, rad."""
    sign = math.copysign(1.0, crank_angle[-1] - crank_angle[0])
    first = math.ceil((sign * mechanism.crank.initial_angle - math.pi - AT_THE_END) / (2.0 * math.pi))
    return round((sign * float(crank_angle[0]) - math.pi) / (2.0 * math.pi)) - first + 1


def _rising(table: RecordedTable, time: Array, angle: Array) -> Array:
    """The crank angle made strictly monotonic: backward steps and standstills, an encoder's noise, are interpolated."""
    sign = math.copysign(1.0, angle[-1] - angle[0])
    farthest = np.maximum.accumulate(sign * angle)
    back = farthest - sign * angle
    if np.max(back) > BACKLASH:
        at = int(np.argmax(back > BACKLASH))
        told = f"turns back after {time[at]:.6g} s"
        raise CaseError(table.shown, "crank_angle", None, told, "a crank that turns one way is needed, its angle running on beyond 360 deg")
    if np.all(np.diff(sign * angle) > 0.0):
        return angle
    new = np.flatnonzero(np.diff(farthest, prepend=-np.inf) > 0.0)
    beyond = farthest[-1] + (time - time[new[-1]]) * (farthest[-1] - farthest[0]) / (time[-1] - time[0])
    return np.asarray(sign * np.where(time > time[new[-1]], beyond, np.interp(time, time[new], farthest[new])))


def _settling(cycles: list[Cycle]) -> Settling:
    settling, names = Settling(), _deciding_columns(cycles[0])
    for cycle in cycles:
        settling.feed(Cycle(cycle.time, cycle.crank_angle, {name: cycle.channels[name] for name in names}))
    return settling


def _drifts(cycles: Sequence[Cycle]) -> dict[str, float]:
    """Columns that the last turn repeats but for a constant, with their change a second, in SI: that of the means of the turns."""
    slopes = dict[str, float]()
    for name in _deciding_columns(cycles[0]) if len(cycles) > 1 else ():
        grids = [on_common_grid(Cycle(each.time, each.crank_angle, {name: each.channels[name]}))[name] for each in cycles]
        apart, means = grids[-1] - grids[0], [float(np.mean(grid)) for grid in grids]
        moved = abs(means[-1] - means[0])
        if moved > DRIFTED * rms(grids[-1]) and rms(apart - np.mean(apart)) < STEADY * moved:
            slopes[name] = float(np.polyfit([float(np.mean(each.time[[0, -1]])) for each in cycles], means, 1)[0])
    return slopes


def _deciding_columns(cycle: Cycle) -> list[str]:
    """Columns that decide whether a table has settled."""
    return [name for name in cycle.channels if name in VIBRATING] or [name for name in cycle.channels if name not in GROWING]


def _repeats(settling: Settling) -> bool:
    """Whether turns differ by less than counts as settled, and as much as all before, or by less and less."""
    outlook = settling.outlook
    left = 0.0 if outlook.stalled_since is not None else math.inf if outlook.remaining_error is None else outlook.remaining_error
    return max(outlook.change or 0.0, left) < TOLERANCE


def _is_far(settling: Settling, last: Cycle) -> bool:
    """Whether the steady state is still far; with too few turns for a trend, whether they change by more than noise."""
    outlook = settling.outlook
    if outlook.remaining_error is not None:
        return outlook.remaining_error > FAR
    if outlook.change is None or outlook.stalled_since is not None:
        return False
    sizes = {name: rms(last.channels[name]) for name in _deciding_columns(last)}
    noise = [noise_of(last.time, last.channels[name]) / size for name, size in sizes.items() if size > 0.0]
    return outlook.change > max((FAR, *noise))


def _unsettled(settling: Settling, far: bool, odd: str) -> str:
    """A remark on a table that has not settled."""
    if settling.cycles == 1:
        return "it holds one turn, which is taken to repeat"
    outlook = settling.outlook
    change = f"its last turn differs from the one before by {outlook.change:.2g} of the signals' RMS"
    if far:
        return f"{change}, and it does not begin in the standard start{odd and f' ({odd})'}; record longer, or from there"
    return f"{change}{'' if outlook.change and outlook.change < TOLERANCE else ': noise, or not quite settled'}"


def _change(cycles: list[Cycle], settling: Settling, name: str) -> float:
    """Distance of a column from its steady state: its last change from turn to turn, or the extrapolation by the changes' ratio.

    For a single turn the change is the difference between its end and its beginning.
    """
    now = cycles[-1].channels[name]
    if len(cycles) == 1:
        return abs(float(now[-1] - now[0]))
    pair = [on_common_grid(Cycle(cycle.time, cycle.crank_angle, {name: cycle.channels[name]}))[name] for cycle in cycles[-2:]]
    ratio = settling.ratio
    return float(np.max(np.abs(pair[1] - pair[0]))) * (max(1.0, ratio / (1.0 - ratio)) if ratio < 1.0 else 1.0)


def _lateness_of_cuts(cycle: Mapping[str, Array], angle_noise: float) -> float:
    """Uncertainty, s, of the instants at which the turn is cut into halves, from the noise of the crank angle, rad."""
    turned = abs(float(cycle["crank_angle"][-1] - cycle["crank_angle"][0]))
    return min(angle_noise / turned, LARGEST_GAP) * float(np.ptp(cycle["time"]))


def _at_cuts(cycle: Mapping[str, Array], name: str, late: float) -> float:
    """Uncertainty of a column where the turn is cut into halves, from that of the cuts, s."""
    time, turned = cycle["time"], np.abs(cycle["crank_angle"] - cycle["crank_angle"][0])
    cuts = np.interp([0.0, math.pi, 2.0 * math.pi], turned, time)
    values = np.interp(np.add.outer([-late, 0.0, late], cuts), time, cycle[name])
    return float(np.max(np.abs(values - values[1])))


def _measured(mechanism: Mechanism, cycle: Mapping[str, Array], filtered: bool, late: float) -> MeasuredNumbers:
    """Measures of every column that does not grow, and the consensus on the first mode's frequency.

    `late`: uncertainty of the instants at which the turn is cut into halves, s.
    """
    time, angle = cycle["time"], cycle["crank_angle"]
    scale, reason, gap = time_scale(mechanism), "", float(np.max(np.diff(time)))
    if scale is not None:
        largest = 1.0 / float(np.max(scale.frequencies(TURN)[:, 0])) / ROWS_PER_PERIOD
        if gap > largest:
            ms = in_si("ms")
            reason = f"rows lie up to {gap / ms:.3g} ms apart; the first mode takes {largest / ms:.3g} ms at most"
    channels = {name: cycle[name] for name in CHANNELS if name in cycle}
    of_cycle = measure_cycle(None if reason else scale, time, angle, channels, filtered)
    measures = [
        replace(each, reason=reason or each.reason, **_NONE_CLAIMED, **_moved_by_noise(each, time, cycle[each.channel], late))
        for each in of_cycle.measures
    ]
    for name in (name for name in cycle if name not in (*CHANNELS, *GROWING)):
        of_column = measure_cycle(None, time, angle, {name: cycle[name]}, filtered).measures
        measures += [replace(each, reason=NOTHING_TO_FIT, **_NONE_CLAIMED) for each in of_column]
    consensus = (replace(each, first_mode_frequency_estimate=mean_estimate(measures, each.half)) for each in of_cycle.consensus)
    return MeasuredNumbers(measures=tuple(measures), consensus=tuple(consensus), unestimated="")


#: Error estimates of a table's measures: no error is claimed for its model.
_NONE_CLAIMED: Final[dict[str, Any]] = {f"{quantity}_estimate": 0.0 for quantity in EXTREMES}


def _moved_by_noise(measure: ChannelMeasures, time: Array, values: Array, late: float) -> dict[str, Any]:
    """What noise of the rows does to the numbers of a vibration, as their error estimates.

    The response holds for noise in as many instants as are fitted, of which fewer rows determine no more than they are. As for an extreme
    the scatter counts, several standard deviations: of 3,793 numbers of right tables with noise of 0.3 to 3 % two depart by more. Where the
    turn is cut late, by `late` (s) at most, the whole signal is.
    """
    independent = min(SAMPLES, len(time) / 2.0)  # rows in a half
    moved = scatter(time, values) / math.sqrt(independent) + late * rms(np.gradient(values, time))
    return {f"{quantity}_estimate": measure.response(quantity) * moved for quantity in VIBRATION}
