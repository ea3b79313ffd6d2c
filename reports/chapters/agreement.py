"""Who agrees with whom: every comparison of two engines, with what both claim, and how small an error would show."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final, TypeVar

import numpy as np

from quickreturn.cases.comparison.engines import REFERENCE, CaseResult, not_judged
from quickreturn.cases.comparison.engines import agreement as verdicts
from quickreturn.cases.comparison.pair import KINDS, WAVEFORM, Difference, Kind
from quickreturn.cases.motion.cycle import EXTREMES
from quickreturn.cases.motion.number import SAYS_NOTHING, or_nan
from quickreturn.reports.engine_differences import differences, engines_of, outward, used_along
from quickreturn.reports.page.chapter import Chapter, Plot, Series
from quickreturn.reports.page.content import Content
from quickreturn.reports.page.first_screen import answer_of
from quickreturn.reports.page.view import shown_first
from quickreturn.reports.tables import COMPARISON, QUANTITY_COLUMN, UNRESOLVABLE, Cell, Column, Mark, Table, compared
from quickreturn.reports.words import QUANTITY, case_label, counted, in_words, listed, number, place, size

T = TypeVar("T")

#: Least difference over tolerance that is drawn; smaller ones are drawn here, because the logarithmic axis has no zero.
LEAST_USED: Final = 1e-5
#: Crank angles of a cycle that a plot of differences leaves out between two points, and those between two rows of its table.
FINE: Final = 2
COARSE: Final = 10
#: Kinds of numbers whose sharpness the chapter gives -> the word for one of them.
KINDS_GIVEN: Final[Mapping[Kind, str]] = {"frequency": "frequency", "extreme": "peak", "amplitude": "amplitude", "waveform": "waveform"}


@dataclass(frozen=True)
class Sharpness:
    """Errors that the comparisons of one kind between two engines can find; errors and tolerances are relative."""

    engine: str  # errors are planted in its numbers
    other: str  # the engine that it is compared with
    kind: Kind  # of numbers
    compared: int  # how many
    tolerance: float  # median of the tolerances, over the number itself; of an extreme over the channel's largest magnitude
    used: float  # largest ratio of a measured difference to its tolerance
    found_somewhere: float  # smallest planted error, of either sign, that at least one comparison finds
    found_mostly: float  # smallest planted error, of either sign, that at least half of the comparisons find
    found_nearly_always: float  # the same for nine of ten comparisons


def agreement(content: Content) -> Chapter | None:
    """The chapter; None if there is only one engine."""
    results = content.results
    names = engines_of(results)
    if len(names) < 2:
        return None
    answer, checks, sharp = answer_of(content), [check for result in results for check in result.checks], sharpness(results)
    judged = {check.engine for check in checks} | {check.other for check in checks}
    unjudged = {name: _why(results, name) for name in names if name not in judged}
    of_kinds = {word: of_kind for kind, word in KINDS_GIVEN.items() if (of_kind := [one for one in sharp if one.kind == kind])}
    facts = {
        "checks": len(checks),
        "reasons": list(dict.fromkeys(result.reason for result in results if result.reason)),
        "unjudged": unjudged,
        "plot": _used(results) if checks else None,
        "along": _used_along(shown_first(results)),
        "waveforms": waveforms(results),
        "sharp": sharp_table(sharp),
        "map": run_map(results),
        "summary": summary(results),
        "departures": departures(results),
        "comparisons": every_comparison(results),
    }
    cubic = answer.cubic.frequency.worst.relative if answer.cubic else None
    return Chapter("agreement", "Who agrees with whom", finding(verdicts(checks), answer.alike, of_kinds, cubic), facts)


def finding(agreement: Mapping[str, int], alike: Sequence[str], sharpness: Mapping[str, Sequence[Sharpness]], cubic: float | None) -> str:
    """Whether engines agree, how small an error would have shown, and how far off the thesis' model is.

    Args:
        agreement: how many comparisons "agree", "disagree" and are kept but say nothing ("says_nothing").
        alike: engines that agree, first the one that the others are compared with.
        sharpness: word for a kind of numbers -> the smallest errors that are found in each engine.
        cubic: largest relative difference of the frequency of the thesis' model from the converged one; None if it is not known.
    """
    agree, disagree, silent = (agreement[key] for key in ("agree", "disagree", "says_nothing"))
    compared = agree + disagree + silent
    if not compared:
        text = "Nothing could be judged"
    elif disagree:
        text = f"In {disagree} of {counted(compared, 'comparison')} engines differ by more than they claim"
    elif not agree:
        text = f"{counted(compared, 'comparison')} say nothing: what is claimed is too wide"
    else:
        every = "all " if agree == compared > 1 else ""
        more = f" ({silent} more say nothing)" if silent else ""
        found = [f"{size(max(row.found_somewhere for row in rows))} in every {word}" for word, rows in sharpness.items()]
        compared_with = f"{every}{counted(agree, 'comparison')} with {alike[0]}{more}, which would show an error of {listed(found, 'or')}"
        text = f"{in_words(len(alike)).capitalize()} agree within what they claim in {compared_with}"
    return text if cubic is None else f"{text}; the 1999 model’s frequency is {size(cubic)} off the converged one at worst"


def _why(results: Sequence[CaseResult], name: str) -> str:
    return next((why for result in results if name in result.runs and (why := not_judged(result.runs[name]))), "nothing to compare with")


def _used(results: Sequence[CaseResult]) -> Plot:
    """Plot of the difference over the tolerance of every comparison, a row for each quantity, by engine."""
    checks = [(result.case.name, check) for result in results for check in result.checks if check.tolerance > 0.0]
    series = []
    for name in dict.fromkeys(check.engine for _, check in checks):
        of_engine = [(case, check, abs(check.difference) / check.tolerance) for case, check in checks if check.engine == name]
        texts = [f"{place(case, check.half, check.channel)}, {number(used, '.2g')} of the tolerance" for case, check, used in of_engine]
        used = [max(used, LEAST_USED) for *_, used in of_engine]
        series.append(Series(name, name, [QUANTITY[check.quantity] for _, check, _ in of_engine], used, texts, line=False))
    quantities = [words for key, words in QUANTITY.items() if any(check.quantity == key for _, check in checks)]
    return Plot("compared.csv", "", "difference over tolerance", series, "y", categories=quantities, limit=(1.0, "tolerance"))


def _used_along(result: CaseResult) -> Plot | None:
    """Plot of the waveforms' differences over their tolerance over a cycle of one run, by engine; None if none is judged."""
    series = [
        Series(name, name, [360.0 * k / len(used) for k in range(0, len(used), FINE)], [float(part) for part in used[::FINE]], marked=False)
        for name in result.runs
        if (used := used_along(result, name)) is not None
    ]
    series.append(Series("what both claim", "what both claim", [0.0, 360.0], [1.0, 1.0]))
    angle = "crank angle from the farthest place (deg)"
    return Plot("waveforms.csv", angle, "difference over tolerance", series) if len(series) > 1 else None


def waveforms(results: Sequence[CaseResult]) -> Table:
    """A file: the differences of waveforms over their tolerance, over a cycle of each run."""
    columns = ("case", "engine", Column("crank_angle", unit="deg", form=".0f"), Column("used", form=".3g"))
    table = Table("waveforms", "The largest difference of an engine's channels over the tolerance.", columns, in_page=False)
    for result in results:
        for name in result.runs:
            if (used := used_along(result, name)) is not None:
                for place in range(0, len(used), COARSE):
                    table.add(case=result.case.name, engine=name, crank_angle=360.0 * place / len(used), used=used[place])
    return table


def run_map(results: Sequence[CaseResult]) -> Table:
    """Table with a row per case: each engine's differences from the reference, and how many exceed what both claim."""
    names = [name for name in engines_of(results) if name != REFERENCE]
    columns = [Column("case", "run")]
    for name in names:
        columns.append(Column(f"{name}_frequency_difference", "f₁", "%", "+.2f", group=name))
        columns.append(Column(f"{name}_extreme_difference", "peaks", "%", "+.2f", group=name))
        columns.append(Column(f"{name}_beyond", "beyond", form="d", group=name))
    table = Table(
        "map",
        """Differences from the reference: the larger one of the first-mode frequency (consensus of the channels) before and after the
        return; the largest one of the extremes (relative to the channel's largest magnitude; positive where the engine swings further: a
        higher maximum, a lower minimum); and the number of values in which the two differ by more than they claim (✗). A click on a cell
        opens its run.""",
        columns,
    )
    for result in results:
        cells: dict[str, Any] = {"case": Cell(result.case.name, case_label(result.case.name), run=result.case.name)}
        for name in names:
            if name in result.runs:
                cells |= _map_cells(result, name)
        table.add(**cells)
    return table


def _map_cells(result: CaseResult, name: str) -> dict[str, Cell]:
    run, opens = result.runs[name], result.case.name
    if not run.usable:
        return {f"{name}_frequency_difference": Cell(None, run.status, run.remark, "failed", opens)}
    why, beyond = not_judged(run), sum(not check.passed for check in result.checks if check.engine == name)
    mark: Mark = "missed" if beyond else "open" if why else "good"
    cells = {}
    for kind in ("frequency", "extreme"):
        signed = [outward(difference.quantity, difference.relative) for difference in differences([result], name, kind)]
        largest = max(signed, key=abs, default=None)
        cells[f"{name}_{kind}_difference"] = Cell(largest, UNRESOLVABLE if largest is None else "", why, "open" if why else "good", opens)
    return cells | {f"{name}_beyond": Cell(None, "–", why, mark, opens) if why else Cell(beyond, mark=mark, run=opens)}


def departures(results: Sequence[CaseResult]) -> Table:
    """One row per number in which two engines differ by more than they claim."""
    columns = (
        *COMPARISON,
        Column("claim", "engine", "%", ".2g", group="claim"),
        Column("other_claim", "other", "%", ".2g", group="claim"),
        Column("measurement", "measurement", "%", ".2g", group="claim"),
        Column("share", unit="1", form=".2f"),
    )
    table = Table(
        "departures",
        """Every number in which two engines differ by more than they claim. Difference, claims and tolerance are relative to the other
        engine's value; for an extreme they are relative to the channel's largest magnitude in the cycle. A difference is positive if the
        engine's number is larger; for a minimum, if it is lower. A claim contains the engine's own estimate of the number's error and what
        is left to its steady state; the measurement's part is its uncertainty in both, as far as the two signals differ. The tolerance is
        the sum of the three. Share: the size of the value over the channel's largest magnitude.""",
        columns,
    )
    for result in results:
        for check in result.missed:
            cells = compared(result, check)
            table.add(
                check,
                **cells | {"difference": Cell(cells["difference"], mark="missed")},
                claim=(or_nan(check.number.estimate) + check.number.settling) / check.scale,
                other_claim=(or_nan(check.other_number.estimate) + check.other_number.settling) / check.scale,
                measurement=check.unshared / check.scale,
                share=abs(check.other_number.value) / check.scale if check.quantity in EXTREMES else None,
            )
    return table


def summary(results: Sequence[CaseResult]) -> Table:
    """Per pair of engines and quantity: the number of comparisons, the tolerance, and the part of it that was used."""
    columns = (
        "engine",
        Column("other", "against"),
        QUANTITY_COLUMN,
        Column("compared", form="d"),
        Column("beyond", form="d"),
        Column("say_nothing", form="d"),
        Column("tolerance", unit="%", form=".2g"),
        Column("used_median", "median", "1", ".2f", group="used"),
        Column("used_most", "most", "1", ".2f", group="used"),
    )
    table = Table(
        "compared",
        f"""What was compared. Tolerance: what both engines claim together, relative as above, median. Say nothing: kept, but the tolerance
        is more than {SAYS_NOTHING}. Used: the difference over the tolerance; beyond 1 the engines differ by more than they claim.""",
        columns,
    )
    for (engine, other, quantity), checks in _grouped(results, lambda check: check.quantity).items():
        used = [abs(check.difference) / check.tolerance for check in checks if check.tolerance > 0.0]
        beyond = sum(not check.passed for check in checks)
        table.add(
            engine=engine,
            other=other,
            quantity=quantity,
            compared=len(checks),
            beyond=Cell(beyond, mark="missed" if beyond else ""),
            say_nothing=verdicts(checks)["says_nothing"],
            tolerance=float(np.median([check.tolerance / check.scale for check in checks])),
            used_median=float(np.median(used)) if used else None,
            used_most=max(used, default=None),
        )
    return table


def _grouped(results: Sequence[CaseResult], sort: Callable[[Difference], T]) -> dict[tuple[str, str, T], list[Difference]]:
    """Comparisons by both engines and a sort of numbers."""
    groups: dict[tuple[str, str, T], list[Difference]] = {}
    for check in (check for result in results for check in result.checks):
        groups.setdefault((check.engine, check.other, sort(check)), []).append(check)
    return groups


def every_comparison(results: Sequence[CaseResult]) -> Table:
    """A file: one row per comparison of two engines, agreeing or not, in SI units.

    The tolerance is the sum of estimates, settling, each the sum of both engines', and measurement, the uncertainty of both as far as their
    signals differ; `why` names the runs that show the estimates.
    """
    names = ("case", "engine", "other", "quantity", "half", "channel", "value", "other_value", "estimate", "measurement", "settling")
    table = Table(
        "comparisons",
        """Every comparison: both values (of a waveform the size of the difference, and 0), the sum of both engines' estimates, of the
        measurements as far as the signals differ, and of what is left to the steady states, which is the tolerance, the verdict, and the
        runs that show the estimates; SI units.""",
        (*names, "tolerance", "verdict", "unit", "why"),
        in_page=False,
    )
    for result in results:
        for check in result.checks:
            both = {name: getattr(check.number, name) + getattr(check.other_number, name) for name in ("estimate", "settling")}
            why = "; ".join(check.why)
            table.add(
                check,
                case=result.case.name,
                value=check.number.value,
                other_value=check.other_number.value,
                measurement=check.unshared,
                unit=check.unit,
                why=why,
                **both,
            )
    return table


def sharp_table(rows: Sequence[Sharpness]) -> Table:
    """Per pair of engines and kind of numbers: the smallest error that the comparison finds."""
    columns = (
        "engine",
        Column("other", "against"),
        Column("kind", "numbers", words=lambda kind: "peak" if kind == "extreme" else str(kind)),
        Column("compared", form="d"),
        Column("tolerance", unit="%", form=".2g"),
        Column("used", "most used", "1", ".2f"),
        Column("found_somewhere", "in one at least", "%", ".2g", group="smallest error that is found"),
        Column("found_mostly", "in half of them", "%", ".2g", group="smallest error that is found"),
        Column("found_nearly_always", "in nine of ten", "%", ".2g", group="smallest error that is found"),
    )
    table = Table(
        "sharpness",
        """The smallest error that the comparison finds. For this an error is planted: all of an engine's numbers of one kind grow or shrink
        by the same part and are judged again. The table gives the smallest part of either sign that at least one comparison finds, that
        half of the comparisons find, and that nine of ten find. Tolerance and used: as above; tolerances of extremes and of the largest
        difference of waveforms are relative to the channel's largest magnitude.""",
        columns,
    )
    for row in rows:
        table.add(row)
    return table


def sharpness(results: Sequence[CaseResult]) -> list[Sharpness]:
    """The sharpness of every compared pair of engines and every kind of numbers."""
    kinds = {quantity: kind for kind, quantities in KINDS.items() for quantity in quantities}
    groups = _grouped(results, lambda check: kinds[check.quantity])
    pairs = dict.fromkeys((engine, other) for engine, other, _ in groups)
    return [_of(*pair, kind, groups[*pair, kind]) for pair in pairs for kind in KINDS if (*pair, kind) in groups]


def smallest_found(check: Difference, sign: int) -> float:
    """The smallest relative error of one sign (1 or -1) in the engine's number that the comparison finds; infinite if it finds none.

    The error of a waveform is a gain: with one of more than tolerance and difference together the difference exceeds the tolerance.
    """
    change = sign * check.number.value
    if not check.passed:
        return 0.0
    if check.quantity in WAVEFORM:
        return (check.tolerance + check.difference) / check.scale
    return (check.tolerance - math.copysign(1.0, change) * check.difference) / abs(change) if change != 0.0 else math.inf


def _of(engine: str, other: str, kind: Kind, checks: Sequence[Difference]) -> Sharpness:
    by_sign = [sorted(smallest_found(check, sign) for check in checks) for sign in (1, -1)]
    return Sharpness(
        engine,
        other,
        kind,
        len(checks),
        tolerance=float(np.median([check.tolerance / check.scale for check in checks])),
        used=max(abs(check.difference) / check.tolerance if check.tolerance > 0.0 else np.inf for check in checks),
        found_somewhere=max(errors[0] for errors in by_sign),
        found_mostly=max(errors[(len(checks) - 1) // 2] for errors in by_sign),
        found_nearly_always=max(errors[math.ceil(0.9 * len(checks)) - 1] for errors in by_sign),
    )
