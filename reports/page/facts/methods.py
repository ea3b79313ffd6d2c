"""The thesis' open question, which of the methods excel; and the scenes in which engines break."""

from collections import Counter
from collections.abc import Iterable, Sequence
from typing import Any, Final

from quickreturn.cases.benchmark import SCENES, Benchmark, fastest_at, observed_order, pareto_front
from quickreturn.cases.benchmark.findings import LEVELS, Measured, completed, soonest_at
from quickreturn.cases.benchmark.truth import CONFIRMED
from quickreturn.cases.judging.conditioning import CHANGE, ILL
from quickreturn.cases.judging.matrix import REQUESTED, Matrix
from quickreturn.cases.judging.verdicts import LATER, MEANINGS, OWN_EQUATIONS
from quickreturn.cases.library.hard import IMPOSSIBLE
from quickreturn.engines.registry import MODEL
from quickreturn.reports.page.answer import contest, is_own
from quickreturn.reports.page.content import Content
from quickreturn.reports.page.plot import Plot, Series
from quickreturn.reports.tables import benchmark as tables
from quickreturn.reports.tables import hard_scenes as hard_tables
from quickreturn.reports.words import duration, settings_words, size

#: What errors are drawn over.
SOLVE_TIME: Final = "solve time [s]"
FREEDOM: Final = "degrees of freedom"
WAIT: Final = "setting up, solving and estimating the error [s]"


def methods(content: Content) -> dict[str, Any] | None:
    """None where nothing was measured and the thesis' question is not asked."""
    found = list(content.benchmarks)
    if not found:
        return None
    names = tables.methods_of(found)
    contests = [(table, level) for table in found for level in LEVELS]
    first = found[0]
    firsts = _won(list(fastest_at(table.points, level)) for table, level in contests)
    soonest = _won([name for name, _ in soonest_at(table.points, level)] for table, level in contests)
    winner = next(iter(firsts), "")
    orders = {name: observed_order(first.points, name) for name in names}
    return {
        "of_record": content.of_record.get("benchmark"),
        "first": first,
        "firsts": firsts,
        "contests": len(contests),
        "unwon": len(contests) - sum(firsts.values()),
        "soonest": soonest,
        "own": any(is_own(point.engine) for point in first.points if point.method == winner),
        "waiting": _waiting(first, LEVELS[1], winner),
        "compiling": next((each for each in content.compiling if each.engine == winner), None),
        "levels": [contest(first, level) for level in LEVELS],
        "missing": [name for name in SCENES if name not in {table.case for table in found}],
        "orders": {name: order for name, order in orders.items() if order is not None},
        "stuck": _stuck(first),
        "confirmed": CONFIRMED,
        "fastest": tables.fastest(found),
        "waits": tables.waiting(found),
        "compiled": tables.compiling(content.compiling),
        "plots": [(table, _over_time(table), _errors_over(table, FREEDOM)) for table in found],
        "fronts": [tables.front(table) for table in found],
        "tables": [tables.orders(found), tables.reference_cost(first), tables.joints(first), tables.scenes(found), tables.failures(found)],
        "points": tables.points(found),
    }


def _won(orders: Iterable[Sequence[str]]) -> dict[str, int]:
    """Who is first in how many contests, who is in most of them first; each order is of the names in one contest."""
    counts = Counter(order[0] for order in orders if order)
    return dict(counts.most_common())


def _waiting(table: Benchmark, level: float, method: str) -> Measured | None:
    """What was measured of a method's fastest settings to an error."""
    found = fastest_at(table.points, level).get(method)
    return found[1] if found else None


def _stuck(table: Benchmark) -> dict[str, float]:
    """Methods whose error stays above a half over all their settings, with the least."""
    errors: dict[str, list[float]] = {}
    for point in table.points:
        if (error := point.error()) is not None:
            errors.setdefault(point.method, []).append(error)
    return {name: min(found) for name, found in errors.items() if min(found) > 0.5}


def _at(measured: Measured, across: str) -> float | None:
    if across == SOLVE_TIME:
        return measured.solve_seconds
    return measured.waited_seconds if across == WAIT else float(measured.degrees_of_freedom)


def _series(table: Benchmark, across: str) -> list[Series]:
    """The Pareto front of the solve times as a broad band, and the points of each method."""
    found = []
    if across == SOLVE_TIME:
        front = [(m.solve_seconds, 100.0 * error) for point, m in completed(pareto_front(table.points)) if (error := point.error())]
        found.append(Series("Pareto front", "", [x for x, _ in front], [y for _, y in front], broad=True))
    for name in tables.methods_of([table]):
        done = [(point, m) for point, m in completed(table.points) if point.method == name and point.error()]
        places = [(x, error, point, m) for point, m in done if (x := _at(m, across)) is not None and (error := point.error())]
        if places:
            texts = [f"{settings_words(point.changing)}; {_time(m, across)}, error {size(error)}" for _, error, point, m in places]
            engine = places[0][2].engine
            xs, ys = [x for x, *_ in places], [100.0 * error for _, error, *_ in places]
            found.append(Series(name, engine, xs, ys, texts, hollow=name != engine))
    return found


def _time(measured: Measured, across: str) -> str:
    solving = duration(measured.solve_seconds)
    return solving if across != WAIT else f"{duration(measured.waited_seconds or 0.0)}, of it solving {solving}"


def _errors_over(table: Benchmark, across: str) -> Plot:
    below = table.confirmation.differences.get("tip_deflection")
    shaded = None if below is None else 100.0 * below
    return Plot("benchmark.csv", across, "error of the tip deflection [%]", _series(table, across), "xy", shaded)


def _over_time(table: Benchmark) -> dict[str, Plot]:
    """The errors over solve time, and over what one waits for where that was measured, by what the reader chooses between."""
    waited = _errors_over(table, WAIT)
    return {"solving alone": _errors_over(table, SOLVE_TIME)} | ({"all that one waits for": waited} if waited.series else {})


def hard_scenes(content: Content) -> dict[str, Any] | None:
    """The matrix of verdicts; None where none is stored."""
    matrix = content.hard_scenes
    if matrix is None:
        return None
    kinds = Counter(cell.kind for cell in matrix.cells.values())
    checked = [cell for cell in matrix.cells.values() if cell.holds is not None]
    return {
        "matrix": matrix,
        "of_record": content.of_record.get("hard scenes"),
        "kinds": {kind: kinds[kind] for kind in MEANINGS if kinds[kind]},
        "own_equations": OWN_EQUATIONS,
        "off": _model_errors(matrix),
        "requested": REQUESTED,
        "checked": len(checked),
        "checked_own": sum(cell.of_own_equations for cell in checked),
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


def _model_errors(matrix: Matrix) -> list[float]:
    """How far the models are off whose cells solve their own equations alone, where that is known."""
    return [cell.model_error for cell in matrix.cells.values() if cell.kind == OWN_EQUATIONS and cell.model_error is not None]
