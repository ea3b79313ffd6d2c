"""Tables of the comparison of methods: who is fastest at which error, what falls how fast, every point, and the reference's cost."""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Final

from cases.benchmark import Benchmark, fastest_at, observed_order, pareto_front
from cases.benchmark.findings import LEVELS, Point, completed, error_of
from cases.benchmark.measurement import NOT_TRIED
from reports.tables.table import CASE, Cell, Column, Table, TableBuilder
from reports.words import case_label, duration, settings_words

_ERRORS = (("tip_deflection", "deflection"), ("tip_acceleration", "tip acc."), ("strain", "worst strain"), ("slider_force", "force"))


SCENE: Final = replace(CASE, head="scene")


def methods_of(tables: Sequence[Benchmark]) -> list[str]:
    """Names of all methods, in their order."""
    return list(dict.fromkeys(point.method for table in tables for point in table.points))


def fastest(tables: Sequence[Benchmark]) -> Table:
    """Solve time of each method's fastest point within an error, per scene."""
    names = methods_of(tables)
    builder = TableBuilder(
        "fastest",
        "Solve time of the fastest settings of each method whose error of the tip deflection is at most the one given; the fastest method"
        " is marked, – where no settings of the ladder get there. The settings are shown where the pointer rests.",
        (
            SCENE,
            Column("level", "error", "1", "g", "%", 100.0),
            *(Column(f"{name} solve_seconds", name, "s", ".2g", shown_unit="") for name in names),
        ),
    )
    for table in tables:
        for level in LEVELS:
            found = fastest_at(table.points, level)
            first = next(iter(found), None)
            cells: dict[str, Any] = {}
            for name, (point, measured) in found.items():
                seconds, note = measured.solve_seconds, settings_words(point.changing)
                cells[f"{name} solve_seconds"] = Cell(seconds, duration(seconds), note, "good" if name == first else "")
            builder.add(case=table.case, level=level, **cells)
    return builder.table()


def orders(tables: Sequence[Benchmark]) -> Table:
    """Order of each method's error of the tip deflection in its degrees of freedom."""
    builder = TableBuilder(
        "orders",
        "Observed order: slope of the error of the tip deflection over the number of degrees of freedom in logarithmic axes, by least"
        " squares over the ladder. Where integration or time step limit the finest settings the slope is less than the method's own.",
        (Column("method", "method"), *(Column(table.case, case_label(table.case), "1", ".1f") for table in tables)),
    )
    for name in methods_of(tables):
        builder.add(method=name, **{table.case: observed_order(table.points, name) for table in tables})
    return builder.table()


def joints(table: Benchmark) -> Table:
    """What each method's joint lets through at its finest settings."""
    builder = TableBuilder(
        "joints",
        f"What the slider's joint lets through in {case_label(table.case)}, finest completed settings of each method: largest distance of"
        " the slider from the centre line, and the work that a joint whose force and motion are not conjugate moves, regardless of sign,"
        " relative to the drive's.",
        (
            Column("method", "method"),
            Column("settings", "settings"),
            Column("largest_gap", "largest gap", "m", ".1e"),
            Column("spurious_share", "spurious work", "1", ".2g", "%", 100.0),
        ),
    )
    for name in methods_of([table]):
        done = [found for found in completed(table.points) if found[0].method == name]
        if done and {"largest_gap", "spurious_share"} & set(done[-1][1].statistics):
            statistics = done[-1][1].statistics
            builder.add(statistics, method=name, settings=settings_words(done[-1][0].changing))
    return builder.table()


def front(table: Benchmark) -> Table:
    """The Pareto front of one scene."""
    builder = TableBuilder(
        f"front-{table.case}",
        f"Pareto front of {case_label(table.case)}: settings that no others beat in both solve time and error of the tip deflection.",
        _point_columns(),
    )
    for point in pareto_front(table.points):
        builder.add(point.measured, **_point_cells(point))
    return builder.table()


def failures(tables: Sequence[Benchmark]) -> Table:
    """Points that failed, and from where on finer settings were not tried."""
    builder = TableBuilder(
        "not_completed",
        "Settings that did not complete.",
        (SCENE, Column("method", "method"), Column("settings", "settings"), Column("status", "what happened")),
    )
    for table in tables:
        told: set[str] = set()
        for point in table.points:
            untried = point.status.startswith(NOT_TRIED)
            if point.measured is not None or (untried and point.method in told):
                continue
            if untried:
                told.add(point.method)
            words = settings_words(point.changing) + (" and finer" if untried else "")
            builder.add(point, case=table.case, settings=words)
    return builder.table()


def points(tables: Sequence[Benchmark]) -> Table:
    """Every point of every scene."""
    builder = TableBuilder(
        "benchmark",
        "Every method, all settings, all scenes",
        (SCENE, *_point_columns(), Column("status", "status")),
        in_page=False,
    )
    for table in tables:
        for point in table.points:
            builder.add(point.measured, case=table.case, status=point.status, **_point_cells(point))
    return builder.table()


def _point_columns() -> tuple[Column, ...]:
    return (
        Column("method", "method"),
        Column("settings", "settings"),
        Column("degrees_of_freedom", "dof", form="d"),
        *(Column(key, head, "1", ".2g", "%", 100.0, group="error") for key, head in _ERRORS),
        Column("solve_seconds", "least", "s", ".3g", "ms", 1e3, group="solve time"),
        Column("solve_seconds_median", "median", "s", ".3g", "ms", 1e3, group="solve time"),
        Column("solve_seconds_largest", "largest", "s", ".3g", "ms", 1e3, group="solve time"),
        Column("repetitions", "of", form="d", group="solve time"),
        Column("setup_seconds", "setup", "s", ".2g", "ms", 1e3),
    )


def _point_cells(point: Point) -> dict[str, Any]:
    return {"method": point.method, "settings": settings_words(point.changing)} | {key: point.error(key) for key, _ in _ERRORS}


def reference_cost(table: Benchmark) -> Table:
    """Where the reference's time goes."""
    builder = TableBuilder(
        "reference_cost",
        f"Cost of the reference in {case_label(table.case)}: solve time with observables; of it the integration alone; right-hand sides,"
        " what one takes, and how many there are in a period of the highest mode kept (an explicit step of twelve must not be much longer"
        " than that period). Setup is the preparation of the tables.",
        (
            Column("modes", "modes", form="d"),
            Column("tolerance", "tolerance", "1", ".0e"),
            *(Column(key, head, "1", ".2g", "%", 100.0, group="error") for key, head in _ERRORS),
            Column("solve_seconds", "solve", "s", ".3g", "ms", 1e3),
            Column("integration_seconds", "integration", "s", ".3g", "ms", 1e3),
            Column("calls", "right-hand sides", form=".0f"),
            Column("seconds_per_call", "each", "s", ".2f", "µs", 1e6),
            Column("calls_per_period", "per period", "1", ".1f"),
            Column("setup_seconds", "setup", "s", ".2g", "ms", 1e3),
        ),
    )
    for point, measured in completed(table.points):
        if point.engine == "reference":
            statistics = measured.statistics
            calls, seconds = statistics["right_hand_side_calls"], statistics.get("integration_seconds", math.nan)
            builder.add(
                measured,
                modes=point.settings["modes"],
                tolerance=point.settings["tolerance"],
                **{key: point.error(key) for key, _ in _ERRORS},
                integration_seconds=seconds,
                calls=calls,
                seconds_per_call=seconds / calls,
            )
    return builder.table()


def scenes(tables: Sequence[Benchmark]) -> Table:
    """The scenes, and how the solution that errors are measured against is confirmed."""
    builder = TableBuilder(
        "benchmark_scenes",
        "Scenes; RMS of the tip deflection; and by how much the solution that errors are measured against differs from the one of an"
        " engine that shares neither coordinates nor joint nor integrator with it.",
        (
            SCENE,
            Column("title", "what it is"),
            Column("duration", "duration", "s", "g"),
            Column("size", "RMS", "m", ".3g", "mm", 1e3),
            Column("truth", "measured against"),
            Column("confirming", "confirmed by"),
            *(Column(key, head, "1", ".2g", "%", 100.0, group="difference") for key, head in _ERRORS),
        ),
    )
    for table in tables:
        truth, other = table.truth, table.confirmation
        builder.add(
            table,
            size=truth.sizes["tip_deflection"],
            truth=f"{truth.engine} ({settings_words(truth.settings)})",
            confirming=f"{other.engine}: {other.failure}" if other.failure else f"{other.engine} ({settings_words(other.settings)})",
            **{key: error_of(other.differences, key) for key, _ in _ERRORS},
        )
    return builder.table()
