"""The thesis' open question, which of the methods excel; and the scenes in which engines break."""

from typing import Any, Final

from cases.benchmark import SCENES, Benchmark, fastest_at, observed_order, pareto_front
from cases.benchmark.findings import LEVELS, completed
from cases.benchmark.measurement import CONFIRMED
from cases.case_file import load_case
from cases.jobs.workshop import Workshop
from cases.judging.conditioning import CHANGE, ILL
from cases.judging.matrix import MODEL, REQUESTED, Matrix, judge_scenes
from cases.judging.verdicts import LATER, MEANINGS
from cases.library import catalogue
from cases.library.hard import IMPOSSIBLE, TAG
from reports.page.content import Content
from reports.page.plot import Plot, Series
from reports.tables import benchmark as tables
from reports.tables import hard_scenes as hard_tables
from reports.words import duration, settings_words, size

#: Engines that are packages of others, in this project's adapters.
PACKAGES: Final = ("exudyn", "mujoco")


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
        "benchmarks": found,
        "of_record": content.of_record.get("benchmark"),
        "first": first,
        "firsts": {name: firsts.count(name) for name in sorted(set(firsts), key=firsts.count, reverse=True)},
        "contests": len(firsts),
        "levels": [_level(first, level) for level in LEVELS],
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


def _level(table: Benchmark, level: float) -> dict[str, Any]:
    """The fastest method, the next that is of another engine, and the packages, with their solve times."""
    found = [(name, point.engine, measured.solve_seconds) for name, (point, measured) in fastest_at(table.points, level).items()]
    others = [each for each in found[1:] if each[1] != found[0][1]]
    told = found[:1] + others[:1] + [each for each in others[1:] if each[0] in PACKAGES]
    return {"level": level, "found": [(name, seconds) for name, _, seconds in told]}


def _stuck(table: Benchmark) -> dict[str, float]:
    """Methods whose error stays above a half over all their settings, with the least."""
    words = {}
    for name in tables.methods_of([table]):
        errors = [error for point in table.points if point.method == name and (error := point.error()) is not None]
        if errors and min(errors) > 0.5:
            words[name] = min(errors)
    return words


def _series(table: Benchmark, across: str) -> list[Series]:
    """The Pareto front as a broad band, and the points of each method."""

    def at(point: Any, measured: Any) -> float:
        return measured.solve_seconds if across == SOLVE_TIME else measured.degrees_of_freedom

    front = [(at(point, point.measured), point.error()) for point in pareto_front(table.points) if point.error()]
    found = []
    if across == SOLVE_TIME:
        found.append(Series("Pareto front", "", [x for x, _ in front], [y for _, y in front if y], broad=True))
    for name in tables.methods_of([table]):
        done = [(p, m, error) for p, m in completed(table.points) if p.method == name and (error := p.error())]
        if done:
            texts = [f"{settings_words(p.changing)}; {duration(m.solve_seconds)}, error {size(error)}" for p, m, error in done]
            engine = done[0][0].engine
            xs, ys = [at(p, m) for p, m, _ in done], [error for *_, error in done]
            found.append(Series(name, engine, xs, ys, texts, hollow=name != engine))
    return found


def _errors_over(table: Benchmark, across: str) -> Plot:
    below = table.confirmation.differences.get("tip_deflection")
    return Plot("benchmark.csv", across, "error of the tip deflection", _series(table, across), "xy", below)


def stored_matrix(workshop: Workshop) -> Matrix | None:
    """What `make verify` left of the matrix, without computing anything; None where there is nothing."""
    matrix = judge_scenes([load_case(entry.name) for entry in catalogue(TAG)], workshop, compute=False)
    return matrix if matrix.cells else None


def hard_scenes(content: Content) -> dict[str, Any] | None:
    """The matrix of verdicts; None where none is stored."""
    matrix = content.hard_scenes
    if matrix is None:
        return None
    kinds: dict[str, int] = {}
    for cell in matrix.cells.values():
        kinds[cell.verdict.kind] = kinds.get(cell.verdict.kind, 0) + 1
    return {
        "matrix": matrix,
        "of_record": content.of_record.get("hard scenes"),
        "kinds": kinds,
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
