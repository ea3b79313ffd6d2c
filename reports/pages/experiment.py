"""What is left of the experiment, and where the publication contradicts itself."""

import numpy as np

from cases.library import inconsistencies
from reports.findings.agreement import engines_of
from reports.findings.verdicts import MODEL
from reports.pages.blocks import Chapter
from reports.pages.content import Content
from reports.tables import experiment as tables
from reports.words import counted, listed, number, span


def experiment(content: Content) -> Chapter:
    """Crank speeds, axis labels, measured curves."""
    chapter = Chapter("experiment", "The experiment", "Experiment")
    chapter.text(
        "Of the experiment survive the crank speeds (table 3.1), the axis labels of the printed figures, and the words of sections"
        " 3.4, 3.5, 5.4 and 5.5. No measured waveform survives, so that no measured frequency or amplitude can be given per run; none"
        " is invented."
    )
    chapter.points(
        [text for text in (_ratios(content, "strain", "strain"), _ratios(content, "tip_acceleration", "tip acceleration")) if text]
    )
    chapter.table(tables.speeds_and_axes(content.results, content.axes))
    _curves(chapter, content)
    return chapter


def _ratios(content: Content, channel: str, words: str) -> str:
    parts = []
    for engine in engines_of(content.results):
        ratios = [ratio for axis in content.axes if axis.channel == channel and (ratio := axis.ratio(engine)) is not None]
        if ratios:
            median = number(float(np.median(ratios)), ".2f")
            parts.append(f"{engine} {span(min(ratios), max(ratios), '.2f')} (median {median}, {counted(len(ratios), 'run')})")
    if not parts:
        return ""
    closing = ""
    if channel == "tip_acceleration":
        below = [axis for axis in content.axes if axis.channel == channel and (ratio := axis.ratio(MODEL)) is not None and ratio < 0.5]
        if below:
            closing = (
                f" In {counted(len(below), 'run')} the single cubic reaches less than half of the label: the curves plotted, measured ones"
                " among them, reach further. Section 3.4 speaks of a vibration at 132 Hz. This is reported and not tuned away."
            )
    return f"Simulated peak over largest label, {words}: {'; '.join(parts)}.{closing}"


def _curves(chapter: Chapter, content: Content) -> None:
    chapter.heading("Measured curves", "curves")
    shown = [item.curve for item in content.comparisons]
    if not content.curves:
        chapter.text(
            "None is there. A digitised or newly measured curve can be dropped into the folder cases/experiment/curves as a CSV file"
            " per run and channel, in the form that the README there describes; it is then drawn, measured and compared here like an"
            " engine."
        )
        return
    synthetic = sum(curve.origin == "synthetic" for curve in content.curves)
    if synthetic:
        chapter.text(
            f"{counted(synthetic, 'curve')} {'is' if synthetic == 1 else 'are'} synthetic: made up to test this part of the report,"
            " and without weight in any verdict.",
            "warning",
        )
    left_out = sorted({curve.run for curve in content.curves} - {curve.run for curve in shown})
    if left_out:
        chapter.text(f"Curves of runs that are not among the cases shown: run {listed([str(run) for run in left_out])}.", "note")
    chapter.table(tables.curves(content.curves))
    chapter.table(tables.curve_comparison(content.comparisons, engines_of(content.results)))


def published(content: Content) -> Chapter:
    """Inconsistencies of the thesis."""
    chapter = Chapter("inconsistencies", "Published inconsistencies", "Inconsistencies")
    chapter.text(
        "Each was found by a check of the published tables against each other or against what a strip of aluminium can bear; what is used"
        " instead stands beside it."
    )
    chapter.table(tables.inconsistencies(inconsistencies()))
    return chapter
