"""How small an error of an engine the comparison of the 24 runs finds: errors planted in the machine and in the measurement.

A quantity of the machine is changed in `reference`, with fine settings, and the change of its settled cycle is added to an engine's cycle,
in proportion to the size of the error. A gain scales the channels, a delay shifts them in time. The cycle is measured anew, keeps the
engine's own estimates, and is compared with `reference` as in a report.
"""

from collections.abc import Callable, Mapping, Sequence
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
    """In how many runs an error is found.

    Attributes:
        engine: in whose cycles it is planted.
        error: name, one of `OF_THE_MACHINE`, `GAIN` or `DELAY`.
        size: relative; of a delay in ms. Both signs are planted, and the worse one counts.
        runs: number of runs.
        found: number of runs in which at least one comparison finds it.
        frequency: number of runs in which a frequency finds it; likewise the others.
    """

    engine: str
    error: str
    size: float
    runs: int
    found: int
    frequency: int
    amplitude: int
    extreme: int
    waveform: int


Plant = Callable[[float], Mapping[str, np.ndarray]]


def planted(workshop: Workshop, runs: Sequence[int] = tuple(RUNS)) -> list[Planted]:
    """All errors in all sizes. KeyboardInterrupt: Ctrl-C; the runs that were computed are stored."""
    cases = [load_case(run_name(run)) for run in runs]
    results = cross_validate(cases, workshop, (REFERENCE, *ENGINES))
    changed = _changed(cases, workshop)
    rows = []
    for name in ENGINES:
        judged = [
            _of_run(result, name, {error: changed[result.case.name, error] for error in ("", *OF_THE_MACHINE)})
            for result in results
            if all(result.runs[each].usable for each in (REFERENCE, name))
        ]
        for error in (*OF_THE_MACHINE, GAIN, DELAY):
            for size in SIZES:
                found = [kinds[error, size] for kinds in judged]
                by_kind = {kind: sum(kind in kinds for kinds in found) for kind in ("frequency", "amplitude", "extreme", "waveform")}
                rows.append(Planted(engine=name, error=error, size=size, runs=len(found), found=sum(map(bool, found)), **by_kind))
    return rows


def smallest(rows: Sequence[Planted], error: str, share: float = 0.9) -> float | None:
    """The smallest size from which on an error is found in this share of the runs, by every engine; None if the largest is not."""
    sizes = [size for size in SIZES if all(row.found >= share * row.runs for row in rows if row.error == error and row.size >= size)]
    return min(sizes, default=None)


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


def _of_run(result: CaseResult, name: str, cycles: Mapping[str, Columns]) -> dict[tuple[str, float], set[Kind]]:
    """Error and size -> kinds of numbers that find it with both signs."""
    run = result.runs[name]
    kinds = {quantity: kind for kind, quantities in KINDS.items() for quantity in quantities}
    plants = {error: _of_machine(run.cycle, cycles[""], cycles[error]) for error in OF_THE_MACHINE}
    plants |= {GAIN: _gain(run.cycle), DELAY: _delay(run.cycle)}

    def found(plant: Plant, size: float) -> set[Kind]:
        judged = compare(result.case, {REFERENCE: result.runs[REFERENCE], name: _with(result.case, run, plant(size))})
        return {kinds[check.quantity] for check in judged.missed}

    return {(error, size): found(plant, size) & found(plant, -size) for error, plant in plants.items() for size in SIZES}


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
