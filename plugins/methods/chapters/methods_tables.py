"""Tables of the chapter on methods: the fastest method for each error, orders, every point, and the reference's cost."""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Final

from quickreturn.plugins.methods.benchmark import Benchmark, Compiling
from quickreturn.plugins.methods.benchmark.measurement import NOT_TRIED
from quickreturn.plugins.methods.trials.queries import LEVELS, changing, fastest_at, observed_order, pareto_front, soonest_at
from quickreturn.plugins.methods.trials.trial import Trial
from quickreturn.reports.tables.cells import CASE
from quickreturn.reports.tables.table import Cell, Column, ColumnList, Table
from quickreturn.reports.words import case_label, duration, settings_words

_ERRORS: Final = {"tip_deflection": "deflection", "tip_acceleration": "tip acc.", "strain": "worst strain", "slider_force": "force"}
SCENE: Final = replace(CASE, head="scene")


def methods_of(benchmarks: Sequence[Benchmark]) -> list[str]:
    """Names of all methods, in their order."""
    return list(dict.fromkeys(trial.method for benchmark in benchmarks for trial in benchmark.trials))


def changed_words(benchmark: Benchmark, trial: Trial) -> str:
    """The settings of a trial that change along its method's ladder."""
    return settings_words(changing(trial, benchmark.trials))


def fastest(benchmarks: Sequence[Benchmark]) -> Table:
    """Solve time of each method's fastest settings within each error, per scene."""
    times = [Column(f"{name} solve_seconds", name, "[s]", ".2g") for name in methods_of(benchmarks)]
    table = Table(
        "fastest",
        """Solve time of each method's fastest settings that keep the error of the tip deflection within the limit in the heading. The
        fastest method is marked. –: no settings of the ladder reach this error. A click on a time shows the settings.""",
        (SCENE, Column("level", "error", "%", "g"), *times),
    )
    for benchmark in benchmarks:
        for level in LEVELS:
            cells: dict[str, Cell] = {}
            for name, trial in fastest_at(benchmark.trials, level).items():
                note = changed_words(benchmark, trial)
                cells[f"{name} solve_seconds"] = Cell(trial.seconds, duration(trial.seconds), note, "" if cells else "good")
            table.add(case=benchmark.case, level=level, **cells)
    return table


def waiting(benchmarks: Sequence[Benchmark]) -> Table:
    """Waiting time with each method's fastest settings to each error, if the time of the error estimate was measured."""
    parts = ("setup_seconds", "setup"), ("solve_seconds", "solve"), ("estimate_seconds", "error estimate"), ("waited_seconds", "together")
    seconds = (Column(key, head, "[s]", ".2g", words=duration) for key, head in parts)
    table = Table(
        "waiting",
        """Waiting time: set-up of the model, solution, and the other runs for the engine's estimate of its error, with the settings of the
        table above. The method with the shortest time is marked. The estimate was timed once. Compilation is not included.""",
        (SCENE, Column("level", "error", "%", "g"), "method", "settings", *seconds),
    )
    for benchmark in benchmarks:
        for level in LEVELS:
            best = fastest_at(benchmark.trials, level)
            for rank, (name, seconds_waited) in enumerate(soonest_at(benchmark.trials, level)):
                table.add(
                    best[name],
                    case=benchmark.case,
                    level=level,
                    settings=changed_words(benchmark, best[name]),
                    waited_seconds=Cell(seconds_waited, mark="" if rank else "good"),
                )
    return table


def compiling(times: Sequence[Compiling]) -> Table:
    """Times to compile engines."""
    parts = ("compile_seconds", "compiling, once"), ("load_seconds", "loading, in every process")
    table = Table(
        "compiling",
        """Wall time of an engine's first output step: when its machine code is compiled, and in a new process that finds compiled code.""",
        ("engine", *(Column(key, head, "s", ".2g") for key, head in parts)),
    )
    for time in times:
        table.add(time)
    return table


def orders(benchmarks: Sequence[Benchmark]) -> Table:
    """Order of each method's error of the tip deflection in its degrees of freedom."""
    table = Table(
        "orders",
        """Observed order: slope of the error of the tip deflection over the number of degrees of freedom in logarithmic axes, by least
        squares over the ladder. If integration or time step limit the accuracy of the finest settings, the slope is less than the method's
        own order.""",
        ("method", *(Column(benchmark.case, case_label(benchmark.case), "1", ".1f") for benchmark in benchmarks)),
    )
    for name in methods_of(benchmarks):
        table.add(method=name, **{benchmark.case: observed_order(benchmark.trials, name) for benchmark in benchmarks})
    return table


def joints(benchmark: Benchmark) -> Table:
    """Errors of each method's joint at its finest settings."""
    errors = (Column("largest_gap", unit="m", form=".1e"), Column("spurious_share", "spurious work", "%", ".2g"))
    table = Table(
        "joints",
        f"""Errors of the slider's joint in {case_label(benchmark.case)}, for the finest completed settings of each method: largest distance
        of the slider from the centre line; if force and motion of the joint are not conjugate, also the joint's work (sum of magnitudes)
        relative to the drive's.""",
        ("method", "settings", *errors),
    )
    for name in methods_of([benchmark]):
        done = [trial for trial in benchmark.trials if trial.completed and trial.method == name]
        if done and {"largest_gap", "spurious_share"} & set(done[-1].statistics):
            table.add(done[-1].statistics, method=name, settings=changed_words(benchmark, done[-1]))
    return table


def front(benchmark: Benchmark) -> Table:
    """The Pareto front of one scene."""
    table = Table(
        f"front-{benchmark.case}",
        f"""Pareto front of {case_label(benchmark.case)}: settings that no others beat in both solve time and error of the tip
        deflection.""",
        _TRIAL,
    )
    for trial in pareto_front(benchmark.trials):
        table.add(trial, **_cells(benchmark, trial))
    return table


def failures(benchmarks: Sequence[Benchmark]) -> Table:
    """Trials that failed, and the settings beyond which finer ones were not tried."""
    columns = (SCENE, "method", "settings", Column("status", "what happened"))
    table = Table("not_completed", "Settings that did not complete.", columns)
    for benchmark in benchmarks:
        listed: set[str] = set()
        for trial in benchmark.trials:
            untried = trial.status.startswith(NOT_TRIED)
            if trial.completed or (untried and trial.method in listed):
                continue
            if untried:
                listed.add(trial.method)
            table.add(trial, case=benchmark.case, settings=changed_words(benchmark, trial) + (" and finer" if untried else ""))
    return table


def trials(benchmarks: Sequence[Benchmark]) -> Table:
    """Every trial of every scene."""
    table = Table("benchmark", "Every method, all settings, all scenes", (SCENE, *_TRIAL, "status"), in_page=False)
    for benchmark in benchmarks:
        for trial in benchmark.trials:
            table.add(trial, case=benchmark.case, **_cells(benchmark, trial))
    return table


def _errors(group: str = "error") -> list[Column]:
    return [Column(key, head, "%", ".2g", group=group) for key, head in _ERRORS.items()]


_TRIAL: ColumnList = (
    "method",
    "settings",
    Column("degrees_of_freedom", "dof", form="d"),
    *_errors(),
    Column("solve_seconds", "least", "ms", ".3g", group="solve time"),
    Column("solve_seconds_median", "median", "ms", ".3g", group="solve time"),
    Column("solve_seconds_largest", "largest", "ms", ".3g", group="solve time"),
    Column("repetitions", "of", form="d", group="solve time"),
    Column("setup_seconds", "setup", "ms", ".2g"),
    Column("estimate_seconds", "estimate", "ms", ".3g", in_page=False),
)


def _cells(benchmark: Benchmark, trial: Trial) -> dict[str, Any]:
    return {"settings": changed_words(benchmark, trial)} | {key: trial.error_of(key) for key in _ERRORS}


def reference_cost(benchmark: Benchmark) -> Table:
    """The parts of the reference's time, for each of its settings."""
    columns = (
        Column("modes", form="d"),
        Column("tolerance", unit="1", form=".0e"),
        *_errors(),
        Column("solve_seconds", "solve", "ms", ".3g"),
        Column("integration_seconds", "integration", "ms", ".3g"),
        Column("calls", "right-hand sides", form=".0f"),
        Column("seconds_per_call", "each", "µs", ".2f"),
        Column("calls_per_period", "per period", "1", ".1f"),
        Column("setup_seconds", "setup", "ms", ".2g"),
    )
    table = Table(
        "reference_cost",
        f"""Cost of the reference in {case_label(benchmark.case)}: solve time with observables, and its part for the integration; number of
        evaluations of the right-hand side, time for one, and their number in a period of the highest mode (an explicit step takes twelve
        and must not be much longer than that period). Set-up prepares the tables.""",
        columns,
    )
    for trial in benchmark.trials:
        if trial.completed and trial.engine == "reference":
            calls, seconds = trial.statistics["right_hand_side_calls"], trial.statistics.get("integration_seconds", math.nan)
            cost = {"integration_seconds": seconds, "calls": calls, "seconds_per_call": seconds / calls}
            settings = {name: trial.settings[name] for name in ("modes", "tolerance")}
            errors = {key: trial.error_of(key) for key in _ERRORS}
            table.add(trial, **settings, **errors, **cost, calls_per_period=trial.statistics.get("calls_per_period"))
    return table


def scenes(benchmarks: Sequence[Benchmark]) -> Table:
    """The scenes, and the confirmation of the solution that defines the error."""
    columns = (
        SCENE,
        Column("title", "what it is"),
        Column("duration", unit="s", form="g"),
        Column("size", "RMS", "mm", ".3g"),
        Column("truth", "measured against"),
        Column("confirming", "confirmed by"),
        *_errors("difference"),
    )
    table = Table(
        "benchmark_scenes",
        """The scenes, the RMS of the tip deflection, and the difference between the solution that defines the error and the solution of
        another engine. The two share neither coordinates nor joint nor integrator.""",
        columns,
    )
    for benchmark in benchmarks:
        truth, other = benchmark.truth, benchmark.confirmation
        table.add(
            benchmark,
            size=truth.sizes["tip_deflection"],
            truth=f"{truth.engine} ({settings_words(truth.settings)})",
            confirming=f"{other.engine} ({settings_words(other.settings)})" if other.completed else f"{other.engine}: {other.status}",
            **{key: other.error_of(key) for key in _ERRORS},
        )
    return table
