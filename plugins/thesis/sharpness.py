"""How small an error of an engine the comparison of the 24 runs finds: errors planted in the machine and in the measurement.

A quantity of the machine is changed in `reference`, with fine settings, and the change of its settled cycle is added to an engine's cycle,
in proportion to the size of the error. A gain scales the channels, a delay shifts them in time. The cycle is measured anew, keeps the
engine's own estimates, and is compared with `reference` as in a report.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from scipy.interpolate import CubicSpline

from quickreturn.cases.comparison.campaign import carry_out, cross_validate
from quickreturn.cases.comparison.engines import REFERENCE, CaseResult, compare
from quickreturn.cases.files.case import Case
from quickreturn.cases.library import load_case
from quickreturn.cases.library.thesis import RUNS, run_name
from quickreturn.cases.motion.cycle import measure_cycle
from quickreturn.cases.motion.request import Run, RunRequest
from quickreturn.cases.motion.time_scale import CHANNELS, time_scale
from quickreturn.cases.running.workshop import Workshop
from quickreturn.engines.trajectory import Columns
from quickreturn.reference_model.scene_values import value_at
from quickreturn.reports.words import listed, number, percent

#: Engines in whose cycles errors are planted.
ENGINES: Final = ("exudyn", "mujoco")
#: Settings of `reference` by which the machine's change is computed.
FINE: Final = {"modes": "9", "tolerance": "3e-9"}
#: Name of an error -> the key of the machine that it changes.
OF_THE_MACHINE: Final = {
    "bending stiffness": "follower.bending_stiffness",
    "tip mass": "tip.mass",
    "damping of the arm": "follower.damping",
}
#: Relative change of the machine, to which smaller and larger ones are in proportion.
CHANGE: Final = 0.01
#: Planted sizes: relative, of a delay in milliseconds.
SIZES: Final = (0.0002, 0.0005, 0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5)
GAIN: Final = "gain"
DELAY: Final = "delay"


@dataclass(frozen=True, kw_only=True)
class Planted:
    """From which size on an error is found in each run, with both signs."""

    engine: str  # in whose cycle it is planted
    error: str  # one of `OF_THE_MACHINE`, `GAIN` or `DELAY`
    runs: tuple[int, ...]  # numbers of the runs in which both engines settle
    found: tuple[float | None, ...]  # size in each, relative or ms; None: the largest of `SIZES` is not found


Plant = Callable[[float], Mapping[str, np.ndarray]]


def planted(workshop: Workshop, runs: Sequence[int] = tuple(RUNS)) -> list[Planted]:
    """All errors in all runs. KeyboardInterrupt: Ctrl-C; the runs that were computed are stored."""
    cases = {run: load_case(run_name(run)) for run in runs}
    results = dict(zip(runs, cross_validate(list(cases.values()), workshop, (REFERENCE, *ENGINES)), strict=True))
    changed = _changed(list(cases.values()), workshop)
    rows = []
    for name in ENGINES:
        judged = [run for run, result in results.items() if all(result.runs[each].usable for each in (REFERENCE, name))]
        found = [_found(results[run], name, {error: changed[cases[run].name, error] for error in ("", *OF_THE_MACHINE)}) for run in judged]
        for error in (*OF_THE_MACHINE, GAIN, DELAY):
            sizes = tuple(from_size(of_errors[error]) for of_errors in found)
            rows.append(Planted(engine=name, error=error, runs=tuple(judged), found=sizes))
    return rows


def smallest(rows: Sequence[Planted], error: str, share: float = 0.9) -> float | None:
    """The smallest size from which on an error is found in this share of the runs, by every engine; None if the largest is not."""
    ends = []
    for row in rows:
        if row.error == error and row.found:
            sizes = sorted(math.inf if size is None else size for size in row.found)
            ends.append(sizes[math.ceil(share * len(sizes)) - 1])
    largest = max(ends, default=math.inf)
    return largest if math.isfinite(largest) else None


def found_words(rows: Sequence[Planted]) -> str:
    """The smallest errors that are found in nine of ten runs, as a sentence without its full stop; "" if there is none."""
    names = dict.fromkeys(row.error for row in rows)
    found = {name: size for name in names if (size := smallest(rows, name)) is not None}
    sizes = [f"{number(size, '.3g')} ms in time" if name == DELAY else f"{percent(size, '.3g')} in {name}" for name, size in found.items()]
    return f"An error of {listed(sizes, 'or')} of one engine would show in nine of ten runs" if sizes else ""


def from_size(found: Mapping[float, bool]) -> float | None:
    """The smallest size from which on all sizes are found."""
    missed = max((size for size, is_found in found.items() if not is_found), default=0.0)
    return min((size for size in SIZES if size > missed), default=None)


def _changed(cases: Sequence[Case], workshop: Workshop) -> dict[tuple[str, str], Columns]:
    """Settled cycles of `reference` with fine settings, by case and error; "" is the case itself."""
    requests = {}
    for case in cases:
        for error, key in (("", ""), *OF_THE_MACHINE.items()):
            changes = {key: (1.0 + CHANGE) * value_at(case.mechanism, key)} if key else {}
            requests[case.name, error] = RunRequest(
                mechanism=case.mechanism_with(changes), duration=case.duration, engine=REFERENCE, settings=FINE, estimated=False
            )
    return {name: run.cycle for name, run in carry_out(requests, workshop, "changed machines").items()}


def _found(result: CaseResult, name: str, cycles: Mapping[str, Columns]) -> dict[str, dict[float, bool]]:
    """Error -> size -> whether at least one comparison finds it, with both signs."""
    run = result.runs[name]
    plants = {error: _of_machine(run.cycle, cycles[""], cycles[error]) for error in OF_THE_MACHINE}
    plants |= {GAIN: _gain(run.cycle), DELAY: _delay(run.cycle)}

    def found(plant: Plant, size: float) -> bool:
        return bool(compare(result.case, {REFERENCE: result.runs[REFERENCE], name: _with(result.case, run, plant(size))}).missed)

    return {error: {size: found(plant, size) and found(plant, -size) for size in SIZES} for error, plant in plants.items()}


def _with(case: Case, run: Run, channels: Mapping[str, np.ndarray]) -> Run:
    """The run with other channels, measured anew; its own estimates stay."""
    cycle = {**run.cycle, **channels}
    found = measure_cycle(time_scale(case.mechanism), cycle["time"], cycle["crank_angle"], channels).measures
    names = [key for key in vars(found[0]) if not key.endswith("_estimate") and key != "parts"]
    measures = [replace(old, **{key: getattr(new, key) for key in names}) for old, new in zip(run.measured.measures, found, strict=True)]
    return replace(run, cycle=cycle, measured=replace(run.measured, measures=tuple(measures)))


def _of_machine(cycle: Columns, usual: Columns, changed: Columns) -> Plant:
    at = np.abs(cycle["crank_angle"] - cycle["crank_angle"][0])

    def values(of: Columns, channel: str) -> np.ndarray:
        return np.asarray(CubicSpline(np.abs(of["crank_angle"] - of["crank_angle"][0]), of[channel])(at))

    slopes = {channel: (values(changed, channel) - values(usual, channel)) / CHANGE for channel in CHANNELS}
    return lambda size: {channel: cycle[channel] + size * slopes[channel] for channel in CHANNELS}


def _gain(cycle: Columns) -> Plant:
    return lambda size: {channel: (1.0 + size) * cycle[channel] for channel in CHANNELS}


def _delay(cycle: Columns) -> Plant:
    time, period = cycle["time"], cycle["time"][-1] - cycle["time"][0]
    splines = {channel: CubicSpline(time, cycle[channel]) for channel in CHANNELS}
    return lambda size: {name: spline(time[0] + (time - time[0] - 1e-3 * size) % period) for name, spline in splines.items()}
