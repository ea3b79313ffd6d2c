"""Facts of the chapters on the methods that excel, the thesis' open question, and on the hard scenes."""

from collections import Counter
from collections.abc import Iterable, Sequence
from typing import Any, Final

from quickreturn.cases.benchmark import SCENES, Benchmark, fastest_at, observed_order, pareto_front
from quickreturn.cases.benchmark.findings import LEVELS, Measured, completed, soonest_at
from quickreturn.cases.benchmark.truth import CONFIRMED
from quickreturn.cases.judging.conditioning import CHANGE, ILL
from quickreturn.cases.judging.matrix import REQUESTED
from quickreturn.cases.judging.verdicts import LATER, MEANINGS, OWN_EQUATIONS
from quickreturn.cases.library.hard import IMPOSSIBLE
from quickreturn.engines.registry import MODEL, engine
from quickreturn.reports.page.answer import contest, is_own
from quickreturn.reports.page.content import Content
from quickreturn.reports.page.plot import Plot, Series
from quickreturn.reports.tables import benchmark as tables
from quickreturn.reports.tables import hard_scenes as hard_tables
from quickreturn.reports.words import duration, settings_words, size

#: Labels of the horizontal axes of errors.
SOLVE_TIME: Final = "solve time [s]"
FREEDOM: Final = "degrees of freedom"
WAIT: Final = "set-up, solution and error estimate [s]"


def methods(content: Content) -> dict[str, Any] | None:
    """The facts for `chapters/methods.html`; None if no benchmark was measured."""
    benchmarks = list(content.benchmarks)
    if not benchmarks:
        return None
    names = tables.methods_of(benchmarks)
    contests = [(benchmark, level) for benchmark in benchmarks for level in LEVELS]
    first = benchmarks[0]
    firsts = _won(list(fastest_at(benchmark.points, level)) for benchmark, level in contests)
    soonest = _won([name for name, _ in soonest_at(benchmark.points, level)] for benchmark, level in contests)
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
        "waiting": fastest_at(first.points, LEVELS[1]).get(winner, (None, None))[1],
        "compiling": next((each for each in content.compiling if each.engine == winner), None),
        "levels": [contest(first, level) for level in LEVELS],
        "missing": [name for name in SCENES if name not in {benchmark.case for benchmark in benchmarks}],
        "orders": {name: order for name, order in orders.items() if order is not None},
        "models": _models(benchmarks),
        "confirmed": CONFIRMED,
        "fastest": tables.fastest(benchmarks),
        "waits": tables.waiting(benchmarks),
        "compiled": tables.compiling(content.compiling),
        "plots": [(benchmark, _over_time(benchmark), _errors_over(benchmark, FREEDOM)) for benchmark in benchmarks],
        "fronts": [tables.front(benchmark) for benchmark in benchmarks],
        "tables": [
            tables.orders(benchmarks),
            tables.reference_cost(first),
            tables.joints(first),
            tables.scenes(benchmarks),
            tables.failures(benchmarks),
        ],
        "points": tables.points(benchmarks),
    }


def _won(orders: Iterable[Sequence[str]]) -> dict[str, int]:
    """Method -> number of contests that it wins, the most frequent winner first; each of `orders` ranks the methods of a contest."""
    counts = Counter(order[0] for order in orders if order)
    return dict(counts.most_common())


def _models(benchmarks: Sequence[Benchmark]) -> dict[str, dict[str, float]]:
    """Methods that solve equations of their own -> scene -> the least error of their settings, which is that of the model."""
    errors: dict[str, dict[str, float]] = {}
    for benchmark in benchmarks:
        for point in benchmark.points:
            if engine(point.engine).estimates == "integration" and (error := point.error()) is not None:
                of_method = errors.setdefault(point.method, {})
                of_method[benchmark.case] = min(error, of_method.get(benchmark.case, error))
    return errors


def _at(measured: Measured, across: str) -> float | None:
    if across == SOLVE_TIME:
        return measured.solve_seconds
    return measured.waited_seconds if across == WAIT else float(measured.degrees_of_freedom)


def _series(benchmark: Benchmark, across: str) -> list[Series]:
    """The Pareto front of the solve times as a broad band, and the points of each method."""
    series = []
    if across == SOLVE_TIME:
        front = [(m.solve_seconds, 100.0 * error) for point, m in completed(pareto_front(benchmark.points)) if (error := point.error())]
        series.append(Series("Pareto front", "", [x for x, _ in front], [y for _, y in front], broad=True))
    for name in tables.methods_of([benchmark]):
        completed_points = [(point, m) for point, m in completed(benchmark.points) if point.method == name and point.error()]
        places = [(x, error, point, m) for point, m in completed_points if (x := _at(m, across)) is not None and (error := point.error())]
        if places:
            texts = [f"{settings_words(point.changing)}; {_time(m, across)}, error {size(error)}" for _, error, point, m in places]
            engine = places[0][2].engine
            xs, ys = [x for x, *_ in places], [100.0 * error for _, error, *_ in places]
            series.append(Series(name, engine, xs, ys, texts, hollow=name != engine))
    return series


def _time(measured: Measured, across: str) -> str:
    solving = duration(measured.solve_seconds)
    return solving if across != WAIT else f"{duration(measured.waited_seconds or 0.0)}, of it solving {solving}"


def _errors_over(benchmark: Benchmark, across: str) -> Plot:
    below = benchmark.confirmation.differences.get("tip_deflection")
    shaded = None if below is None else 100.0 * below
    return Plot("benchmark.csv", across, "error of the tip deflection [%]", _series(benchmark, across), "xy", shaded)


def _over_time(benchmark: Benchmark) -> dict[str, Plot]:
    """Plots of the errors over solve time, and over waiting time if it was measured, by the name of the choice."""
    waited = _errors_over(benchmark, WAIT)
    return {"solve time": _errors_over(benchmark, SOLVE_TIME)} | ({"waiting time": waited} if waited.series else {})


def hard_scenes(content: Content) -> dict[str, Any] | None:
    """The facts for `chapters/hard.html`; None if no matrix of verdicts is stored."""
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
        "off": [cell.model_error for cell in matrix.cells.values() if cell.kind == OWN_EQUATIONS and cell.model_error is not None],
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
