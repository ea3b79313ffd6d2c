"""The sentences and figures of the first screen, among them how the engines agree."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np

from quickreturn.cases.comparison.engines import REFERENCE, CaseResult
from quickreturn.cases.comparison.pair import Kind
from quickreturn.cases.motion.endings import Ending
from quickreturn.cases.motion.request import Run
from quickreturn.engines.registry import MODEL
from quickreturn.reports.engine_differences import Spread, differences, engines_of, spread
from quickreturn.reports.page.content import Content, Subject
from quickreturn.reports.words import case_label, counted, in_words, listed, percent, percents, place, size

#: Largest part of an engine's numbers that may differ by more than claimed if it is to count as agreeing.
FEW: Final = 0.05


@dataclass(frozen=True)
class Cubic:
    """The thesis' model compared with the converged one."""

    frequency: Spread  # relative differences of its first-mode frequency
    strain: float | None  # its peak of the strain at mid-arm over the converged one, median over the cases


@dataclass(frozen=True)
class Answer:
    """The content of the first screen."""

    cases: int  # number of cases; in `compared` of them something could be judged
    compared: int
    engines: Sequence[str]  # names of all
    simulations: int  # number of simulations; `settled` of them are in their steady state at the accuracy asked
    settled: int
    missed: Sequence[str]  # a clause for each simulation that misses its accuracy
    alike: Sequence[str]  # engines whose numbers agree within their claims, the reference first; empty if nothing could be judged
    departing: Sequence[str]  # engines that were judged and are not alike
    frequency: Spread | None  # differences of these engines from the reference in the consensus first-mode frequency
    amplitude: Spread | None  # likewise in the first-mode amplitudes
    extreme: Spread | None  # likewise in the extremes
    cubic: Cubic | None  # None if the thesis' model or the reference is missing


def answer_of(content: Content) -> Answer:
    """The answer of a report."""
    results = content.results
    runs = [run for result in results for run in result.runs.values()]
    checks = [check for result in results for check in result.checks if check.verdict != "says nothing"]
    judged = list(dict.fromkeys(check.engine for check in checks))
    beyond = {name: [not check.passed for check in checks if check.engine == name] for name in judged}
    alike = [name for name in judged if sum(beyond[name]) <= FEW * len(beyond[name])]
    others = list(dict.fromkeys(check.other for check in checks)) if alike else []
    against = others[0] if others else REFERENCE
    kinds: tuple[Kind, ...] = ("frequency", "amplitude", "extreme")
    spreads = {kind: spread([difference for name in alike for difference in differences(results, name, kind, against)]) for kind in kinds}
    return Answer(
        cases=len(results),
        compared=sum(result.passed is not None for result in results),
        engines=engines_of(results),
        simulations=len(runs),
        settled=sum(run.status == Ending.SETTLED for run in runs),
        missed=[f"{result.case.name}: {clause}" for result in results for clause in accuracies_missed(result)],
        alike=[*others, *alike],
        departing=[name for name in judged if name not in alike],
        **spreads,
        cubic=_cubic_beside_converged(results),
    )


def accuracies_missed(result: CaseResult) -> tuple[str, ...]:
    """A clause for each engine whose estimate misses the accuracy asked, with both."""
    return tuple(_missed(run) for run in result.runs.values() if run.status == Ending.INACCURATE)


def _missed(run: Run) -> str:
    error, accuracy = run.computation.error_estimate, run.computation.accuracy
    estimate = "an unknown error" if error is None else f"an error of {size(error)} of the tip’s deflection"
    asked = "" if accuracy is None else f" where {percent(accuracy, 'g')} was asked"
    return f"{run.engine} estimates {estimate}{asked}"


def _cubic_beside_converged(results: Sequence[CaseResult]) -> Cubic | None:
    frequency = spread(differences(results, MODEL, "frequency"))
    if frequency is None:
        return None
    pairs = [(result.runs[MODEL], result.runs[REFERENCE]) for result in results if {MODEL, REFERENCE} <= set(result.runs)]
    ratios = [
        run.peak("strain_2") / other.peak("strain_2") for run, other in pairs if run.usable and other.usable and other.peak("strain_2")
    ]
    return Cubic(frequency, float(np.median(ratios)) if ratios else None)


#: Largest number of simulations that are named where they miss their accuracy.
MOST_NAMED: Final = 3
Figure = tuple[str, str]


@dataclass(frozen=True)
class FirstScreen:
    """The text of the first screen, or of a machine's part of it."""

    title: str  # its heading
    warning: str  # a sentence on results that miss their accuracy; "" if there are none
    sentences: Sequence[str]  # what was found
    figures: Sequence[Figure]  # numbers in large type, each with its meaning
    resonance: str = ""  # a sentence on how near a resonance is; "" if there is none
    along_arm: Mapping[str, Any] = field(default_factory=dict)  # what is drawn along the arm, for the script (`stage.js`); empty: nothing


def agreement_screen(answer: Answer, subject: Subject, title: str, last: Figure | None) -> FirstScreen:
    """How the engines agree.

    Args:
        answer: the numbers.
        subject: what the report is about.
        title: the heading; "": what the engines agree on.
        last: the last figure.
    """
    return FirstScreen(title or headline(answer), missed_words(answer), sentences(answer, subject), figures(answer, subject, last))


def headline(answer: Answer) -> str:
    """How many engines agree."""
    alike, engines = len(answer.alike), len(answer.engines)
    if alike > 1:
        of_engines = "" if alike == engines else f" of {in_words(engines)}"
        return f"{in_words(alike).capitalize()}{of_engines} simulations agree within their claims"
    if answer.departing:
        return "The simulations differ by more than they claim"
    return f"{counted(answer.cases, 'set-up')}, {counted(engines, 'engine')}"


def missed_words(answer: Answer) -> str:
    """How many simulations miss their accuracy; "" if none does."""
    missed = answer.missed
    if not missed:
        return ""
    theirs = "misses its" if len(missed) == 1 else "miss their"
    more = "; …" if len(missed) > MOST_NAMED else ""
    return f"{counted(len(missed), 'simulation')} of {answer.simulations} {theirs} accuracy: {'; '.join(missed[:MOST_NAMED])}{more}."


def sentences(answer: Answer, subject: Subject) -> list[str]:
    """What the mechanism is, how the engines agree, and how far off the thesis' model is."""
    departing, alike = answer.departing, len(answer.alike)
    moves = f"swings a {subject.arm} arm to and fro{', or turns it fully' if subject.turning else ''}, slowly out and quickly back"
    if subject.turning == 1.0:
        moves = f"turns a {subject.arm} arm fully, one half of the turn slowly and the other quickly"
    texts = [f"A motor turns a crank; its slider {moves}{subject.consequence}.", _compared(answer)]
    if alike > 1 and subject.sharpness:
        texts.append(subject.sharpness)
    if departing and alike > 1:
        others = "them" if alike > 2 else "these"
        texts.append(f"{listed(departing)} {'departs' if len(departing) == 1 else 'depart'} from {others} by more than claimed.")
    if answer.cubic:
        texts.append(_cubic(answer.cubic, "" if alike > 1 else " than the converged model"))
    return [*texts, subject.inference] if subject.inference else texts


def _compared(answer: Answer) -> str:
    """Whether the engines compute the same motion."""
    alike, cases = len(answer.alike), answer.cases
    setups = {1: "this set-up", 2: "both set-ups"}.get(cases, f"all {in_words(cases)} set-ups")
    if alike > 1:
        compared = setups if answer.compared == cases else f"{in_words(answer.compared)} of {in_words(cases)} set-ups"
        differs = f"; its ringing frequency differs by at most {size(answer.frequency.worst.relative)}" if answer.frequency else ""
        return (
            f"{in_words(alike).capitalize()} programs that model the arm in different ways compute the same motion in {compared}{differs}."
        )
    if answer.departing:
        others = "the others" if len(answer.departing) == 1 else "each other"
        return f"The programs that model it in different ways differ by more than they claim: {listed(answer.departing)} from {others}."
    if not answer.settled:
        return f"No program came to a steady state in {setups}: the chapter Provenance says why."
    unjudged = "The programs could not be judged against each other; they compute"
    return f"{'One program computes' if len(answer.engines) == 1 else unjudged} its motion in {setups}."


def _cubic(cubic: Cubic, than: str) -> str:
    median, strain = cubic.frequency.median, cubic.strain
    shows = "" if strain is None else f" and shows {percent(strain, '.0f')} of the strain at mid-arm"
    faster = "faster" if median > 0.0 else "more slowly"
    return f"The 1999 model, which lets the arm bend in one simple curve only, rings {size(median)} {faster}{than}{shows}."


def figures(answer: Answer, subject: Subject, last: Figure | None) -> list[Figure]:
    """The large numbers: what settled, the largest differences, and the last one that is given."""
    shown = [(f"{answer.settled} of {answer.simulations}", "simulations settled at the accuracy asked, by their own estimates")]
    alike, cubic = len(answer.alike), answer.cubic
    if answer.frequency:
        agree, amplitude = f" of the {in_words(alike)} that agree" if alike > 1 else "", ""
        if answer.amplitude:
            worst = answer.amplitude.worst
            amplitude = f"; largest amplitude difference {size(worst.relative)} ({case_label(worst.case)})"
        shown.append((size(answer.frequency.worst.relative), f"largest frequency difference{agree}{amplitude}"))
    if subject.on_the_model and cubic:
        spread = cubic.frequency
        over = f"the 1999 model’s frequency over the converged one (median; {percents(spread.lowest, spread.highest, '.0f')})"
        shown.append((percent(spread.median, "+.0f"), f"{over}; which is right is open: measured curves are lost"))
    elif answer.extreme:
        extreme = answer.extreme.worst
        where = place(extreme.case, extreme.half, extreme.channel)
        shown.append((size(extreme.relative), f"largest difference of a peak ({where})"))
    return [*shown, last] if last else shown
