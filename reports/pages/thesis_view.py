"""What the thesis saw: its own model against the converged one, and its statements."""

import math
from typing import Final

import numpy as np

from cases.data import read_toml
from cases.experiment import statements
from cases.measures import CHANNELS
from cases.units import BENDING_STIFFNESS, LENGTH, parse_quantity
from reports.findings.agreement import differences
from reports.findings.frozen_crank import JointEffect
from reports.findings.raw_extremes import Excess, counted_excess
from reports.findings.verdicts import CANNOT_FOLLOW, MODEL, NOT
from reports.pages.blocks import Chapter
from reports.pages.content import Content
from reports.tables import thesis_view as tables
from reports.words import HALF, case_label, counted, listed, number, percent, percents, span

PSI: Final = 6894.757293168361  # Pa
#: Young's modulus of common wrought aluminium alloys, Pa: 6061 and 2024, 10.0 and 10.6 million psi.
ALUMINIUM: Final = (10.0e6 * PSI, 10.6e6 * PSI)
#: Hz, the mode that section 3.4 reads off run 24 (cases/data/thesis_statements.toml).
SECOND_MODE: Final = next(found.low for found in statements() if found.id == "second-mode")
#: Channels in which the thesis' slow part is large.
STRAINS: Final = CHANNELS[1:]
#: A difference of an excess between the halves that a reader of plots would notice.
MARKED: Final = 0.02
#: A ratio this close to one is one.
EQUAL: Final = 0.01


def thesis_view(content: Content) -> Chapter:
    """The chapter."""
    chapter = Chapter("thesis", "What the thesis saw", "Thesis")
    if not content.thesis_results:
        chapter.text("This belongs to the runs of the thesis and is shown when one is among the cases.", "note")
        return chapter
    chapter.text(
        f"The engine {MODEL} is the thesis' model as published: one cubic for the whole follower. The reference is the same approach,"
        " converged. Their difference is the model error of the single cubic, as the thesis' author would have met it with a perfect"
        " experiment."
    )
    chapter.text(_halves(content))
    chapter.table(tables.ratios(content.thesis_results))
    _statements(chapter, content)
    _counted(chapter, content)
    _joint(chapter, content)
    _stiffness(chapter, content)
    return chapter


def _halves(content: Content) -> str:
    medians = {}
    for half in HALF:
        ratios = [difference.ratio for difference in differences(content.thesis_results, MODEL, "frequency", half=half)]
        if ratios:
            medians[half] = float(np.median(ratios))
    if len(medians) < 2:
        return ""
    alike = abs(medians["post"] / medians["pre"] - 1.0) <= EQUAL
    return (
        f"Its first-mode frequency is {number(medians['pre'], '.3f')} times the converged one before the return and"
        f" {number(medians['post'], '.3f')} times after it (medians):"
        f" {'the same in both halves' if alike else 'different in the two halves'} (to {percent(EQUAL, '.0f')})."
    )


def _statements(chapter: Chapter, content: Content) -> None:
    chapter.heading("Its statements", "statements")
    found = content.verdicts
    not_following = [verdict.statement.words for verdict in found if verdict.verdict == CANNOT_FOLLOW]
    contradicted = [verdict.statement.words for verdict in found if verdict.verdict == NOT]
    for head, words in (("Cannot follow from the model:", not_following), ("Not borne out by the numbers:", contradicted)):
        chapter.text(head if words else "")
        chapter.points(words)
    chapter.table(tables.statements(found))


def _counted(chapter: Chapter, content: Content) -> None:
    excesses = counted_excess(content.thesis_results)
    if not excesses:
        return
    chapter.heading("A possible explanation: frequencies counted off plots", "counted")
    strains = {half: [found.median for found in excesses if found.half == half and found.channel != "tip_acceleration"] for half in HALF}
    told = [f"{HALF[half]} {percents(min(found), max(found), '+.1f')}" for half, found in strains.items() if found]
    fitted = [difference.relative for difference in differences(content.thesis_results, MODEL, "frequency")]
    chapter.text(
        "How the thesis took frequencies from its curves it does not say; counting extremes by eye is the obvious way. Counted so, the"
        f" single cubic's excess over the converged model in the three strains is {listed(told)} (medians over the runs, range over"
        " channels and over what counts as an extreme), where fitting the drifting oscillation gives"
        f" {percents(min(fitted), max(fitted), '+.1f')} over both halves. {_reading(excesses)}"
    )
    chapter.table(tables.counted(excesses))


def _reading(excesses: list[Excess]) -> str:
    """What the counted frequencies suggest."""
    larger = []
    for visible in dict.fromkeys(found.visible for found in excesses):
        gaps = []
        for channel in STRAINS:
            medians = {found.half: found.median for found in excesses if (found.visible, found.channel) == (visible, channel)}
            gaps += [medians["post"] - medians["pre"]] if len(medians) == len(HALF) else []
        larger.append(bool(gaps) and min(gaps) > MARKED)
    times = f"at {sum(larger)} of the {len(larger)} thresholds tried"
    if all(larger):
        return (
            f"The counted excess is larger after the return in every strain, by more than {percent(MARKED, '.0f')}, {times}, as the thesis"
            " describes it: the slow hump before the return is counted among the peaks. Inference: a possible explanation, not a proof."
        )
    return (
        f"The counted excess is larger after the return in every strain, by more than {percent(MARKED, '.0f')}, {times} only: what is"
        " counted depends on the reader, and explains what the thesis describes at best in part. An inference."
    )


def _joint(chapter: Chapter, content: Content) -> None:
    if content.evidence is None or not content.evidence.joints:
        return
    chapter.heading("The slider joint", "joint")
    joints = content.evidence.joints
    soft = [effect for effect in joints if math.isfinite(effect.stiffness)]
    named = [
        f"at {number(effect.stiffness / 1e3, '.3g')} kN/m f₁ falls by {percent(-effect.change_pre, '.2f')} before and"
        f" {percent(-effect.change_post, '.2f')} after the return, and the third mode lies at"
        f" {span(effect.third_mode.low, effect.third_mode.high, '.0f')} Hz"
        for effect in soft
    ]
    compatible = [_joint_name(effect) for effect in joints if effect.third_mode.holds(SECOND_MODE)]
    excluded = [_joint_name(effect) for effect in joints if not effect.third_mode.holds(SECOND_MODE)]
    chapter.text(
        f"The thesis blames the softness of the slider joint. With the crank held, {'; '.join(named)}. A linear spring acts alike in both"
        " halves, for the frequencies depend on where the slider is and not on which way it goes."
        f" The {SECOND_MODE:g} Hz of section 3.4 lie within the third mode's range with {listed(compatible, 'or')}, not with"
        f" {listed(excluded, 'or')}. Inference: this bounds the stiffness of the joint from below, if {SECOND_MODE:g} Hz is the third mode."
    )
    chapter.table(tables.joints(content.evidence.joints, case_label("thesis-24")))


def _joint_name(effect: JointEffect) -> str:
    return "a rigid joint" if math.isinf(effect.stiffness) else f"one of {number(effect.stiffness / 1e3, '.3g')} kN/m"


def _stiffness(chapter: Chapter, content: Content) -> None:
    follower = read_toml("thesis_scene.toml")["follower"]
    thickness, width = (parse_quantity(follower[key], LENGTH) for key in ("thickness", "width"))
    modulus = parse_quantity(follower["bending_stiffness"], BENDING_STIFFNESS) / (width * thickness**3 / 12.0)
    below = [1.0 - modulus / ordinary for ordinary in ALUMINIUM]
    chapter.heading("The bending stiffness", "stiffness")
    text = (
        f"EI = {follower['bending_stiffness'].replace('*', ' ').replace('^2', '²')} over the nominal section means"
        f" E = {number(modulus / 1e9, '.1f')} GPa ({number(modulus / PSI / 1e6, '.2f')}·10⁶ psi),"
        f" {percents(min(below), max(below), '.0f')} below ordinary aluminium"
        f" ({span(ALUMINIUM[0] / 1e9, ALUMINIUM[1] / 1e9, '.0f')} GPa)."
    )
    excess = [difference.relative for difference in differences(content.thesis_results, MODEL, "frequency")]
    if excess and min(below) > 0.0:
        needed = 1.0 - (1.0 + float(np.median(excess))) ** -2.0
        text += (
            " A frequency grows with the square root of EI: to undo the single cubic's median excess of"
            f" {percent(float(np.median(excess)), '.1f')} ({counted(len(excess), 'half cycle')}) EI would have to be"
            f" {percent(needed, '.0f')} lower. Inference: the published value may have been tuned towards the measured"
            f" frequencies{'' if max(below) >= needed else ', though not all the way'}."
        )
    chapter.text(text)
