"""The sentences and figures of the first screen: how the engines agree, or what the user's own machine bears."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from markupsafe import Markup

from quickreturn.cases.files.shown import Unit
from quickreturn.cases.loads import UNITS, Loads
from quickreturn.cases.motion.number import Number
from quickreturn.reports.page.answer import Answer, Cubic
from quickreturn.reports.page.content import Subject
from quickreturn.reports.results.loads import CaseLoads, axial_words, from_p
from quickreturn.reports.words import (
    case_label,
    counted,
    degrees,
    in_words,
    listed,
    number,
    off_by,
    percent,
    percents,
    place,
    quantity,
    size,
)

#: Largest number of simulations that are named where they miss their accuracy.
MOST_NAMED: Final = 3
#: Loads that the first screen gives besides the stress -> what they are.
_LOADS: Final = {
    "crank_torque": "largest torque of the drive",
    "pivot_force": "largest force in the bearing P of the arm",
    "crank_force": "largest force in the bearing O of the crank",
    "slider_force": "largest force at the slider",
    "tip_deflection": "largest deflection of the tip",
}

Figure = tuple[str, str]


@dataclass(frozen=True)
class FirstScreen:
    """The text of the first screen, or of a machine's part of it.

    Attributes:
        title: its heading.
        warning: a sentence on results that miss their accuracy; "" if there are none.
        sentences: what was found.
        figures: numbers in large type, each with its meaning.
        resonance: a sentence on how near a resonance is; "" if there is none.
    """

    title: str
    warning: str
    sentences: Sequence[str]
    figures: Sequence[Figure]
    resonance: str = ""


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


def machine_screen(case: CaseLoads, nearness: str = "") -> FirstScreen:
    """What the person who builds a machine asks first; `nearness`: how near a resonance is, by its curve, if it has one."""
    if not case.lead:
        none = "No engine gives the stress of this machine’s arm: the chapter Provenance gives the reasons."
        return FirstScreen(case.case.title, "", [none], [])
    missed = f"These numbers miss their accuracy: {'; '.join(case.missed)}." if case.missed else ""
    beside = " An error beside a number below is the engine’s own estimate of it."
    texts = [case.verdict, largest_stress_words(case), departure_words(case)]
    return FirstScreen(case.case.title, missed and missed + beside, texts, machine_figures(case), nearness or case.resonance_sentence)


def largest_stress_words(case: CaseLoads) -> str:
    """Where and when the arm bears the largest stress."""
    stress = _largest(case.loads[case.lead])
    assert stress.place is not None
    share = percent(stress.place / case.case.mechanism.follower.length, ".0f")
    where = from_p(stress, case.case.units)
    return f"The largest stress is {where}, at {share} of the arm’s length, when the crank stands at {_angle(stress)}."


def departure_words(case: CaseLoads) -> str:
    """How much more or less stress the other engines find; "" without any."""
    found = [f"{name} finds {size(part)} {'more' if part > 0.0 else 'less'}" for name, part in case.departures().items()]
    return f"{case.lead} says so; {listed(found)}." if found else ""


def machine_figures(case: CaseLoads) -> list[Figure]:
    """The large numbers: stress, safety, forces, and the first mode over the crank's frequency."""
    loads, resonance, units = case.loads[case.lead], case.resonance, case.case.units
    stress = _largest(loads)
    assert loads.stress is not None
    parts = axial_words(loads.stress.axial, units) or "bending alone"
    shown = [(quantity(stress.value, units.of("Pa")), f"largest stress in the arm: {parts}{_error(stress)}"), safety_figure(case)]
    for key, what in _LOADS.items():
        peak = loads.peaks[key]
        if peak and peak.value:
            shown.append((quantity(peak.value, units.of(UNITS[key])), f"{what}, crank at {_angle(peak)}{_error(peak)}"))
    if resonance:
        mean = f"first mode (mean {quantity(resonance.first_mode, units.of('Hz'))}) over the crank’s frequency"
        off = off_by(case.shift_of_motion, resonance.first_mode)
        shown.append((number(resonance.ratio, ".2f"), f"{mean}; {off}"))
    return shown


def safety_figure(case: CaseLoads) -> Figure:
    """The safety factors that are known, the least first."""
    follower, unit = case.case.mechanism.follower, case.case.units.of("Pa")
    strengths = {"yielding": ("at", follower.yield_strength), "fatigue": ("at an amplitude of", follower.fatigue_strength)}
    told = [
        (factor.text, f"against {against} {strengths[against][0]} {_given(strengths[against][1], unit)}")
        for against, factor in case.loads[case.lead].factors
    ]
    if told:
        (least, against), *others = told
        return least, "; ".join([f"safety {against}", *(f"{factor} {other}" for factor, other in others)])
    return "–", Markup("safety: give <code>yield_strength</code> and <code>fatigue_strength</code> in <code>[follower]</code>")


def _given(strength: float | None, unit: Unit) -> str:
    assert strength is not None
    return f"{number(strength / unit.size, '.4g')} {unit.sign}"


def _largest(loads: Loads) -> Number:
    assert loads.stress is not None
    return loads.stress.largest


def _angle(peak: Number) -> str:
    assert peak.crank_angle is not None
    return degrees(peak.crank_angle)


def _error(peak: Number) -> str:
    return "; the engine gives no error" if math.isnan(peak.error) else f"; {off_by(peak.error, peak.value)}"
