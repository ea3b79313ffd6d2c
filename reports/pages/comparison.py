"""Runs by engines, and where they disagree."""

from typing import Final

from cases.comparison import EXTREMES
from reports.findings.agreement import engines_of, resolvable
from reports.pages.blocks import Chapter
from reports.pages.content import Content
from reports.tables import engines as engine_tables
from reports.tables import tolerances as tolerance_tables
from reports.words import case_label, counted, listed

_MOST_NAMED: Final = 6


def runs_by_engines(content: Content) -> Chapter:
    """Frequencies and amplitudes of every run and engine."""
    chapter = Chapter("runs", "Every run on every engine", "Runs × engines")
    if content.troubles:
        told = [f"{trouble.engine} on {case_label(trouble.case)}: {trouble.status}" for trouble in content.troubles]
        chapter.text(f"Not simply settled: {'; '.join(told)}. Why, in the engines' words, is under Provenance.", "warning")
    chapter.text(_resolved(content))
    chapter.table(engine_tables.run_by_engine(content.results))
    chapter.table(engine_tables.measures(content.results))
    return chapter


def _resolved(content: Content) -> str:
    """How often the measure gives a number at all."""
    counts = {name: resolvable(content.results, name) for name in engines_of(content.results)}
    told = [f"{name} {found} of {total}" for name, (found, total) in counts.items() if total]
    return f"Half cycles in which the first mode can be resolved: {', '.join(told)}." if told else ""


def disagreement(content: Content) -> Chapter:
    """Heat map and missed tolerances."""
    chapter = Chapter("disagreement", "Disagreement", "Disagreement")
    chapter.figures(
        (
            content.pictures.of_all.get("heat_map"),
            "Largest relative difference (%) over halves and channels of every pair of engines, run by run: first-mode frequency,"
            " first-mode amplitude, extremes.",
        )
    )
    checks = [check for result in content.results for check in result.checks]
    missed = [check for check in checks if not check.passed]
    chapter.heading("Tolerances", "tolerances")
    if not checks:
        chapter.text("No tolerance could be checked: no case has both a settled reference and another settled engine.", "warning")
    elif not missed:
        chapter.text(f"All {len(checks)} tolerances are met.")
    else:
        affected = [result for result in content.results if result.missed]
        names = listed(
            [case_label(result.case.name) for result in affected[:_MOST_NAMED]] + (["others"] if len(affected) > _MOST_NAMED else [])
        )
        extremes = sum(check.quantity in EXTREMES for check in missed)
        chapter.text(
            f"{len(missed)} of {counted(len(checks), 'tolerance')} missed: {extremes} by extremes and {len(missed) - extremes} by"
            f" frequencies, in {names}. The second table lists each with the engines' own error estimates beside it; what the numbers"
            " suggest as the cause is an inference."
        )
    chapter.table(tolerance_tables.summary(content.results))
    chapter.table(tolerance_tables.missed(content.results))
    return chapter
