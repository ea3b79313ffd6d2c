"""Runs by engines, and where they disagree."""

from typing import Final

from cases.runs.estimates import EXTREMES
from reports.findings.agreement import engines_of, resolvable
from reports.pages.blocks import Chapter
from reports.pages.content import Content
from reports.tables import claims as claim_tables
from reports.tables import engines as engine_tables
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
    chapter.heading("Claims", "claims")
    chapter.text(
        "Two engines may differ by what both claim: each one's own estimate of the error of this very number, and the uncertainty of its"
        " measurement. So a coarse engine that says how coarse it is agrees, and one that claims too much departs; how good it is, is"
        " another question (below)."
    )
    _judged(chapter, content)
    chapter.table(claim_tables.summary(content.results))
    chapter.table(claim_tables.departures(content.results))
    chapter.heading("How good each engine is", "classes")
    chapter.table(claim_tables.classes(content.results))
    return chapter


def _judged(chapter: Chapter, content: Content) -> None:
    """What became of the claims, and who was not judged."""
    results = content.results
    checks = [check for result in results for check in result.checks]
    missed = [check for check in checks if not check.passed]
    if not checks:
        reasons = list(dict.fromkeys(result.reason for result in results))
        chapter.text(f"Nothing could be judged: {'; '.join(reasons)}.", "warning")
        return
    if not missed:
        chapter.text(f"In all {counted(len(checks), 'comparison')} the engines differ by no more than they claim.")
    else:
        affected = [result for result in results if result.missed]
        names = listed(
            [case_label(result.case.name) for result in affected[:_MOST_NAMED]] + (["others"] if len(affected) > _MOST_NAMED else [])
        )
        extremes = sum(check.quantity in EXTREMES for check in missed)
        chapter.text(
            f"In {len(missed)} of {counted(len(checks), 'comparison')} engines differ by more than they claim: in"
            f" {counted(extremes, 'extreme')} and in {len(missed) - extremes} frequencies or amplitudes, in {names}. The second table lists"
            " each; what the numbers suggest as the cause is an inference."
        )
    for name in engines_of(results):
        if name not in {check.engine for check in checks} | {check.other for check in checks}:
            chapter.text(f"{name}: {claim_tables.score(results, name)}. Its differences are shown in the tables and pictures.", "note")
