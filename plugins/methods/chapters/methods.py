"""Which method excels: the fastest method to each error in each scene, with what one waits for besides."""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from typing import Final

from quickreturn.plugins.methods.benchmark import SCENES, Benchmark, Compiling
from quickreturn.plugins.methods.chapters import methods_tables as tables
from quickreturn.plugins.methods.data import benchmarks_of, compiling_of
from quickreturn.plugins.methods.fastest import Fastest, fastest_in, is_own
from quickreturn.plugins.methods.trials.queries import LEVELS, fastest_at, pareto_front, soonest_at
from quickreturn.plugins.methods.trials.trial import Trial
from quickreturn.plugins.methods.trials.truth import CONFIRMED, confirms
from quickreturn.reports.page.chapter import Chapter
from quickreturn.reports.page.content import Content
from quickreturn.reports.page.plot import Plot, Series
from quickreturn.reports.words import case_label, duration, percent, size

#: Labels of the horizontal axes of errors.
SOLVE_TIME: Final = "solve time [s]"
FREEDOM: Final = "degrees of freedom"
WAIT: Final = "set-up, solution and error estimate [s]"


def methods(content: Content) -> Chapter | None:
    """The chapter; None if no benchmark was measured."""
    (benchmarks, record), compiling = content.of(benchmarks_of), content.of(compiling_of)
    if not benchmarks:
        return None
    contests = [(benchmark, level) for benchmark in benchmarks for level in LEVELS]
    first, example = benchmarks[0], fastest_in(benchmarks[0], LEVELS[1])
    firsts = _wins(list(fastest_at(benchmark.trials, level)) for benchmark, level in contests)
    soonest = _wins([name for name, _ in soonest_at(benchmark.trials, level)] for benchmark, level in contests)
    winner = next(iter(firsts), "")
    own = any(is_own(trial.engine) for trial in first.trials if trial.method == winner)
    waiting = fastest_at(first.trials, LEVELS[1]).get(winner)
    compiled = next((each for each in compiling if each.engine == winner), None)
    facts = {
        "of_record": record,
        "first": first,
        "own": own,
        "missing": [name for name in SCENES if name not in {benchmark.case for benchmark in benchmarks}],
        "confirmed": CONFIRMED,
        "fastest": tables.fastest(benchmarks),
        "waits": tables.waiting(benchmarks),
        "compiled": tables.compiling(compiling),
        "plots": [
            (each, over := _over_time(each), _errors_over(each, FREEDOM), mark_words(len(over) > 1), confirms(each.confirmation))
            for each in benchmarks
        ],
        "fronts": [tables.front(benchmark) for benchmark in benchmarks],
        "tables": [
            tables.orders(benchmarks),
            tables.reference_cost(first),
            tables.joints(first),
            tables.scenes(benchmarks),
            tables.failures(benchmarks),
        ],
        "trials": tables.trials(benchmarks),
        "machine": ", ".join(f"{name}: {words}" for name, words in first.machine.items()),
    }
    text = finding(len(contests), firsts, soonest, own, example, waiting_words(waiting, compiled) if waiting else "")
    return Chapter("methods", "Which method excels", text, facts)


def finding(contests: int, firsts: Mapping[str, int], soonest: Mapping[str, int], own: bool, example: Fastest, waiting: str) -> str:
    """The method that wins most contests, and how fast it is in one of them.

    Args:
        contests: their number.
        firsts: method -> number of contests that it wins by solve time, the most frequent winner first.
        soonest: the same by waiting time; empty if that was not measured.
        own: whether the most frequent winner is code of this project.
        example: the fastest methods in one contest.
        waiting: what the most frequent winner takes besides in that contest; "" if it does not reach the error.
    """
    if not firsts:
        text = f"No method wins any of {contests} contests"
    else:
        winner, count = next(iter(firsts.items()))
        code = ", this project’s own code compiled for this one mechanism," if own else ""
        by_waiting = f" (by waiting time, {soonest.get(winner, 0)})" if soonest else ""
        unwon = contests - sum(firsts.values())
        nobody = f"; {unwon} nobody wins" if unwon else ""
        text = f"{winner}{code} solves fastest in {count} of {contests} contests{by_waiting}{nobody}"
    if not example.solve_times:
        return text
    (name, seconds), *others = example.solve_times
    text += f"; to {percent(example.level, 'g')} in {case_label(example.case)} {name} solves in {duration(seconds)}"
    text += f" ({others[0][0]} in {duration(others[0][1])})" if others else ""
    return f"{text} and takes {waiting} besides" if waiting else text


def waiting_words(trial: Trial, compiled: Compiling | None) -> str:
    """What a method takes besides its solution: "10 ms for set-up and once 40 s for compilation"."""
    text = f"{duration(trial.setup_seconds or 0.0)} for set-up"
    estimate = trial.estimate_seconds
    text += "" if estimate is None else f", {duration(estimate)} for the estimate of its error"
    if compiled is None:
        return text
    return f"{text}{',' if estimate is None else ''} and once {duration(compiled.compile_seconds)} for compilation"


def mark_words(waited: bool) -> str:
    """What the marks of a plot over time are; `waited`: whether it can also be over waiting time."""
    measured = "Waiting time was measured for each method’s fastest settings to each error. " if waited else ""
    return (
        f"{measured}Hollow marks are variants of a method; in the shaded range errors are less than the difference between the two"
        " reference solutions. A click or a touch on a mark shows its settings."
    )


def _wins(orders: Iterable[Sequence[str]]) -> dict[str, int]:
    """Method -> number of contests that it wins, the most frequent winner first; each of `orders` ranks the methods of a contest."""
    counts = Counter(order[0] for order in orders if order)
    return dict(counts.most_common())


def _at(trial: Trial, across: str) -> float | None:
    if across == SOLVE_TIME:
        return trial.solve_seconds
    return trial.waited_seconds if across == WAIT else float(trial.degrees_of_freedom or 0)


def _series(benchmark: Benchmark, across: str) -> list[Series]:
    """The Pareto front of the solve times as a broad band, and the points of each method."""
    series = []
    if across == SOLVE_TIME:
        front = [(trial.seconds, 100.0 * error) for trial in pareto_front(benchmark.trials) if (error := trial.error)]
        series.append(Series("Pareto front", "", [x for x, _ in front], [y for _, y in front], broad=True))
    for name in tables.methods_of([benchmark]):
        trials = [trial for trial in benchmark.trials if trial.method == name]
        places = [(x, error, trial) for trial in trials if (x := _at(trial, across)) is not None and (error := trial.error)]
        if places:
            texts = [f"{tables.changed_words(benchmark, trial)}; {_time(trial, across)}, error {size(error)}" for _, error, trial in places]
            of = places[0][2].engine
            xs, ys = [x for x, *_ in places], [100.0 * error for _, error, _ in places]
            series.append(Series(name, of, xs, ys, texts, hollow=name != of))
    return series


def _time(trial: Trial, across: str) -> str:
    solving = duration(trial.seconds)
    return solving if across != WAIT else f"{duration(trial.waited_seconds or 0.0)}, of it solving {solving}"


def _errors_over(benchmark: Benchmark, across: str) -> Plot:
    below = benchmark.confirmation.error
    shaded = None if below is None else 100.0 * below
    return Plot("benchmark.csv", across, "error of the tip deflection [%]", _series(benchmark, across), "xy", shaded)


def _over_time(benchmark: Benchmark) -> dict[str, Plot]:
    """Plots of the errors over solve time, and over waiting time if it was measured, by the name of the choice."""
    waited = _errors_over(benchmark, WAIT)
    return {"solve time": _errors_over(benchmark, SOLVE_TIME)} | ({"waiting time": waited} if waited.series else {})
