"""Tables of the comparison of methods: who is fastest at which error, what falls how fast, every point, and the reference's cost."""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Final

from quickreturn.cases.benchmark import Benchmark, Compiling, fastest_at, observed_order, pareto_front
from quickreturn.cases.benchmark.findings import LEVELS, Point, completed, error_of, soonest_at
from quickreturn.cases.benchmark.measurement import NOT_TRIED
from quickreturn.reports.tables.table import CASE, Cell, Column, ColumnList, Table
from quickreturn.reports.words import case_label, duration, settings_words

_ERRORS: Final = {"tip_deflection": "deflection", "tip_acceleration": "tip acc.", "strain": "worst strain", "slider_force": "force"}
SCENE: Final = replace(CASE, head="scene")


def methods_of(tables: Sequence[Benchmark]) -> list[str]:
    """Names of all methods, in their order."""
    return list(dict.fromkeys(point.method for table in tables for point in table.points))


def fastest(tables: Sequence[Benchmark]) -> Table:
    """Solve time of each method's fastest point within an error, per scene."""
    times = [Column(f"{name} solve_seconds", name, "[s]", ".2g") for name in methods_of(tables)]
    found = Table("fastest", (SCENE, Column("level", "error", "%", "g"), *times))
    for table in tables:
        for level in LEVELS:
            cells: dict[str, Cell] = {}
            for name, (point, measured) in fastest_at(table.points, level).items():
                seconds, note = measured.solve_seconds, settings_words(point.changing)
                cells[f"{name} solve_seconds"] = Cell(seconds, duration(seconds), note, "" if cells else "good")
            found.add(case=table.case, level=level, **cells)
    return found


def waiting(tables: Sequence[Benchmark]) -> Table:
    """Of each method's fastest settings to an error what one waits for, where the time of the error estimate was measured."""
    parts = ("setup_seconds", "setup"), ("solve_seconds", "solve"), ("estimate_seconds", "error estimate"), ("waited_seconds", "together")
    seconds = (Column(key, head, "[s]", ".2g", words=duration) for key, head in parts)
    found = Table("waiting", (SCENE, Column("level", "error", "%", "g"), "method", "settings", *seconds))
    for table in tables:
        for level in LEVELS:
            best = fastest_at(table.points, level)
            for place, (name, seconds_waited) in enumerate(soonest_at(table.points, level)):
                point, measured = best[name]
                found.add(
                    measured,
                    case=table.case,
                    level=level,
                    method=name,
                    settings=settings_words(point.changing),
                    waited_seconds=Cell(seconds_waited, mark="" if place else "good"),
                )
    return found


def compiling(found: Sequence[Compiling]) -> Table:
    """What it takes to compile engines."""
    parts = ("compile_seconds", "compiling, once"), ("load_seconds", "loading, in every process")
    table = Table("compiling", ("engine", *(Column(key, head, "s", ".2g") for key, head in parts)))
    for each in found:
        table.add(each)
    return table


def orders(tables: Sequence[Benchmark]) -> Table:
    """Order of each method's error of the tip deflection in its degrees of freedom."""
    found = Table("orders", ("method", *(Column(table.case, case_label(table.case), "1", ".1f") for table in tables)))
    for name in methods_of(tables):
        found.add(method=name, **{table.case: observed_order(table.points, name) for table in tables})
    return found


def joints(table: Benchmark) -> Table:
    """What each method's joint lets through at its finest settings."""
    through = (Column("largest_gap", unit="m", form=".1e"), Column("spurious_share", "spurious work", "%", ".2g"))
    found = Table("joints", ("method", "settings", *through), case=case_label(table.case))
    for name in methods_of([table]):
        done = [(point, measured.statistics) for point, measured in completed(table.points) if point.method == name]
        if done and {"largest_gap", "spurious_share"} & set(done[-1][1]):
            found.add(done[-1][1], method=name, settings=settings_words(done[-1][0].changing))
    return found


def front(table: Benchmark) -> Table:
    """The Pareto front of one scene."""
    found = Table("front-", _POINT, of=table.case, case=case_label(table.case))
    for point in pareto_front(table.points):
        found.add(point.measured, **_told(point))
    return found


def failures(tables: Sequence[Benchmark]) -> Table:
    """Points that failed, and from where on finer settings were not tried."""
    found = Table("not_completed", (SCENE, "method", "settings", Column("status", "what happened")))
    for table in tables:
        told: set[str] = set()
        for point in table.points:
            untried = point.status.startswith(NOT_TRIED)
            if point.measured is not None or (untried and point.method in told):
                continue
            if untried:
                told.add(point.method)
            found.add(point, case=table.case, settings=settings_words(point.changing) + (" and finer" if untried else ""))
    return found


def points(tables: Sequence[Benchmark]) -> Table:
    """Every point of every scene."""
    found = Table("benchmark", (SCENE, *_POINT, "status"), in_page=False)
    for table in tables:
        for point in table.points:
            found.add(point.measured, case=table.case, status=point.status, **_told(point))
    return found


def _errors(group: str = "error") -> list[Column]:
    return [Column(key, head, "%", ".2g", group=group) for key, head in _ERRORS.items()]


_POINT: ColumnList = (
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


def _told(point: Point) -> dict[str, Any]:
    return {"method": point.method, "settings": settings_words(point.changing)} | {key: point.error(key) for key in _ERRORS}


def reference_cost(table: Benchmark) -> Table:
    """Where the reference's time goes."""
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
    found = Table("reference_cost", columns, case=case_label(table.case))
    for point, measured in completed(table.points):
        if point.engine == "reference":
            calls, seconds = measured.statistics["right_hand_side_calls"], measured.statistics.get("integration_seconds", math.nan)
            cost = {"integration_seconds": seconds, "calls": calls, "seconds_per_call": seconds / calls}
            settings = {name: point.settings[name] for name in ("modes", "tolerance")}
            found.add(measured, **settings, **{key: point.error(key) for key in _ERRORS}, **cost)
    return found


def scenes(tables: Sequence[Benchmark]) -> Table:
    """The scenes, and how the solution that errors are measured against is confirmed."""
    columns = (
        SCENE,
        Column("title", "what it is"),
        Column("duration", unit="s", form="g"),
        Column("size", "RMS", "mm", ".3g"),
        Column("truth", "measured against"),
        Column("confirming", "confirmed by"),
        *_errors("difference"),
    )
    found = Table("benchmark_scenes", columns)
    for table in tables:
        truth, other = table.truth, table.confirmation
        found.add(
            table,
            size=truth.sizes["tip_deflection"],
            truth=f"{truth.engine} ({settings_words(truth.settings)})",
            confirming=f"{other.engine}: {other.failure}" if other.failure else f"{other.engine} ({settings_words(other.settings)})",
            **{key: error_of(other.differences, key) for key in _ERRORS},
        )
    return found
