"""One section per case: pictures, notes, a small table."""

from cases.library import inconsistencies
from cases.library.thesis import RUNS
from cases.runs.comparison import CaseResult, Check
from reports.pages.blocks import Chapter
from reports.pages.content import Content
from reports.tables.engines import case_table
from reports.words import HALF, QUANTITY, TIED, case_label, channel_name, counted, percent


def per_run(content: Content) -> Chapter:
    """The chapter."""
    chapter = Chapter("each-run", "Run by run", "Run by run", links=True)
    chapter.text(
        "Per run: tip acceleration and surface strains over the steady cycle as in the thesis' figures A.1 to A.24, the mechanism at"
        " eight crank angles with its deflection magnified, slider force, torque and crank speed, and a spectrogram of the tip"
        " acceleration under the natural frequencies that belong to each crank angle."
    )
    for result in content.results:
        _section(chapter, result, content)
    return chapter


def _section(chapter: Chapter, result: CaseResult, content: Content) -> None:
    case = result.case
    chapter.heading(case.title, f"case-{case.name}", case_label(case.name).removeprefix(f"run{TIED}"))
    general = {found.sentence for found in inconsistencies() if set(found.runs) == set(RUNS)}  # they have a chapter of their own
    for note in case.notes:
        if note not in general:
            chapter.text(f"{note[:1].upper()}{note[1:]}.", "note")
    for run in result.failures:
        chapter.text(f"{run.engine}: {run.status}. {run.remark}", "warning")
    drawn = content.pictures.of_case.get(case.name, {})
    label = case_label(case.name)
    chapter.figures(
        (drawn.get("cycle"), _cycle_caption(result, label)),
        (drawn.get("forces"), f"{label}: slider force (N), torque (N m) and crank speed (rad/s) over the cycle."),
        (drawn.get("mechanism"), f"{label}: the mechanism at eight crank angles of the cycle."),
        (
            drawn.get("spectrogram"),
            f"{label}: spectrogram of the tip acceleration (Hz over the cycle) with f₁, f₂, f₃ of the crank held still.",
        ),
    )
    if not any(drawn.values()):
        chapter.text("There is no cycle to draw.", "warning")
    chapter.table(case_table(result))
    for (engine, other), checks in result.departures.items():
        chapter.text(
            f"{engine} and {other} differ by more than they claim in {counted(len(checks), 'number')} (see Disagreement):", "warning"
        )
        chapter.points([_departure(check) for check in checks])


def _departure(check: Check) -> str:
    """A difference in words, with what is claimed."""
    place = f"{QUANTITY[check.quantity]}, {HALF[check.half]}, {channel_name(check.channel)}"
    difference, tolerance = percent(check.difference / check.scale, "+.2f"), percent(check.tolerance / check.scale)
    return f"{place}: {difference} (claimed together: {tolerance})"


def _cycle_caption(result: CaseResult, label: str) -> str:
    printed = "; shaded: range of the printed axis labels" if result.case.source == "library" and "thesis" in result.case.tags else ""
    return f"{label}: tip acceleration (m/s²) and surface strain at the three gauges (%) over the cycle, engines overlaid{printed}."
