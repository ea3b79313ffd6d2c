"""What the thesis leaves open, and accuracy beside cost."""

from typing import Final

import numpy as np
import pandas as pd

from cases.runs.comparison import REFERENCE
from reports.findings.agreement import engines_of
from reports.pages.blocks import Chapter
from reports.pages.content import Content
from reports.tables import studies as tables
from reports.tables.orbits import GONE_AT, SETTLED_AT, both_ways, orbits
from reports.tables.table import Table
from reports.words import case_label, counted, listed, number, percent, size, times

_ABSENT: Final = "This belongs to runs 10 and 24 of the thesis and is shown when both are among the cases."
#: What two solutions may differ by to confirm each other.
CONFIRMED: Final = 5e-4
#: A change of more than this part is worth a word; in a strong run the measure itself may be half of it off.
NOTABLE: Final = 0.01


def open_points(content: Content) -> Chapter:
    """Sensitivity to what the thesis does not say."""
    chapter = Chapter("open", "What the thesis leaves open", "Open points")
    if content.studies is None or content.studies.sensitivity.empty:
        chapter.text(_ABSENT, "note")
        return chapter
    frame = content.studies.sensitivity
    chapter.text(
        "Each row changes one thing that the thesis does not publish or that cannot be read, and brings the reference to its steady state"
        f" again. {_strongest(frame, 'first_mode_frequency', 'the first-mode frequency')}"
        f" {_strongest(frame, 'first_mode_amplitude', 'an amplitude')}"
    )
    chapter.text(_unfinished(content), "warning")
    chapter.figures(
        (
            content.pictures.of_all.get("sensitivity"),
            "Relative change (%) of first-mode frequency and amplitude with each open point; the mark is the median of the channels,"
            " the line reaches over all of them.",
        )
    )
    chapter.table(tables.sensitivity(frame))
    return chapter


def _strongest(frame: pd.DataFrame, quantity: str, words: str) -> str:
    """A sentence on the changes that move a quantity by more than `NOTABLE`, the strongest first."""
    known = frame[(frame["quantity"] == quantity) & frame["relative_change"].notna()]
    largest = known.assign(size=known["relative_change"].abs()).groupby("change")["size"].max().sort_values(ascending=False)
    notable = [f"{change} ({size(float(value))})" for change, value in largest.items() if value > NOTABLE]
    if not notable:
        return f"Nothing tried moves {words} by more than {percent(NOTABLE, '.0f')}."
    return f"What moves {words} by more than {percent(NOTABLE, '.0f')} somewhere: {listed(notable)}."


def _unfinished(content: Content) -> str:
    """That something is missing, where it is."""
    if content.studies is None or not content.studies.failures:
        return ""
    return f"{counted(len(content.studies.failures), 'part')} of the studies could not be made: see Provenance."


def accuracy_and_cost(content: Content) -> Chapter:
    """Error beside solve time; convergence; solve times of all runs."""
    chapter = Chapter("accuracy", "Accuracy and cost", "Accuracy, cost")
    studies = content.studies
    if studies is None:
        chapter.text(f"Accuracy against a confirmed solution, and convergence of the reference: {_ABSENT[0].lower()}{_ABSENT[1:]}", "note")
    else:
        chapter.text(_unfinished(content), "warning")
        _confirmation(chapter, studies.confirmation)
        if not studies.accuracy.empty:
            errors = [f"{row['engine']} {size(float(row['tip_deflection']))}" for row in studies.accuracy.to_dict("records")]
            chapter.text(f"At its default accuracy each engine errs in run 24's tip deflection by: {', '.join(errors)}.")
            chapter.table(tables.accuracy(studies.accuracy))
        if not studies.convergence.empty:
            chapter.heading("Convergence of the reference", "convergence")
            chapter.figures(
                (content.pictures.of_all.get("convergence"), "Error of the reference (% of RMS) in run 24 over its number of modes."),
            )
            chapter.table(tables.convergence(studies.convergence))
    chapter.heading("Steady states without waiting", "periodic-orbits")
    marching = [name for name in engines_of(content.results) if name != REFERENCE]
    found = orbits(content.results, marching)
    chapter.text(_saved(found))
    chapter.table(found)
    if studies is not None and not studies.both_ways.empty:
        chapter.text(_both_ways(studies.both_ways))
        chapter.table(both_ways(studies.both_ways))
    chapter.heading("Solve times to the steady state", "solve-times")
    chapter.table(tables.solve_times(content.results))
    return chapter


def _saved(found: Table) -> str:
    """How much less work than marching it is, in the median."""
    work, settled, gone = (
        np.array([row[index].value for row in found.rows], dtype=float)
        for index, column in enumerate(found.columns)
        if column.key in ("cycles_of_work", "cycles_to_settled", "cycles_to_gone")
    )
    if not len(work):
        return "No steady state was found directly: every engine marched."
    return (
        f"Finding the steady state takes the work of {number(float(np.nanmedian(work)), '.3g')} cycles in the median of"
        f" {counted(len(work), 'run')}: {times(float(np.nanmedian(settled / work)))} less than marching to {SETTLED_AT:g},"
        f" {times(float(np.nanmedian(gone / work)))} less than marching to {GONE_AT:g}."
    )


def _both_ways(frame: pd.DataFrame) -> str:
    """Whether both starts lead to the same cycle."""
    told = []
    for row in frame.to_dict("records"):
        within = float(row["difference"]) <= float(row["orbit_settling_error"]) + float(row["straight_settling_error"])
        left = "no more" if within else "more"
        told.append(
            f"{row['engine']} in {row['orbit_cycles']} and {row['straight_cycles']} cycles, {size(float(row['difference']))} apart ({left}"
            " than both say is left)"
        )
    return (
        "The packages begin in this state. That this is not what makes them agree with the reference, a run shows that they march from the"
        f" standard start as well, {case_label('thesis-24')}. Cycles from here and from there, and how far apart the two last ones lie:"
        f" {listed(told)}."
    )


def _confirmation(chapter: Chapter, frame: pd.DataFrame) -> None:
    if frame.empty:
        chapter.text("No second engine confirms the converged solution: the errors below are against it alone.", "warning")
        return
    for row in frame.to_dict("records"):
        difference = float(row["tip_deflection"])
        confirmed = difference <= CONFIRMED
        chapter.text(
            f"The converged solution of {case_label('thesis-24')} ({row['engine']}) and that of {row['confirmed_by']} differ by"
            f" {size(difference)} in the tip deflection: they {'confirm' if confirmed else 'do not confirm'} each other to"
            f" {percent(CONFIRMED)}.",
            "" if confirmed else "warning",
        )
    chapter.table(tables.confirmation(frame))
