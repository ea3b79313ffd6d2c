"""The thesis' open question, which of the methods excel; and the scenes in which engines break."""

from collections import Counter
from typing import Any, Final

from cases.benchmark import SCENES, Benchmark, fastest_at, observed_order, pareto_front
from cases.benchmark.findings import LEVELS, completed
from cases.benchmark.measurement import CONFIRMED
from cases.judging.conditioning import CHANGE, ILL
from cases.judging.matrix import MODEL, REQUESTED
from cases.judging.verdicts import LATER, MEANINGS
from cases.library.hard import IMPOSSIBLE
from reports.page.answer import contest
from reports.page.content import Content
from reports.page.plot import Plot, Series
from reports.tables import benchmark as tables
from reports.tables import hard_scenes as hard_tables
from reports.words import duration, settings_words, size

#: What errors are drawn over.
SOLVE_TIME: Final = "solve time [s]"
FREEDOM: Final = "degrees of freedom"


def methods(content: Content) -> dict[str, Any] | None:
    """None where nothing was measured and the thesis' question is not asked."""
    found = list(content.benchmarks)
    if not found:
        return None
    names = tables.methods_of(found)
    fastest = [list(fastest_at(table.points, level)) for table in found for level in LEVELS]
    firsts = [order[0] for order in fastest if order]
    first = found[0]
    orders = {name: observed_order(first.points, name) for name in names}
    return {
        "of_record": content.of_record.get("benchmark"),
        "first": first,
        "firsts": {name: firsts.count(name) for name in sorted(set(firsts), key=firsts.count, reverse=True)},
        "contests": len(firsts),
        "levels": [contest(first, level) for level in LEVELS],
        "missing": [name for name in SCENES if name not in {table.case for table in found}],
        "orders": {name: order for name, order in orders.items() if order is not None},
        "stuck": _stuck(first),
        "confirmed": CONFIRMED,
        "fastest": tables.fastest(found),
        "plots": [(table, _errors_over(table, SOLVE_TIME), _errors_over(table, FREEDOM)) for table in found],
        "fronts": [tables.front(table) for table in found],
        "tables": [tables.orders(found), tables.reference_cost(first), tables.joints(first), tables.scenes(found), tables.failures(found)],
        "points": tables.points(found),
    }


def _stuck(table: Benchmark) -> dict[str, float]:
    """Methods whose error stays above a half over all their settings, with the least."""
    errors: dict[str, list[float]] = {}
    for point in table.points:
        if (error := point.error()) is not None:
            errors.setdefault(point.method, []).append(error)
    return {name: min(found) for name, found in errors.items() if min(found) > 0.5}


def _series(table: Benchmark, across: str) -> list[Series]:
    """The Pareto front as a broad band, and the points of each method."""

    def at(point: Any, measured: Any) -> float:
        return measured.solve_seconds if across == SOLVE_TIME else measured.degrees_of_freedom

    front = [(at(point, point.measured), 100.0 * error) for point in pareto_front(table.points) if (error := point.error())]
    found = []
    if across == SOLVE_TIME:
        found.append(Series("Pareto front", "", [x for x, _ in front], [y for _, y in front], broad=True))
    for name in tables.methods_of([table]):
        done = [(p, m, error) for p, m in completed(table.points) if p.method == name and (error := p.error())]
        if done:
            texts = [f"{settings_words(p.changing)}; {duration(m.solve_seconds)}, error {size(error)}" for p, m, error in done]
            engine = done[0][0].engine
            xs, ys = [at(p, m) for p, m, _ in done], [100.0 * error for *_, error in done]
            found.append(Series(name, engine, xs, ys, texts, hollow=name != engine))
    return found


def _errors_over(table: Benchmark, across: str) -> Plot:
    below = table.confirmation.differences.get("tip_deflection")
    shaded = None if below is None else 100.0 * below
    return Plot("benchmark.csv", across, "error of the tip deflection [%]", _series(table, across), "xy", shaded)


def hard_scenes(content: Content) -> dict[str, Any] | None:
    """The matrix of verdicts; None where none is stored."""
    matrix = content.hard_scenes
    if matrix is None:
        return None
    return {
        "matrix": matrix,
        "of_record": content.of_record.get("hard scenes"),
        "kinds": Counter(cell.verdict.kind for cell in matrix.cells.values()),
        "requested": REQUESTED,
        "checked": sum(cell.holds is not None for cell in matrix.cells.values()),
        "missing": len(matrix.cases) * len(matrix.engines) - len(matrix.cells),
        "meanings": MEANINGS,
        "model": MODEL,
        "impossible": list(IMPOSSIBLE.values()),
        "change": CHANGE,
        "ill": ILL,
        "later": LATER,
        "verdicts": hard_tables.verdicts(matrix),
        "conditioning": hard_tables.conditioning(matrix),
        "cells": hard_tables.cells(matrix),
    }
