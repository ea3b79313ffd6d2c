"""Facts of the chapter on who agrees with whom."""

from collections.abc import Mapping, Sequence
from typing import Any, Final

from quickreturn.cases.runs.comparison import REFERENCE, CaseResult, Kind, not_judged
from quickreturn.cases.runs.comparison import agreement as counted
from quickreturn.reports.findings.agreement import differences, engines_of, outward
from quickreturn.reports.findings.sharpness import sharpness
from quickreturn.reports.page.answer import answer_of
from quickreturn.reports.page.content import Content
from quickreturn.reports.page.plot import Plot, Series
from quickreturn.reports.tables import claims
from quickreturn.reports.tables.table import Cell, Column, Mark, Table
from quickreturn.reports.words import QUANTITY, case_label, number, place

#: Least difference over tolerance that is drawn; smaller ones are drawn here, because the logarithmic axis has no zero.
LEAST_USED = 1e-5

#: Kinds of numbers whose sharpness the chapter gives -> the word for one of them.
KINDS_GIVEN: Final[Mapping[Kind, str]] = {"frequency": "frequency", "extreme": "peak", "amplitude": "amplitude"}


def agreement(content: Content) -> dict[str, Any] | None:
    """The facts for `chapters/agreement.html`; None if there is only one engine."""
    results = content.results
    names = engines_of(results)
    if len(names) < 2:
        return None
    checks = [check for result in results for check in result.checks]
    sharp = sharpness(results)
    judged = {check.engine for check in checks} | {check.other for check in checks}
    return {
        "answer": answer_of(content),
        "checks": len(checks),
        "counted": counted(checks),
        "missed": [check for check in checks if not check.passed],
        "reasons": list(dict.fromkeys(result.reason for result in results if result.reason)),
        "unjudged": {name: _why(results, name) for name in names if name not in judged},
        "plot": _used(results) if checks else None,
        "sharpness": {word: of_kind for kind, word in KINDS_GIVEN.items() if (of_kind := [one for one in sharp if one.kind == kind])},
        "most_used": max((one.used for one in sharp), default=0.0),
        "sharp": claims.sharp(sharp),
        "map": run_map(results),
        "summary": claims.summary(results),
        "departures": claims.departures(results),
        "classes": claims.classes(results),
        "comparisons": claims.every_comparison(results),
    }


def _why(results: Sequence[CaseResult], name: str) -> str:
    return next((why for result in results if name in result.runs and (why := not_judged(result.runs[name]))), "nothing to compare with")


def _used(results: Sequence[CaseResult]) -> Plot:
    """Plot of the difference over the tolerance of every comparison, a row for each quantity, by engine."""
    checks = [(result.case.name, check) for result in results for check in result.checks if check.tolerance > 0.0]
    series = []
    for name in dict.fromkeys(check.engine for _, check in checks):
        mine = [(case, check, abs(check.difference) / check.tolerance) for case, check in checks if check.engine == name]
        texts = [f"{place(case, check.half, check.channel)}, {number(used, '.2g')} of the tolerance" for case, check, used in mine]
        used = [max(used, LEAST_USED) for *_, used in mine]
        series.append(Series(name, name, [QUANTITY[check.quantity] for _, check, _ in mine], used, texts, line=False))
    quantities = [words for key, words in QUANTITY.items() if any(check.quantity == key for _, check in checks)]
    return Plot("compared.csv", "", "difference over tolerance", series, "y", categories=quantities, limit=(1.0, "tolerance"))


def run_map(results: Sequence[CaseResult]) -> Table:
    """Table with a row per case: each engine's differences from the reference, and how many exceed what both claim."""
    names = [name for name in engines_of(results) if name != REFERENCE]
    columns = [Column("case", "run")]
    for name in names:
        columns.append(Column(f"{name}_frequency_difference", "f₁", "%", "+.2f", group=name))
        columns.append(Column(f"{name}_extreme_difference", "peaks", "%", "+.2f", group=name))
        columns.append(Column(f"{name}_beyond", "beyond", form="d", group=name))
    table = Table("map", columns)
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
        cells[f"{name}_{kind}_difference"] = Cell(largest, "n. r." if largest is None else "", why, "open" if why else "good", opens)
    return cells | {f"{name}_beyond": Cell(None, "–", why, mark, opens) if why else Cell(beyond, mark=mark, run=opens)}
