"""The sentences and figures of the first screen, among them how the engines agree."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Final

from quickreturn.reports.page.answer import Answer, Cubic
from quickreturn.reports.page.content import Subject
from quickreturn.reports.words import case_label, counted, in_words, listed, percent, percents, place, size

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
