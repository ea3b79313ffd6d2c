"""Which method excels: what each method needs for an error in each scene, in seconds and right-hand sides, and which factor buys what."""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, Final

from quickreturn.engines.registry import own_engines
from quickreturn.plugins.methods.compiling import Compiling
from quickreturn.plugins.methods.entrants import entrant, pairs
from quickreturn.plugins.methods.fronts import CRITERIA, DEFLECTION, WORST, Standing, front, standings
from quickreturn.plugins.methods.race import LONG, PATIENCE, REPETITIONS, Race
from quickreturn.plugins.methods.row import LEVELS, REACHED, Row
from quickreturn.plugins.methods.studies import CHOSEN, SCENES, Fronts, compiling_of, fronts_of
from quickreturn.plugins.methods.truth import CONFIRMED
from quickreturn.reports.page.chapter import Chapter, Plot, Series
from quickreturn.reports.page.content import Content
from quickreturn.reports.tables import CASE, Cell, Column, Table
from quickreturn.reports.words import case_label, duration, number, percent, settings_words, size, times

#: Engines that are packages of other authors, in this project's adapters.
PACKAGES: Final = ("exudyn", "mujoco")
_SCENE: Final = (replace(CASE, head="scene"), Column("level", "error", "%", "g"))


def is_own(engine: str) -> bool:
    """Whether an engine is code of this project, written for the one mechanism."""
    return engine in own_engines() and engine not in PACKAGES


def methods(content: Content) -> Chapter | None:
    """The chapter; None if there was no race."""
    found: Fronts = content.of(fronts_of)
    if not found.races:
        return None
    first = found.races[0]
    facts = {
        "of_record": found.record,
        "runs": first.runs,
        "long": LONG,
        "repetitions": REPETITIONS,
        "patience": PATIENCE,
        "missing": [name for name in SCENES if name not in {each.case for each in found.races}],
        "confirmed": CONFIRMED,
        "fastest": [(by, fastest(found.races, by)) for by in CRITERIA],
        "factors": factors(found.races),
        "entrants": entrants(first),
        "chosen": chosen(found.races),
        "plots": [(each, {by: errors_over_time(each, by) for by in CRITERIA}, is_confirmed(each)) for each in found.races],
        "waiting": waiting(found.races),
        "compiled": compiled(content.of(compiling_of)),
        "scenes": scenes(found.races),
        "machine": ", ".join(f"{name}: {words}" for name, words in first.machine.items()),
        "rows": every_row(found.races),
    }
    return Chapter("methods", "Which method excels", finding(found.races), facts)


def is_confirmed(found: Race) -> bool:
    """Whether a second formulation agrees with the solution that defines errors."""
    return found.confirmation.error is not None and found.confirmation.error <= CONFIRMED


def finding(races: Sequence[Race]) -> str:
    """The method that is first in most contests, and how far the next engine's is behind it in the first scene."""
    ranked = [standings(found.given, level) for found in races for level in LEVELS]
    wins = Counter(next(iter(each.values())).row.engine for each in ranked if each)
    if not wins:
        return f"No method reaches any error in {len(races)} scenes"
    (winner, count), *_ = wins.most_common()
    own = ", this project’s own code compiled for this one mechanism," if is_own(winner) else ""
    unwon = len(ranked) - sum(wins.values())
    text = f"{winner}{own} solves fastest in {count} of {len(ranked)} contests{f'; {unwon} nobody wins' if unwon else ''}"
    leads = [(level, lead) for level in LEVELS if (lead := lead_of(standings(races[0].given, level), winner))]
    words = [f"{times(factor)} as long to {percent(level, 'g')} ({name})" for level, (name, factor) in leads]
    return f"{text}; in {case_label(races[0].case)} the next takes {', '.join(words)}" if words else text


def lead_of(ranked: Mapping[str, Standing], winner: str) -> tuple[str, float] | None:
    """The first method of another engine than the winner, and its time over that of the winner; None without one of them."""
    first = next((at.seconds for at in ranked.values() if at.row.engine == winner), None)
    other = next(((name, at.seconds) for name, at in ranked.items() if at.row.engine != winner), None)
    return (other[0], other[1] / first) if first and other else None


def fastest_figure(content: Content) -> tuple[str, str] | None:
    """The fastest method to the second of the levels in the first scene; None if none reaches it."""
    races = content.of(fronts_of).races
    ranked = standings(races[0].given, LEVELS[1], DEFLECTION) if races else {}
    if not ranked:
        return None
    name, at = next(iter(ranked.items()))
    lead = lead_of(ranked, at.row.engine)
    own = ", made for this mechanism" if is_own(at.row.engine) else ""
    other = f"; {lead[0]} takes {times(lead[1])} as long" if lead else ""
    return duration(
        at.seconds
    ), f"to solve {case_label(races[0].case)} to {percent(LEVELS[1], 'g')} of the tip deflection: {name}{own}{other}"


def _at_levels(races: Sequence[Race], by: str) -> Iterator[tuple[Race, float, dict[str, Standing]]]:
    for found in races:
        yield from ((found, level, standings(found.given, level, by)) for level in LEVELS)


def _words(at: Standing) -> str:
    """The first run below a level: its settings, right-hand sides and time."""
    row = at.row
    calls = f", {number(row.calls, '.4g')} right-hand sides" if row.calls else ""
    signed = f", signed by {row.signed}" if row.signed else ""
    return f"first run below: {settings_words(row.settings)}{calls}, {duration(row.seconds)}{signed}"


def fastest(races: Sequence[Race], by: str) -> Table:
    """Solve time of each method at each level, per scene."""
    names = list(dict.fromkeys(row.method for found in races for row in found.given))
    table = Table(
        f"fastest{'' if by == WORST else '_deflection'}",
        f"""Solve time of each method at an error, by {by}: interpolated on the method’s front in logarithms. The fastest is marked. –: no
        run reaches the error. A click on a time shows the first run below the error.""",
        (*_SCENE, *(Column(f"{name} solve_seconds", name, "[s]", ".2g") for name in names)),
    )
    for found, level, ranked in _at_levels(races, by):
        cells = {f"{name} solve_seconds": Cell(at.seconds, duration(at.seconds), _words(at)) for name, at in ranked.items()}
        if cells:
            first = next(iter(cells))
            cells[first] = replace(cells[first], mark="good")
        table.add(case=found.case, level=level, **cells)
    return table


def factors(races: Sequence[Race]) -> Table:
    """What one factor buys: two methods that differ in it alone."""
    columns = (
        *_SCENE,
        "factor",
        "method",
        "instead_of",
        Column("times", "time over", "1", ".2g"),
        Column("calls", "right-hand sides over", "1", ".2g"),
    )
    table = Table(
        "factors",
        """Which factor buys what: two methods that differ in shapes, constraint, integrator or implementation alone, by the worst of four
        columns; time and right-hand sides of the second over those of the first.""",
        columns,
    )
    for found, level, ranked in _at_levels(races, WORST):
        for factor, one, other in pairs([at.row for at in ranked.values()]):
            first, second = ranked[one], ranked[other]
            calls = second.calls / first.calls if first.calls and second.calls else None
            table.add(
                case=found.case, level=level, factor=factor, method=one, instead_of=other, times=second.seconds / first.seconds, calls=calls
            )
    return table


def entrants(found: Race) -> Table:
    """What each method is, and how many runs it had."""
    table = Table(
        "entrants",
        """What the methods are. Order: a tenth of the error takes the root of this order of ten times as many steps, √10 = 3.2 for order 2
        and 1.3 for order 8: where a package’s integrator is of order 2, it and not the beam costs it most at small errors.""",
        ("method", "shapes", "constraint", "integrator", Column("order", form="d"), "implementation", "note", Column("runs", form="d")),
    )
    for name in dict.fromkeys(row.method for row in found.given):
        rows = [row for row in found.given if row.method == name]
        table.add(entrant(rows[0]), method=name, runs=len(rows))
    return table


def chosen(races: Sequence[Race]) -> Table:
    """Settings that the search found in the first scene, in the others."""
    table = Table(
        "chosen",
        f"""Settings that were chosen in {case_label(races[0].case)}, tried in the other scenes: their error there, and their time over that
        of the method’s own front at that error. An error by a compensation does not carry over.""",
        (
            _SCENE[0],
            "method",
            "settings",
            Column("error", "worst of four", "%", ".2g"),
            Column("solve_seconds", "solve", "ms", ".3g"),
            Column("over", "over its front", "1", ".2g"),
        ),
    )
    for found in races[1:]:
        for row in found.given:
            if row.signed == CHOSEN.format(races[0].case):
                own = standings([each for each in found.given if each.method == row.method], row.worst or 0.0).get(row.method)
                over = row.seconds / own.seconds if own and row.completed else None
                error = row.worst if row.completed else Cell(None, row.status, mark="open")
                table.add(row, case=found.case, settings=settings_words(row.settings), error=error, over=over)
    return table


def errors_over_time(found: Race, by: str) -> Plot:
    """The front of each method, and the front of all as a broad band."""
    bands = [(row.seconds, 100.0 * error) for row in front(found.given, by) if (error := CRITERIA[by](row))]
    series = [Series("Pareto front", "", [x for x, _ in bands], [y for _, y in bands], broad=True)]
    for name in dict.fromkeys(row.method for row in found.given):
        rows = [(row, error) for row in front([each for each in found.given if each.method == name], by) if (error := CRITERIA[by](row))]
        if rows:
            texts = [f"{settings_words(row.settings)}; {duration(row.seconds)}, error {size(error)}{_signed(row)}" for row, error in rows]
            of = rows[0][0].engine
            series.append(
                Series(name, of, [row.seconds for row, _ in rows], [100.0 * error for _, error in rows], texts, hollow=name != of)
            )
    below = found.confirmation.error if by == DEFLECTION else found.confirmation.worst
    return Plot("benchmark.csv", "solve time [s]", f"error [%], {by}", series, "xy", None if below is None else 100.0 * below)


def _signed(row: Row) -> str:
    return f", signed by {row.signed}" if row.signed else ""


def waiting(races: Sequence[Race]) -> Table:
    """What each engine does when it is asked for an error."""
    seconds = (
        Column("answer_seconds", "answer", "[s]", ".2g", words=_span),
        Column("solve_seconds", "of it solving", "[s]", ".2g", words=_span),
    )
    table = Table(
        "waiting",
        """Engines that are asked for an error of the tip deflection, as a user asks: what came of it, the error of the answer, the engine’s
        own estimate, and the time for the answer: set-up, the search for settings, the solution, and the runs for the estimate. Compilation
        is not included.""",
        (
            *_SCENE,
            "engine",
            "status",
            Column("error", "delivered", "%", ".2g"),
            Column("claim", "claimed", "%", ".2g"),
            *seconds,
            "settings",
        ),
    )
    for found in races:
        for row in found.rows:
            if row.level is not None:
                table.add(
                    row,
                    case=found.case,
                    status=Cell(row.status, note=row.remark, mark="" if row.status == REACHED else "open"),
                    settings=settings_words(row.settings),
                )
    return table


def _span(seconds: float | None) -> str:
    return "–" if seconds is None else duration(seconds)


def compiled(compile_times: Sequence[Compiling]) -> Table:
    """Times to compile engines."""
    parts = ("compile_seconds", "compiling, once"), ("load_seconds", "loading, in every process")
    table = Table(
        "compiling",
        "Wall time of an engine’s first output step: when its machine code is compiled, and in a new process that finds compiled code.",
        ("engine", *(Column(key, head, "s", ".2g") for key, head in parts)),
    )
    for each in compile_times:
        table.add(each)
    return table


def scenes(races: Sequence[Race]) -> Table:
    """The scenes, and how well their solutions are known."""
    errors = (
        Column("error", "deflection", "%", ".2g", group="difference"),
        Column("worst", "worst of four", "%", ".2g", group="difference"),
    )
    table = Table(
        "benchmark_scenes",
        """The scenes, the solution that defines the error (reference), and the difference between it and the solution of another engine.
        The two share neither coordinates nor joint nor integrator.""",
        (_SCENE[0], Column("title", "what it is"), Column("duration", unit="s", form="g"), "truth", "confirmed_by", *errors),
    )
    for found in races:
        other = found.confirmation
        words = f"{other.engine} ({settings_words(other.settings)})" if other.error is not None else f"{other.engine}: {other.status}"
        table.add(found, case=found.case, truth=settings_words(found.truth), confirmed_by=words, error=other.error, worst=other.worst)
    return table


def every_row(races: Sequence[Race]) -> Table:
    """Every row of every scene, as a file."""
    units = {"error": "%", "worst": "%", "calls": "", "call_seconds": "s", "rows_seconds": "s", "solve_seconds": "s", "setup_seconds": "s"}
    columns = [Column(key, unit=unit, form=".3g") for key, unit in units.items()]
    table = Table(
        "benchmark",
        "Every row of the race: all methods, all scenes",
        (_SCENE[0], "method", "settings", "signed", *columns, "status"),
        in_page=False,
    )
    for found in races:
        for row in found.given:
            cells: dict[str, Any] = {"case": found.case, "settings": settings_words(row.settings)}
            table.add(row, **cells)
    return table
