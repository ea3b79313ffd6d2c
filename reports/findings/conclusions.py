"""What becomes of each of the thesis' statements: it holds, it cannot follow from the model, or it cannot be checked."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Final

import numpy as np

from cases.experiment import Statement, statements
from cases.frozen_crank import ELEMENTS, FrozenCrank
from cases.runs.comparison import HALVES, REFERENCE, CaseResult
from reports.findings.agreement import differences
from reports.findings.runs import of_run, thesis_runs
from reports.words import listed, number, percent, size, span

HOLDS: Final = "holds"
IN_PART: Final = "holds in part"
NOT: Final = "does not hold"
CANNOT_FOLLOW: Final = "cannot follow from the model"
UNCHECKABLE: Final = "cannot be checked"

MODEL: Final = "thesis"
#: "Accurate", said of a frequency, is read as: within these ratios to the converged one.
ACCURATE: Final = (0.97, 1.05)
#: An effect that differs between the halves by less than this part of itself is the same in both.
ALIKE: Final = 0.1
#: Another element helps if it brings the error below this part of what it was.
FALLS: Final = 0.5
#: A mode has a pattern of signs if it shows it at this share of the crank angles.
MOSTLY: Final = 0.9
#: Frequencies that differ by more than this depend on what was changed; three times what the measure itself may be off by in a strong run.
DEPENDS: Final = 0.015


@dataclass(frozen=True)
class Conclusion:
    """A statement, what becomes of it, and the numbers that decide; `inference` marks a reading that the numbers allow but do not prove."""

    statement: Statement
    outcome: str
    numbers: str
    inference: bool = False


@dataclass(frozen=True)
class Basis:
    """What conclusions are drawn from.

    Attributes:
        results: cases shown.
        frozen_crank: on the run that the thesis shows as its example; None if that run is not among the cases.
        measured: quantity of a statement -> run -> ratio simulation / experiment; empty as long as no measured waveform exists.
    """

    results: Sequence[CaseResult]
    frozen_crank: FrozenCrank | None
    measured: Mapping[str, Mapping[int, float]] = field(default_factory=dict)


def conclusions(basis: Basis) -> list[Conclusion]:
    """One per statement, in the order of the thesis."""
    return [_RULES.get(statement.id, _relation)(statement, basis) for statement in statements()]


def post_over_pre(results: Sequence[CaseResult], engine: str) -> dict[int, float]:
    """Run -> first-mode frequency after the return over that before it, where both are resolvable."""
    found = {}
    for number_of_run, result in thesis_runs(results).items():
        run = result.runs.get(engine)
        pair = tuple(run.consensus_frequency(half) for half in HALVES) if run is not None and run.usable else (None, None)
        if pair[0] is not None and pair[1] is not None:
            found[number_of_run] = pair[1] / pair[0]
    return found


def _relation(statement: Statement, basis: Basis) -> Conclusion:
    """A ratio simulation / experiment, which takes a measured waveform."""
    values = basis.measured.get(statement.quantity, {})
    share = statement.share_of(values)
    if share is None:
        return Conclusion(statement, UNCHECKABLE, "It compares with measured waveforms, and none survives.")
    counted = sum(run in values for run in statement.runs)
    numbers = (
        f"{percent(share, '.0f')} of the {counted} runs with measured curves show a ratio of {_limits(statement)};"
        f" the words ask for {percent(statement.share, '.0f')}."
    )
    return Conclusion(statement, HOLDS if statement.holds(values) else NOT, numbers)


def _first_mode(statement: Statement, basis: Basis) -> Conclusion:
    if basis.frozen_crank is None:
        return _not_shown(statement)
    found = basis.frozen_crank.converged[0]
    overlap = max(0.0, min(found.high, statement.high) - max(found.low, statement.low)) / (statement.high - statement.low)
    outcome = HOLDS if overlap == 1.0 else IN_PART if overlap > 0.0 else NOT
    place = "lies within" if overlap == 1.0 else "overlaps the upper part of" if found.low < statement.low else "overlaps"
    run = of_run(basis.results, statement.runs[0])
    reference = run.runs.get(REFERENCE) if run else None
    means = [reference.consensus_frequency(half) for half in HALVES] if reference is not None and reference.usable else []
    told = listed([f"{number(mean, '.1f')} Hz" for mean in means if mean is not None])
    numbers = (
        f"With the crank held, the converged first mode runs from {span(found.low, found.high, '.1f')} Hz over the crank angle;"
        f" the printed range {place} this."
        + (f" Its time mean in the simulated cycle is {told}, before and after the return." if told else "")
        + " The measured waveform itself is lost."
    )
    return Conclusion(statement, outcome, numbers)


def _second_mode(statement: Statement, basis: Basis) -> Conclusion:
    if basis.frozen_crank is None:
        return _not_shown(statement)
    second, third = basis.frozen_crank.converged[1:3]
    numbers = (
        f"With the crank held, the second converged mode lies at {span(second.low, second.high, '.0f')} Hz, the third at"
        f" {span(third.low, third.high, '.0f')} Hz, the single cubic's second at"
        f" {span(basis.frozen_crank.cubic[1].low, basis.frozen_crank.cubic[1].high, '.0f')} Hz."
    )
    if second.holds(statement.low):
        return Conclusion(statement, HOLDS, numbers)
    if third.holds(statement.low):
        return Conclusion(statement, NOT, f"{numbers} {statement.low:g} Hz is the third mode, not the second.", inference=True)
    return Conclusion(statement, NOT, numbers)


def _signs(statement: Statement, basis: Basis) -> Conclusion:
    if basis.frozen_crank is None:
        return _not_shown(statement)
    alternating, alike = basis.frozen_crank.alternating, basis.frozen_crank.alike
    fast = [str(mode + 1) for mode, share in enumerate(alternating) if share >= MOSTLY]
    numbers = (
        "Strains 1 and 3 against strain 2: mode "
        + ", mode ".join(f"{mode + 1} at {percent(share, '.0f')}" for mode, share in enumerate(alternating))
        + f" of the crank angles. All three alike: mode 1 at {percent(alike[0], '.0f')}."
    )
    if alike[0] >= MOSTLY and fast:
        return Conclusion(statement, HOLDS, f"{numbers} The signs are those of mode {' and '.join(fast)}.", inference=True)
    return Conclusion(statement, NOT, numbers)


def _depends(statement: Statement, basis: Basis) -> Conclusion:
    groups: dict[str, dict[float, list[tuple[float, float]]]] = {"crank length": {}, "tip mass": {}}
    for result in thesis_runs(basis.results).values():
        run, mechanism = result.runs.get(REFERENCE), result.case.mechanism
        mean = run.consensus_frequency("pre") if run is not None and run.usable else None
        if mean is not None and mechanism.tip is not None:
            length, mass = mechanism.crank.length, mechanism.tip.mass
            groups["crank length"].setdefault(mass, []).append((length, mean))
            groups["tip mass"].setdefault(length, []).append((mass, mean))
    changes = {name: _largest_change(group) for name, group in groups.items()}
    if None in changes.values():
        return Conclusion(statement, UNCHECKABLE, "The cases shown do not vary crank length and tip mass one at a time.")
    numbers = "; ".join(f"{name} alone: up to {percent(change or 0.0, '.0f')}" for name, change in changes.items())
    holds = all(change is not None and change > DEPENDS for change in changes.values())
    return Conclusion(statement, HOLDS if holds else NOT, f"Reference, mean first-mode frequency before the return: {numbers}.")


def _largest_change(groups: Mapping[float, list[tuple[float, float]]]) -> float | None:
    """Largest ratio less one of frequencies within a group, whose members differ in the first of each pair."""
    spreads = [max(f for _, f in pairs) / min(f for _, f in pairs) - 1.0 for pairs in groups.values() if len({x for x, _ in pairs}) > 1]
    return max(spreads) if spreads else None


def _post_excess(statement: Statement, basis: Basis) -> Conclusion:
    """The reference in the place of the experiment: whether the single cubic alone could make the halves differ as the words say."""
    if basis.measured.get(statement.quantity):
        return _relation(statement, basis)
    halves = {engine: post_over_pre(basis.results, engine) for engine in (MODEL, REFERENCE)}
    excess = _excess(basis.results)
    if not excess:
        return Conclusion(statement, UNCHECKABLE, "No run shown is resolved in both halves by both the single cubic and the reference.")
    told = [f"{engine} {_median_and_range(list(ratios.values()))}" for engine, ratios in halves.items() if ratios]
    numbers = (
        f"First-mode frequency after / before the return: {'; '.join(told)}. Excess of the single cubic over the reference, after / before:"
        f" {_median_and_range(list(excess.values()))}; the words: {_limits(statement)} in {percent(statement.share, '.0f')} of the runs."
    )
    if not statement.holds(excess):
        return Conclusion(statement, CANNOT_FOLLOW, f"{numbers} The single cubic is too stiff in both halves alike.")
    return Conclusion(statement, UNCHECKABLE, f"{numbers} The measured waveforms that would decide are lost.")


def _excess(results: Sequence[CaseResult]) -> dict[int, float]:
    """Run -> single cubic over reference after the return, over the same before it; each over the channels that both resolve."""
    found = {}
    for number_of_run, result in thesis_runs(results).items():
        ratios = [[difference.ratio for difference in differences([result], MODEL, "frequency", half=half)] for half in HALVES]
        if all(ratios):
            found[number_of_run] = ratios[1][0] / ratios[0][0]
    return found


def _median_and_range(ratios: Sequence[float]) -> str:
    return f"median {number(float(np.median(ratios)), '.3f')} ({span(min(ratios), max(ratios), '.3f')}, {len(ratios)} runs)"


def _joint(statement: Statement, basis: Basis) -> Conclusion:
    effects = [effect for effect in basis.frozen_crank.joints if effect.change_pre < 0.0] if basis.frozen_crank else []
    if not effects:
        return _not_shown(statement)
    effect = min(effects, key=lambda found: found.stiffness)
    alike = abs(effect.change_post - effect.change_pre) < ALIKE * abs(effect.change_pre)
    numbers = (
        f"A linearly soft joint of {number(effect.stiffness / 1e3, '.3g')} kN/m lowers the first mode of run {statement.runs[-1]} by"
        f" {percent(-effect.change_pre, '.2f')} before and {percent(-effect.change_post, '.2f')} after the return."
    )
    if alike:
        return Conclusion(statement, CANNOT_FOLLOW, f"{numbers} It lowers both halves alike and cannot make them differ.", inference=True)
    return Conclusion(statement, UNCHECKABLE, f"{numbers} It could make the halves differ.")


def _two_modes(statement: Statement, basis: Basis) -> Conclusion:
    ratios = [found.ratio for found in differences(basis.results, MODEL, "frequency")]
    if not ratios:
        return Conclusion(statement, UNCHECKABLE, "No half cycle of the runs shown is resolved by both the single cubic and the reference.")
    numbers = (
        f"First-mode frequency of the single cubic over the converged one: median {number(float(np.median(ratios)), '.3f')},"
        f" {span(min(ratios), max(ratios), '.3f')} in {len(ratios)} half cycles."
    )
    if basis.frozen_crank is not None:
        second = [f"{span(found.low, found.high, '.0f')} Hz" for found in (basis.frozen_crank.cubic[1], basis.frozen_crank.converged[1])]
        numbers += f" Second mode with the crank held, run {statement.runs[-1]}: {second[0]} against {second[1]}."
    inside = [ACCURATE[0] <= ratio <= ACCURATE[1] for ratio in ratios]
    outcome = HOLDS if all(inside) else IN_PART if any(inside) else NOT
    return Conclusion(statement, outcome, numbers)


def _more_elements(statement: Statement, basis: Basis) -> Conclusion:
    """Whether more elements of the same kind are a way to a better response."""
    if basis.frozen_crank is None:
        return _not_shown(statement)
    excess = basis.frozen_crank.elements
    told = ", ".join(f"{elements}: {size(share)}" for elements, share in zip(ELEMENTS, excess, strict=True))
    numbers = (
        "The model of the engine thesis takes more cubic elements as a setting. Largest excess of the first frequency over the converged"
        f" one, crank held, by number of elements: {told}."
    )
    falls = all(finer < FALLS * coarser for coarser, finer in pairwise(excess))
    return Conclusion(statement, HOLDS if falls else NOT, numbers)


def _not_shown(statement: Statement) -> Conclusion:
    return Conclusion(statement, UNCHECKABLE, f"Run {statement.runs[-1]} is not among the cases shown, or its reference did not settle.")


def _limits(statement: Statement) -> str:
    if np.isinf(statement.high):
        return f"at least {statement.low:g}"
    return f"at most {statement.high:g}" if np.isinf(statement.low) else f"{statement.low:g} to {statement.high:g}"


_RULES: Final[Mapping[str, Callable[[Statement, Basis], Conclusion]]] = {
    "first-mode-range": _first_mode,
    "second-mode": _second_mode,
    "second-mode-signs": _signs,
    "frequency-depends-on-crank": _depends,
    "post-excess": _post_excess,
    "joint-cause": _joint,
    "two-modes": _two_modes,
    "more-elements": _more_elements,
}
