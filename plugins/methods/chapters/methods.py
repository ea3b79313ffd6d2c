"""Which method excels: what each method needs for an error in each scene, in seconds and right-hand sides, and which factor buys what.

With it what comes of asking engines for an error, in the scenes of the race and in the hard ones.
"""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, replace
from typing import Final

from quickreturn.engines.registry import MODEL
from quickreturn.plugins.methods.compiling import Compiling
from quickreturn.plugins.methods.entrants import FACTORS, entrant, pairs
from quickreturn.plugins.methods.fronts import CRITERIA, DEFLECTION, WORST, Standing, front, standings
from quickreturn.plugins.methods.race import LONG, PATIENCE, REPETITIONS, Race
from quickreturn.plugins.methods.row import ENDED, LEVELS, MEANINGS, REACHED, WRONG, Row, by_method
from quickreturn.plugins.methods.search import SECONDS
from quickreturn.plugins.methods.studies import REQUESTED, SCENES, fronts_of, hard_scenes_of
from quickreturn.plugins.methods.truth import CONFIRMED, TRUTH
from quickreturn.reports.long_studies import table as recorded_table
from quickreturn.reports.page.chapter import Chapter, Plot, Series
from quickreturn.reports.page.content import Content
from quickreturn.reports.tables import CASE, Cell, Column, Mark, Table
from quickreturn.reports.words import case_label, counted, duration, percent, settings_words, size, times

_SCENE: Final = replace(CASE, head="scene")
_LEVEL: Final = (_SCENE, Column("level", "error", "%", "g"))


def methods(content: Content) -> Chapter | None:
    """The chapter; None if there was no race."""
    (races, record), (hard, of_hard) = content.of(fronts_of), content.of(hard_scenes_of)
    if not races:
        return None
    answers = [row for found in (*races, *hard) for row in found.rows if row.level is not None]
    facts = {
        "of_record": record,
        "runs": races[0].runs,
        "seconds": SECONDS,
        "long": LONG,
        "repetitions": REPETITIONS,
        "patience": PATIENCE,
        "missing": [name for name in SCENES if name not in {each.case for each in races}],
        "confirmed": CONFIRMED,
        "truth": f"{TRUTH[0]} ({settings_words(TRUTH[1])})",
        "fastest": {by: fastest(races, by) for by in CRITERIA},
        "factors": factors(races),
        "entrants": entrants(races[0], recorded_table("compiling", Compiling) if record else []),
        "chosen": chosen(races),
        "plots": [(each, {by: errors_over_time(each, by) for by in CRITERIA}) for each in races],
        "of_hard": of_hard,
        "requested": REQUESTED,
        "hard": of_answers([row for found in hard for row in found.rows]),
        "model": MODEL,
        "wrong": [f"{row.engine} in {row.scene}" for row in answers if row.status == WRONG],
        "meanings": {status: meaning for status, meaning in MEANINGS.items() if any(row.status == status for row in answers)},
        "waiting": waiting(answers),
        "scenes": scenes([*races, *hard]),
        "machine": ", ".join(f"{name}: {words}" for name, words in races[0].machine.items()),
        "rows": every_row(races),
    }
    return Chapter("methods", "Which method excels", finding(races), facts)


def finding(races: Sequence[Race]) -> str:
    """The method that is first in most contests, and how far the next engine's is behind it in the first scene."""
    ranked = [standings(found.given, level) for found in races for level in LEVELS]
    firsts = [next(iter(each.values())).row for each in ranked if each]
    if not firsts:
        return f"No method reaches any error in {len(races)} scenes"
    ((winner, count),) = Counter(row.engine for row in firsts).most_common(1)
    own = any(row.engine == winner and entrant(row).is_own for row in firsts)
    code = ", this project’s own code compiled for this one mechanism," if own else ""
    unwon = len(ranked) - len(firsts)
    text = f"{winner}{code} solves fastest in {count} of {len(ranked)} contests{f'; {unwon} nobody wins' if unwon else ''}"
    leads = [(level, lead) for level, at in zip(LEVELS, ranked, strict=False) if (lead := lead_of(at, winner))]
    words = [f"{times(factor)} as long to {percent(level, 'g')} ({name})" for level, (name, factor) in leads]
    return f"{text}; in {case_label(races[0].case)} the next takes {', '.join(words)}" if words else text


def lead_of(ranked: Mapping[str, Standing], winner: str) -> tuple[str, float] | None:
    """The first method of another engine than the winner, and its time over that of the winner; None without one of them."""
    first = next((at.seconds for at in ranked.values() if at.row.engine == winner), None)
    other = next(((name, at.seconds) for name, at in ranked.items() if at.row.engine != winner), None)
    return (other[0], other[1] / first) if first and other else None


def fastest_figure(content: Content) -> tuple[str, str] | None:
    """The fastest method to the second of the levels in the first scene; None if none reaches it."""
    races, _ = content.of(fronts_of)
    ranked = standings(races[0].given, LEVELS[1], DEFLECTION) if races else {}
    for name, at in ranked.items():
        own = ", made for this mechanism" if entrant(at.row).is_own else ""
        lead = lead_of(ranked, at.row.engine)
        other = f"; {lead[0]} takes {times(lead[1])} as long" if lead else ""
        what = f"to solve {case_label(races[0].case)} to {percent(LEVELS[1], 'g')} of the tip deflection: {name}{own}{other}"
        return duration(at.seconds), what
    return None


def of_answers(rows: Sequence[Row]) -> str:
    """The number of answers with each status, and of claims that do not hold; "" without any."""
    counts = Counter(row.status for row in rows)
    texts = [f"{counts[status]} {status}" for status in MEANINGS if counts[status] and status != WRONG]
    claims = counted(sum(row.claim is not None for row in rows), "claim")
    return f"Of {counted(len(rows), 'answer')} {', '.join(texts)}; {counts[WRONG] or 'none'} silently wrong of {claims}." if rows else ""


def _at_levels(races: Sequence[Race], by: str) -> Iterator[tuple[Race, float, dict[str, Standing]]]:
    yield from ((found, level, standings(found.given, level, by)) for found in races for level in LEVELS)


def fastest(races: Sequence[Race], by: str) -> Table:
    """What each method needs for each level in each scene, the fastest first."""
    numbers = (
        Column("level_seconds", "time to it", "ms", ".3g"),
        Column("level_calls", "right-hand sides to it", form=".4g"),
        Column("call_seconds", "for each", "µs", ".3g"),
        Column("rows_seconds", "for rows", "ms", ".2g"),
    )
    table = Table(
        f"fastest{'' if by == WORST else '_deflection'}",
        f"""Solve time and right-hand sides (of a package its time steps) of each method at an error, by {by}: interpolated on the method’s
        front in logarithms. The fastest is marked. What a right-hand side takes, and the rows of the table, is that of the first run below
        the error, as are the settings. A method that is not there does not reach the error.""",
        (*_LEVEL, "method", *numbers, Column("settings", "first run below it"), "signed"),
    )
    for found, level, ranked in _at_levels(races, by):
        for name, at in ranked.items():
            method = Cell(name, note=entrant(at.row).note, mark="good" if name == next(iter(ranked)) else "")
            values = {"level": level, "level_seconds": at.seconds, "level_calls": at.calls}
            table.add(at.row, case=found.case, method=method, settings=settings_words(at.row.settings), **values)
    return table


def factors(races: Sequence[Race]) -> Table:
    """What one factor buys: two methods that differ in it alone."""
    table = Table(
        "factors",
        """Which factor buys what: two methods that differ in shapes, constraint, integrator or implementation alone, by the worst of four
        columns; time and right-hand sides of the second over those of the first.""",
        (*_LEVEL, "factor", "method", "instead_of", _ratio("times", "time over"), _ratio("calls", "right-hand sides over")),
    )
    for found, level, ranked in _at_levels(races, WORST):
        for factor, one, other in pairs([at.row for at in ranked.values()]):
            first, second = ranked[one], ranked[other]
            ratios = {
                "times": second.seconds / first.seconds,
                "calls": second.calls / first.calls if first.calls and second.calls else None,
            }
            table.add(case=found.case, level=level, factor=factor, method=one, instead_of=other, **ratios)
    return table


def _ratio(key: str, head: str) -> Column:
    return Column(key, head, "1", ".2g")


def entrants(found: Race, compiling: Sequence[Compiling]) -> Table:
    """What each method is, how many runs it had, and what compiling takes."""
    compiled, seconds = {each.engine: asdict(each) for each in compiling}, ("compile_seconds", "load_seconds")
    table = Table(
        "entrants",
        """What the methods are. Order: a tenth of the error takes the root of this order of ten times as many steps, √10 = 3.2 for order 2
        and 1.3 for order 8: where a package’s integrator is of order 2, it and not the beam costs it most at small errors. Compiling: wall
        time of the first output step when machine code is compiled, once; loading: in each new process that finds it.""",
        (
            *("method", *FACTORS[:3], Column("order", form="d"), FACTORS[3], "note", Column("runs", form="d")),
            *(Column(key, head, "s", ".2g") for key, head in zip(seconds, ("compiling", "loading"), strict=True)),
        ),
    )
    for name, rows in by_method(found.given).items():
        of_code = {key: compiled[rows[0].engine][key] for key in seconds} if rows[0].engine in compiled else {}
        table.add(entrant(rows[0]), method=name, runs=len(rows), **of_code)
    return table


def chosen(races: Sequence[Race]) -> Table:
    """Settings that somebody signs, or that were found in the first scene, in all scenes."""
    numbers = Column("error", "worst of four", "%", ".2g"), Column("solve_seconds", "solve", "ms", ".3g"), _ratio("over", "over its front")
    table = Table(
        "chosen",
        f"""Settings that somebody chose, or the search in {case_label(races[0].case)}: their error in each scene, and their time over that
        of the method’s own front at that error. An error by a compensation does not carry over.""",
        (_SCENE, "method", "settings", "signed", *numbers),
    )
    for found in races:
        for row in (row for row in found.given if row.signed):
            own = standings([each for each in found.given if each.method == row.method], row.worst or 0.0).get(row.method)
            over = row.seconds / own.seconds if own and row.completed else None
            error = row.worst if row.completed else Cell(None, row.status, mark="open")
            table.add(row, case=found.case, settings=settings_words(row.settings), error=error, over=over)
    return table


def errors_over_time(found: Race, by: str) -> Plot:
    """The front of each method, and the front of all as a broad band."""

    def drawn(rows: Sequence[Row]) -> list[tuple[Row, float]]:
        return [(row, 100.0 * error) for row in front(rows, by) if (error := CRITERIA[by](row))]

    def words(row: Row) -> str:
        return f"{settings_words(row.settings)}; {duration(row.seconds)}{f', signed by {row.signed}' if row.signed else ''}"

    whole = drawn(found.given)
    series = [Series("Pareto front", "", [row.seconds for row, _ in whole], [error for _, error in whole], broad=True)]
    for name, rows in by_method(found.given).items():
        of, known = rows[0].engine, drawn(rows)
        texts = [f"{words(row)}, error {size(error / 100.0)}" for row, error in known]
        if known:
            series.append(Series(name, of, [row.seconds for row, _ in known], [error for _, error in known], texts, hollow=name != of))
    below = found.confirmation.error if by == DEFLECTION else found.confirmation.worst
    return Plot("benchmark.csv", "solve time [s]", f"error [%], {by}", series, "xy", None if below is None else 100.0 * below)


def waiting(answers: Sequence[Row]) -> Table:
    """What each engine does when it is asked for an error."""
    numbers = (
        Column("time", "at", "s", ".4g"),
        Column("error", "delivered", "%", ".2g"),
        Column("claim", "claimed", "%", ".2g"),
        Column("answer_seconds", "answer", "s", ".2g"),
        Column("solve_seconds", "of it solving", "s", ".2g"),
    )
    table = Table(
        "waiting",
        """Engines that are asked for an error of the tip deflection, as a user asks: what came of it (a click shows the reason), when a run
        ended early, the error of the answer, the engine’s own estimate, and the time for the answer: set-up, the search for settings, the
        solution, and the runs for the estimate. Compilation is not included.""",
        (*_LEVEL, "engine", "status", *numbers, "settings"),
    )
    for row in answers:
        mark: Mark = "failed" if row.status == WRONG else "" if row.status in (REACHED, ENDED) else "open"
        table.add(row, case=row.scene, status=Cell(row.status, note=row.remark, mark=mark), settings=settings_words(row.settings))
    return table


def scenes(races: Sequence[Race]) -> Table:
    """The scenes, and how well their solutions are known."""
    numbers = (
        Column("duration", unit="s", form="g"),
        Column("until", "known up to", "s", ".4g"),
        Column("error", "deflection", "%", ".2g", group="difference"),
        Column("worst", "worst of four", "%", ".2g", group="difference"),
    )
    table = Table(
        "benchmark_scenes",
        """The scenes, up to where the solution that defines the error is known, and its difference from a second one: of another engine,
        which shares neither coordinates nor joint nor integrator with it, or, in hard scenes, of the same one with four modes less.""",
        (_SCENE, Column("title", "what it is"), "confirmed_by", *numbers),
    )
    for found in races:
        other = found.confirmation
        words = f"{other.engine} ({settings_words(other.settings)})" if other.error is not None else f"{other.engine}: {other.status}"
        table.add(found, case=found.case, confirmed_by=words, error=other.error, worst=other.worst)
    return table


def every_row(races: Sequence[Race]) -> Table:
    """Every row of every scene, as a file."""
    units = {"error": "%", "worst": "%", "calls": "", "call_seconds": "s", "rows_seconds": "s", "solve_seconds": "s", "setup_seconds": "s"}
    numbers = [Column(key, unit=unit, form=".3g") for key, unit in units.items()]
    columns = [_SCENE, *map(Column, ("method", "settings", "signed")), *numbers, Column("status")]
    table = Table("benchmark", "Every row of the race: all methods, all scenes", columns, in_page=False)
    for found in races:
        for row in found.given:
            table.add(row, case=found.case, settings=settings_words(row.settings))
    return table
