"""The verdict on each of the thesis' statements: it holds, it cannot follow from the model, or it cannot be checked."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Final

from quickreturn.cases.comparison.engines import REFERENCE, CaseResult
from quickreturn.cases.motion.cycle import HALVES
from quickreturn.engines.registry import MODEL
from quickreturn.plugins.thesis.experiment import Statement, statements
from quickreturn.plugins.thesis.finding.study import Row
from quickreturn.plugins.thesis.modes import ELEMENTS, Span, ThesisModes
from quickreturn.plugins.thesis.runs import thesis_runs
from quickreturn.reports.results.engine_differences import Summary, differences, summary_of
from quickreturn.reports.words import number, percent, size, span

HOLDS: Final = "holds"
IN_PART: Final = "holds in part"
NOT: Final = "does not hold"
CANNOT_FOLLOW: Final = "cannot follow from the model"
UNCHECKABLE: Final = "cannot be checked"
OUTCOMES: Final = (HOLDS, IN_PART, NOT, CANNOT_FOLLOW, UNCHECKABLE)

#: Ratios to the converged frequency within which a frequency counts as "accurate".
ACCURATE: Final = (0.97, 1.05)
#: An effect counts as the same in both halves if it differs between them by less than this part of itself.
SAME_EFFECT: Final = 0.1
#: Another element helps if it reduces the error below this part of the previous one.
FALLS: Final = 0.5
#: A mode has a pattern of signs if it shows the pattern at this share of the crank angles.
MOSTLY: Final = 0.9
#: Frequencies depend on a quantity if its change changes them by more than this part: three times the measure's error in a strong run.
DEPENDS: Final = 0.015


@dataclass(frozen=True)
class Conclusion:
    """The verdict on a statement of the thesis."""

    statement: Statement
    outcome: str  # one of `OUTCOMES`
    numbers: str  # the numbers that decide, in sentences
    inference: bool = False  # whether it is a reading that the numbers allow but do not prove


@dataclass(frozen=True)
class Basis:
    """The data from which conclusions are drawn."""

    results: Sequence[CaseResult]  # cases shown
    thesis_modes: ThesisModes | None  # of the thesis' example run; None if that run is not among the cases
    # quantity of a statement -> run -> ratio simulation / experiment; empty as long as no measured waveform exists
    measured: Mapping[str, Mapping[int, float]] = field(default_factory=dict)
    finding: Sequence[Row] = ()  # the recorded study of each effect; empty if there is none


def conclusions(basis: Basis) -> list[Conclusion]:
    """One per statement, in the order of the thesis."""
    return [_conclusion(statement, basis) for statement in statements()]


def post_over_pre(results: Sequence[CaseResult], engine: str) -> dict[int, float]:
    """Run -> first-mode frequency after the return over that before it, where both are resolvable."""
    ratios = {}
    for run_number, result in thesis_runs(results).items():
        run = result.runs.get(engine)
        pair = tuple(run.consensus_frequency(half) for half in HALVES) if run is not None and run.usable else (None, None)
        if pair[0] is not None and pair[1] is not None:
            ratios[run_number] = pair[1] / pair[0]
    return ratios


def _conclusion(statement: Statement, basis: Basis) -> Conclusion:
    if statement.id not in _CRANK_HELD:
        return _RULES.get(statement.id, _relation)(statement, basis)
    frozen = basis.thesis_modes
    if frozen is None:
        text = f"Run {statement.runs[-1]} is not among the cases shown, or its reference did not settle."
        return Conclusion(statement, UNCHECKABLE, text)
    return _CRANK_HELD[statement.id](statement, frozen, basis)


def _relation(statement: Statement, basis: Basis) -> Conclusion:
    """A statement on the ratio simulation / experiment, which needs a measured waveform."""
    values = basis.measured.get(statement.quantity, {})
    share, runs = statement.share_of(values), sum(run in values for run in statement.runs)
    if share is None:
        return Conclusion(statement, UNCHECKABLE, "It compares with measured waveforms, but none survives.")
    required = f"the words require {percent(statement.share, '.0f')}"
    text = f"{percent(share, '.0f')} of the {runs} runs with measured curves show a ratio of {_limits(statement)}; {required}."
    return Conclusion(statement, HOLDS if statement.holds(values) else NOT, text)


def _first_mode(statement: Statement, frozen: ThesisModes, basis: Basis) -> Conclusion:
    first = frozen.converged[0]
    overlap = max(0.0, min(first.high, statement.high) - max(first.low, statement.low)) / (statement.high - statement.low)
    outcome = HOLDS if overlap == 1.0 else IN_PART if overlap > 0.0 else NOT
    run = thesis_runs(basis.results).get(statement.runs[0])
    reference = run.runs.get(REFERENCE) if run else None
    means = [reference.consensus_frequency(half) for half in HALVES] if reference is not None and reference.usable else []
    overlaps = "overlaps the upper part of" if first.low < statement.low else "overlaps"
    within = f"the printed range {'lies within' if overlap == 1.0 else overlaps} this."
    text = f"With the crank held, the converged first mode runs from {_range(first, '.1f')} over the crank angle; {within}"
    if known := " and ".join(f"{number(mean, '.1f')} Hz" for mean in means if mean is not None):
        text += f" Its time mean in the simulated cycle is {known}, before and after the return."
    return Conclusion(statement, outcome, f"{text} The measured waveform itself is lost.")


def _second_mode(statement: Statement, frozen: ThesisModes, basis: Basis) -> Conclusion:
    second, third = frozen.converged[1:3]
    holds = second.holds(statement.low)
    is_third = not holds and third.holds(statement.low)
    ranges = (_range(mode, ".0f") for mode in (second, third, frozen.cubic[1]))
    text = "With the crank held, the second converged mode lies at {}, the third at {}, the single cubic's second at {}.".format(*ranges)
    text += f" {statement.low:g} Hz is the third mode, not the second." if is_third else ""
    return Conclusion(statement, HOLDS if holds else NOT, text, inference=is_third)


def _signs(statement: Statement, frozen: ThesisModes, basis: Basis) -> Conclusion:
    fast = [mode for mode, share in enumerate(frozen.alternating, start=1) if share >= MOSTLY]
    holds = frozen.alike[0] >= MOSTLY and bool(fast)
    against = ", ".join(f"mode {mode} at {percent(share, '.0f')}" for mode, share in enumerate(frozen.alternating, start=1))
    text = f"Strains 1 and 3 against strain 2: {against} of the crank angles. All three alike: mode 1 at {percent(frozen.alike[0], '.0f')}."
    text += f" The signs are those of mode {' and '.join(map(str, fast))}." if holds else ""
    return Conclusion(statement, HOLDS if holds else NOT, text, inference=holds)


def _depends(statement: Statement, basis: Basis) -> Conclusion:
    groups: dict[str, dict[float, list[tuple[float, float]]]] = {"crank length": {}, "tip mass": {}}
    for result in thesis_runs(basis.results).values():
        run, mechanism = result.runs.get(REFERENCE), result.case.mechanism
        mean = run.consensus_frequency("pre") if run is not None and run.usable else None
        if mean is not None and mechanism.tip is not None:
            length, mass = mechanism.crank.length, mechanism.tip.mass
            groups["crank length"].setdefault(mass, []).append((length, mean))
            groups["tip mass"].setdefault(length, []).append((mass, mean))
    changes = {name: change for name, group in groups.items() if (change := _largest_change(group)) is not None}
    if len(changes) < len(groups):
        return Conclusion(statement, UNCHECKABLE, "The cases shown do not vary crank length and tip mass one at a time.")
    alone = "; ".join(f"{name} alone: up to {percent(change, '.0f')}" for name, change in changes.items())
    text = f"Reference, mean first-mode frequency before the return: {alone}."
    return Conclusion(statement, HOLDS if min(changes.values()) > DEPENDS else NOT, text)


def _largest_change(groups: Mapping[float, list[tuple[float, float]]]) -> float | None:
    """Largest ratio minus one of frequencies within a group; its members differ in the first of each pair."""
    spreads = [max(f for _, f in pairs) / min(f for _, f in pairs) - 1.0 for pairs in groups.values() if len({x for x, _ in pairs}) > 1]
    return max(spreads) if spreads else None


def _post_excess(statement: Statement, basis: Basis) -> Conclusion:
    """The reference in the place of the experiment: whether the single cubic alone could make the halves differ as the words say."""
    if basis.measured.get(statement.quantity):
        return _relation(statement, basis)
    excess = _excess(basis.results)
    short = {engine: summary_of(list(post_over_pre(basis.results, engine).values())) for engine in (MODEL, REFERENCE)}
    halves = {engine: ratios for engine, ratios in short.items() if ratios}
    over = summary_of(list(excess.values()))
    if over is None:
        text = "No run shown is resolved in both halves by both the single cubic and the reference."
        return Conclusion(statement, UNCHECKABLE, text)
    differs = statement.holds(excess)
    engines = "; ".join(f"{engine} {_median(ratios)}" for engine, ratios in halves.items())
    required = f"the words require {_limits(statement)} in {percent(statement.share, '.0f')} of the runs."
    lost, alike = "The measured waveforms that would decide are lost.", "The single cubic is too stiff in both halves alike."
    text = (
        f"First-mode frequency after / before the return: {engines}. Excess of the single cubic over the reference, after / before:"
        f" {_median(over)}; {required} {lost if differs else alike}"
    )
    return Conclusion(statement, UNCHECKABLE if differs else CANNOT_FOLLOW, text)


def _excess(results: Sequence[CaseResult]) -> dict[int, float]:
    """Run -> single cubic over reference after the return, over the same before it; each over the channels that both resolve."""
    excess = {}
    for run_number, result in thesis_runs(results).items():
        ratios = [[difference.ratio for difference in differences([result], MODEL, "frequency", half=half)] for half in HALVES]
        if all(ratios):
            excess[run_number] = ratios[1][0] / ratios[0][0]
    return excess


def _joint(statement: Statement, basis: Basis) -> Conclusion:
    """What is softer than expected, by the study: a spring, which affects both halves, or the one roller that carries after the return."""
    own = [row for row in basis.finding if row.engine == REFERENCE]
    linear, one_sided = ([row for row in own if row.effect == effect] for effect in ("linear", "post-side"))
    if not linear or not one_sided:
        return Conclusion(statement, UNCHECKABLE, "The study of effects that could make the halves differ is missing.")
    lowers = any(row.tells_halves_apart and (row.apart or 0.0) < 0.0 for row in one_sided)
    splits = lowers and not any(row.tells_halves_apart for row in linear)
    middle = len(linear) // 2
    both_sides, one_side = (_change(rows[middle].apart) for rows in (linear, one_sided))
    lost = "So if it is the joint, it must be one side of it; the measured waveforms that would decide are lost."
    text = (
        f"With {linear[middle].strength} a softness of both sides changes the frequency after the return over that before it by"
        f" {both_sides} in the median, a softness of the roller that carries after the return by {one_side}."
        f" {lost if splits else 'Neither makes the halves differ.'}"
    )
    return Conclusion(statement, UNCHECKABLE if splits else CANNOT_FOLLOW, text, inference=splits)


def _two_modes(statement: Statement, basis: Basis) -> Conclusion:
    frequencies, frozen = [difference.ratio for difference in differences(basis.results, MODEL, "frequency")], basis.thesis_modes
    ratios, inside = summary_of(frequencies), [ACCURATE[0] <= ratio <= ACCURATE[1] for ratio in frequencies]
    if ratios is None:
        text = "No half cycle of the runs shown is resolved by both the single cubic and the reference."
        return Conclusion(statement, UNCHECKABLE, text)
    text = (
        f"First-mode frequency of the single cubic over the converged one: median {number(ratios.median, '.3f')},"
        f" {span(ratios.lowest, ratios.highest, '.3f')} in {ratios.count} half cycles."
    )
    if frozen is not None:
        ranges = f"{_range(frozen.cubic[1], '.0f')} against {_range(frozen.converged[1], '.0f')}"
        text += f" Second mode with the crank held, run {statement.runs[-1]}: {ranges}."
    return Conclusion(statement, HOLDS if all(inside) else IN_PART if any(inside) else NOT, text)


def _more_elements(statement: Statement, frozen: ThesisModes, basis: Basis) -> Conclusion:
    """Whether more elements of the same kind are a way to a better response."""
    falls = all(finer < FALLS * coarser for coarser, finer in pairwise(frozen.elements))
    excess = ", ".join(f"{elements}: {size(share)}" for elements, share in zip(ELEMENTS, frozen.elements, strict=True))
    text = (
        "The model of the engine thesis takes more cubic elements as a setting. Largest excess of the first frequency over the converged"
        f" one, crank held, by number of elements: {excess}."
    )
    return Conclusion(statement, HOLDS if falls else NOT, text)


def _change(share: float | None) -> str:
    return "an unknown part" if share is None else percent(share, "+.1f")


def _range(mode: Span, form: str) -> str:
    return f"{span(mode.low, mode.high, form)} Hz"


def _limits(statement: Statement) -> str:
    """The ratios that a statement means."""
    if math.isinf(statement.high):
        return f"at least {statement.low:g}"
    return f"at most {statement.high:g}" if math.isinf(statement.low) else f"{statement.low:g} to {statement.high:g}"


def _median(ratios: Summary) -> str:
    return f"median {number(ratios.median, '.3f')} ({span(ratios.lowest, ratios.highest, '.3f')}, {ratios.count} runs)"


_RULES: Final[Mapping[str, Callable[[Statement, Basis], Conclusion]]] = {
    "frequency-depends-on-crank": _depends,
    "joint-cause": _joint,
    "post-excess": _post_excess,
    "two-modes": _two_modes,
}
#: Statements that need the thesis' example run with its crank held.
_CRANK_HELD: Final[Mapping[str, Callable[[Statement, ThesisModes, Basis], Conclusion]]] = {
    "first-mode-range": _first_mode,
    "second-mode": _second_mode,
    "second-mode-signs": _signs,
    "more-elements": _more_elements,
}
