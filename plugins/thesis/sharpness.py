"""How small an error of an engine the comparison of the 24 runs finds: errors planted in the machine and in the measurement.

A quantity of the machine is changed in `reference`, with fine settings, and the change of its settled cycle is added to an engine's cycle,
in proportion to the size of the error. A gain scales the channels, a delay shifts them in time. The cycle is measured anew, keeps the
engine's own estimates, and is compared with `reference` as in a report.
"""

import math
from collections.abc import Callable, Mapping, Sequence, Set
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from scipy.interpolate import CubicSpline

from quickreturn.cases.comparison.campaign import carry_out, cross_validate
from quickreturn.cases.comparison.engines import KINDS, REFERENCE, CaseResult, Kind, compare
from quickreturn.cases.files.case import Case
from quickreturn.cases.files.case_file import load_case
from quickreturn.cases.library.thesis.runs import RUNS, run_name
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
#: Kinds of numbers, of which each may find an error.
ALL: Final[frozenset[Kind]] = frozenset({"frequency", "amplitude", "extreme", "waveform"})
GAIN: Final = "gain"
DELAY: Final = "delay"


@dataclass(frozen=True, kw_only=True)
class Planted:
    """The smallest size from which on an error is found in a run, with both signs; None: the largest of `SIZES` is not found."""

    run: int  # number
    engine: str  # in whose cycle it is planted
    error: str  # name, one of `OF_THE_MACHINE`, `GAIN` or `DELAY`
    found: float | None  # size that at least one comparison finds, relative; of a delay in ms
    frequency: float | None  # size that a frequency finds; likewise the others
    amplitude: float | None
    extreme: float | None
    waveform: float | None


Plant = Callable[[float], Mapping[str, np.ndarray]]


def planted(workshop: Workshop, runs: Sequence[int] = tuple(RUNS)) -> list[Planted]:
    """All errors in all runs in which both engines settle. KeyboardInterrupt: Ctrl-C; the runs that were computed are stored."""
    cases = {run: load_case(run_name(run)) for run in runs}
    results = cross_validate(list(cases.values()), workshop, (REFERENCE, *ENGINES))
    changed = _changed(list(cases.values()), workshop)
    rows = []
    for run, result in zip(cases, results, strict=True):
        of_errors = {error: changed[result.case.name, error] for error in ("", *OF_THE_MACHINE)}
        for name in ENGINES:
            if all(result.runs[each].usable for each in (REFERENCE, name)):
                rows += [
                    Planted(run=run, engine=name, error=error, found=_from(kinds, ALL), **{kind: _from(kinds, {kind}) for kind in ALL})
                    for error, kinds in _found(result, name, of_errors).items()
                ]
    return rows


def smallest(rows: Sequence[Planted], error: str, share: float = 0.9) -> float | None:
    """The smallest size from which on an error is found in this share of the runs, by every engine; None if the largest is not."""
    groups: dict[str, list[float]] = {}
    for row in rows:
        if row.error == error:
            groups.setdefault(row.engine, []).append(math.inf if row.found is None else row.found)
    ends = [sorted(sizes)[math.ceil(share * len(sizes)) - 1] for sizes in groups.values()]
    largest = max(ends, default=math.inf)
    return largest if math.isfinite(largest) else None


def found_words(rows: Sequence[Planted]) -> str:
    """The smallest errors that are found in nine of ten runs, as a sentence without its full stop; "" if there is none."""
    names = dict.fromkeys(row.error for row in rows)
    found = {name: size for name in names if (size := smallest(rows, name)) is not None}
    sizes = [f"{number(size, '.3g')} ms in time" if name == DELAY else f"{percent(size, '.3g')} in {name}" for name, size in found.items()]
    return f"An error of {listed(sizes, 'or')} of one engine would show in nine of ten runs" if sizes else ""


def _from(kinds: Mapping[float, set[Kind]], some: Set[Kind]) -> float | None:
    """The smallest size from which on some of these kinds find an error."""
    missed = [size for size, found in kinds.items() if not found & some]
    beyond = [size for size in SIZES if size > max(missed, default=0.0)]
    return min(beyond, default=None)


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


def _found(result: CaseResult, name: str, cycles: Mapping[str, Columns]) -> dict[str, dict[float, set[Kind]]]:
    """Error -> size -> kinds of numbers that find it with both signs."""
    run = result.runs[name]
    kinds: dict[str, Kind] = {quantity: kind for kind, quantities in KINDS.items() for quantity in quantities}
    kinds |= dict.fromkeys(KINDS["channel frequency"], "frequency")
    plants = {error: _of_machine(run.cycle, cycles[""], cycles[error]) for error in OF_THE_MACHINE}
    plants |= {GAIN: _gain(run.cycle), DELAY: _delay(run.cycle)}

    def found(plant: Plant, size: float) -> set[Kind]:
        judged = compare(result.case, {REFERENCE: result.runs[REFERENCE], name: _with(result.case, run, plant(size))})
        return {kinds[check.quantity] for check in judged.missed}

    return {error: {size: found(plant, size) & found(plant, -size) for size in SIZES} for error, plant in plants.items()}


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
