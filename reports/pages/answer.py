"""The answer in ten lines and one picture, and how to read the rest."""

from collections.abc import Sequence
from itertools import pairwise
from typing import Final

import numpy as np

from cases.measures import CHANNELS
from cases.runs.comparison import CLASSES, REFERENCE, WORSE, CaseResult
from cases.runs.request import SETTLED
from engines.registry import engine
from reports.findings.agreement import Kind, differences, engines_of, spread
from reports.findings.verdicts import CANNOT_FOLLOW, HOLDS, IN_PART, MODEL, NOT, UNCHECKABLE
from reports.pages.blocks import Chapter
from reports.pages.content import Content
from reports.pages.methods import headline
from reports.tables.claims import score
from reports.words import HALF, case_label, counted, listed, number, percent, percents, place, size, span

#: "Agrees" where no difference is larger than claimed, "agrees but for a few" where at most this part of them is.
FEW: Final = 0.05

_KINDS: Final = {"frequency": "first-mode frequency", "amplitude": "first-mode amplitude", "extreme": "extremes"}


def answer(content: Content) -> Chapter:
    """First chapter."""
    chapter = Chapter("answer", "The answer", "Answer")
    chapter.points(_lines(content), numbered=True)
    if any(trouble.is_failure for trouble in content.troubles):
        chapter.text("Not every engine completed: the failures are listed under Provenance and marked ✗ wherever they matter.", "warning")
    chapter.figures((content.pictures.of_all.get("overview"), _overview_caption(content.results)))
    chapter.heading("How to read this", "how-to-read")
    chapter.points(
        [
            "A run is brought to its steady state by each engine; all numbers are of its last cycle, from the slider's farthest place"
            " (crank angle 180°) over the quick return (360°) to the next. Pre-return is the first half, post-return the second.",
            "The first-mode frequency is fitted to the drifting oscillation in each half and channel (tip acceleration, strains 1 to"
            " 3); its consensus weighs the channels that resolve it. ± is one standard deviation of the measure itself: two engines that"
            " share a wrong model can agree far better than that.",
            "n. r. means not resolvable: the measure gives no number rather than a bad one. – means that there is nothing to show.",
            f"Δ is relative to the engine {REFERENCE}; of frequencies, over the channels that both engines resolve. It is the thesis'"
            f" approach, converged ({engine(REFERENCE).method}). That it is right follows from the engines that share nothing with it:"
            " exudyn has nodal coordinates and a sliding joint, mujoco a chain of rigid links.",
            "Two engines may differ by what both claim: their own estimates of each number's error and the uncertainty of its measurement."
            " An engine departs where the difference is larger, marked ✗ like a failure; all such numbers are in the chapter Disagreement.",
            "The accuracy class says how good an engine is: the least of 0.1, 0.3, 1, 3 and 10 % that covers its own estimates and its"
            f" deviation from {REFERENCE}. {MODEL} has a model of its own: how far that is off is a result, and is not judged.",
            "Every table is beside this page as a CSV file, in full precision and SI units.",
        ]
    )
    return chapter


def _lines(content: Content) -> list[str]:
    results = content.results
    lines = [_scope(content)]
    others = [name for name in engines_of(results) if name not in (REFERENCE, MODEL)]
    lines += [line for name in others if (line := _against_reference(results, name))]
    lines += [line for first, second in pairwise(others) if (line := _pair(results, first, second))]
    lines += [line for line in (_cubic(results), _cubic_amplitudes(results), _statements(content)) if line]
    lines += [line for line in (_experiment(content), _accuracy(content), headline(content), _open_points(content)) if line]
    return lines


def _scope(content: Content) -> str:
    runs = [run for result in content.results for run in result.runs.values()]
    settled = sum(run.status == SETTLED for run in runs)
    names = listed(engines_of(content.results))
    said = f"{counted(len(content.results), 'run')} on {counted(len(engines_of(content.results)), 'engine')} ({names}): "
    if settled == len(runs):
        return f"{said}all {settled} simulations reached their steady state and the accuracy asked."
    others = [f"{trouble.engine} on {case_label(trouble.case)} ({trouble.status})" for trouble in content.troubles]
    shown = listed(others[:4] + ([f"{len(others) - 4} more"] if len(others) > 4 else []))
    return f"{said}{settled} of {len(runs)} simulations reached their steady state and the accuracy asked; not so {shown}."


def _verdict(results: Sequence[CaseResult], name: str) -> str:
    """In a clause: whether an engine departs from the reference by more than both claim, and how good it is."""
    checks = [check for result in results for check in result.checks if check.engine == name]
    missed = sum(not check.passed for check in checks)
    told = "agrees" if not missed else "agrees but for a few" if missed <= FEW * len(checks) else "departs"
    said = f"{told}: {score(results, name)}" if checks else f"is {score(results, name)}"
    found = [found for result in results if name in result.runs and (found := result.accuracy_class(name)) is not None]
    classes = [f"{found.count(one)} in class {one}" for one in (*(f"{100.0 * width:g} %" for width in CLASSES), WORSE) if one in found]
    return f"{said}; of its runs {listed(classes)}" if classes else said


def _against_reference(results: Sequence[CaseResult], name: str) -> str:
    told = _differences(results, name, REFERENCE, ("frequency", "amplitude", "extreme"))
    return f"{name} {_verdict(results, name)}. {told}" if told else ""


def _pair(results: Sequence[CaseResult], first: str, second: str) -> str:
    told = _differences(results, first, second, ("frequency", "extreme"))
    return f"{first} against {second}, which share neither coordinates nor joint. {told}" if told else ""


def _differences(results: Sequence[CaseResult], name: str, other: str, kinds: Sequence[Kind]) -> str:
    """Median and largest difference per kind, and where the largest of all is."""
    found = {kind: shown for kind in kinds if (shown := spread(differences(results, name, kind, other))) is not None}
    if not found:
        return ""
    worst = max((shown.worst for shown in found.values()), key=lambda difference: abs(difference.relative))
    parts = [f"{_KINDS[kind]} {size(shown.median_size)} / {size(shown.worst.relative)}" for kind, shown in found.items()]
    return f"Median / largest difference: {', '.join(parts)} (largest of all: {place(worst.case, worst.half, worst.channel)})."


def _cubic(results: Sequence[CaseResult]) -> str:
    found = {half: spread(differences(results, MODEL, "frequency", half=half)) for half in HALF}
    parts = [
        f"{HALF[half]} {percent(shown.median, '+.1f')} ({percents(shown.lowest, shown.highest, '+.1f')}, {counted(shown.count, 'run')})"
        for half, shown in found.items()
        if shown is not None
    ]
    if not parts:
        return ""
    signs = {shown.median > 0.0 for shown in found.values() if shown is not None}
    verb = "differs from the converged first-mode frequency" if len(signs) > 1 else f"vibrates too {'fast' if True in signs else 'slowly'}"
    return f"The thesis' single cubic ({MODEL}) {verb}: {', '.join(parts)}; medians and ranges of the first mode over the converged one."


def _cubic_amplitudes(results: Sequence[CaseResult]) -> str:
    parts = []
    for half, words in HALF.items():
        ratios = [d.ratio for channel in CHANNELS for d in differences(results, MODEL, "amplitude", half=half, channel=channel)]
        if ratios:
            parts.append(f"{words} {number(float(np.median(ratios)), '.2f')} times ({span(min(ratios), max(ratios), '.2f')})")
    return f"Its first-mode amplitudes over the converged ones, all channels, medians and ranges: {', '.join(parts)}." if parts else ""


def _statements(content: Content) -> str:
    if not content.thesis_results:
        return ""
    found = content.verdicts
    counts = [(verdict, sum(item.verdict == verdict for item in found)) for verdict in (HOLDS, IN_PART, NOT, CANNOT_FOLLOW, UNCHECKABLE)]
    words = [f"{count} {verdict.replace('holds', 'hold').replace('does', 'do')}" for verdict, count in counts if count]
    return f"Of the thesis' {len(found)} statements on frequency and amplitude, {listed(words)}."


def _experiment(content: Content) -> str:
    parts = []
    for channel, words in (("strain", "strain"), ("tip_acceleration", "tip acceleration")):
        ratios = [ratio for axis in content.axes if axis.channel == channel and (ratio := axis.ratio(MODEL)) is not None]
        if ratios:
            parts.append(f"{words} {span(min(ratios), max(ratios), '.2f')} ({counted(len(ratios), 'run')})")
    curves = [item.curve for item in content.comparisons]
    survives = (
        "No measured waveform survives"
        if not curves
        else f"{counted(len({(c.run, c.channel) for c in curves}), 'measured curve')} is compared"
    )
    if not parts:
        return f"Experiment: {survives}." if content.axes else ""
    return f"Experiment: {survives}; the single cubic's peaks over the largest printed axis label: {', '.join(parts)}."


def _accuracy(content: Content) -> str:
    studies = content.studies
    if studies is None or studies.accuracy.empty:
        return ""
    errors = [f"{row['engine']} {size(float(row['tip_deflection']))}" for row in studies.accuracy.to_dict("records")]
    others = [f"{row['confirmed_by']} to {size(float(row['tip_deflection']))}" for row in studies.confirmation.to_dict("records")]
    confirmed = f" (confirmed by {listed(others)})" if others else ""
    return (
        f"Error of the tip deflection in run 24, 2 s, at default accuracy, against the converged solution{confirmed}: {', '.join(errors)}."
    )


def _open_points(content: Content) -> str:
    frame = content.studies.sensitivity if content.studies is not None else None
    if frame is None or frame.empty:
        return ""
    frequency = frame[(frame["quantity"] == "first_mode_frequency") & frame["relative_change"].notna()]
    if frequency.empty:
        return ""
    worst = max(frequency.to_dict("records"), key=lambda row: abs(float(row["relative_change"])))
    change, where = percent(float(worst["relative_change"]), "+.1f"), f"{case_label(str(worst['run']))}, {HALF[worst['half']]}"
    return f"Of what the thesis leaves open, this moves the first mode most: {worst['change']}, {change} ({where})."


def _overview_caption(results: Sequence[CaseResult]) -> str:
    return (
        f"Difference of each engine from the reference over {counted(len(results), 'run')}, in percent: first-mode frequency of each"
        " half on the left, largest difference of the extremes on the right; shaded: what the engines claim."
    )
