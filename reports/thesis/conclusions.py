"""The verdict on each of the thesis' statements: it holds, it cannot follow from the model, or it cannot be checked."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from itertools import pairwise
from typing import Any, Final

from quickreturn.cases.measures.cycle import HALVES
from quickreturn.cases.runs.comparison import REFERENCE, CaseResult
from quickreturn.cases.thesis.experiment import Statement, statements
from quickreturn.cases.thesis.finding.study import Row
from quickreturn.cases.thesis.modes import ELEMENTS, ThesisModes
from quickreturn.engines.registry import MODEL
from quickreturn.reports.findings.agreement import differences, summary_of
from quickreturn.reports.templates import environment
from quickreturn.reports.thesis.runs import thesis_runs

HOLDS: Final = "holds"
IN_PART: Final = "holds in part"
NOT: Final = "does not hold"
CANNOT_FOLLOW: Final = "cannot follow from the model"
UNCHECKABLE: Final = "cannot be checked"
OUTCOMES: Final = (HOLDS, IN_PART, NOT, CANNOT_FOLLOW, UNCHECKABLE)

#: Ratios to the converged frequency within which a frequency counts as "accurate".
ACCURATE: Final = (0.97, 1.05)
#: An effect counts as the same in both halves if it differs between them by less than this part of itself.
ALIKE: Final = 0.1
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
    for number, result in thesis_runs(results).items():
        run = result.runs.get(engine)
        pair = tuple(run.consensus_frequency(half) for half in HALVES) if run is not None and run.usable else (None, None)
        if pair[0] is not None and pair[1] is not None:
            ratios[number] = pair[1] / pair[0]
    return ratios


def _conclusion(statement: Statement, basis: Basis) -> Conclusion:
    if statement.id not in _CRANK_HELD:
        return _RULES.get(statement.id, _relation)(statement, basis)
    frozen = basis.thesis_modes
    return _conclude("not_shown", statement, UNCHECKABLE) if frozen is None else _CRANK_HELD[statement.id](statement, frozen, basis)


@cache
def _sentences() -> Any:
    return environment(escaped=False, packages=("quickreturn.reports.thesis",)).get_template("conclusions.jinja").module


def _conclude(macro: str, statement: Statement, outcome: str, inference: bool = False, **facts: Any) -> Conclusion:
    """A conclusion whose `numbers` a macro of `templates/conclusions.jinja` writes from the facts."""
    text = getattr(_sentences(), macro)(facts | {"statement": statement})
    return Conclusion(statement, outcome, text.strip().replace("\n", " "), inference)


def _relation(statement: Statement, basis: Basis) -> Conclusion:
    """A statement on the ratio simulation / experiment, which needs a measured waveform."""
    values = basis.measured.get(statement.quantity, {})
    share = statement.share_of(values)
    outcome = UNCHECKABLE if share is None else HOLDS if statement.holds(values) else NOT
    return _conclude("relation", statement, outcome, share=share, counted=sum(run in values for run in statement.runs))


def _first_mode(statement: Statement, frozen: ThesisModes, basis: Basis) -> Conclusion:
    first = frozen.converged[0]
    overlap = max(0.0, min(first.high, statement.high) - max(first.low, statement.low)) / (statement.high - statement.low)
    outcome = HOLDS if overlap == 1.0 else IN_PART if overlap > 0.0 else NOT
    run = thesis_runs(basis.results).get(statement.runs[0])
    reference = run.runs.get(REFERENCE) if run else None
    means = [reference.consensus_frequency(half) for half in HALVES] if reference is not None and reference.usable else []
    return _conclude("first_mode", statement, outcome, first=first, overlap=overlap, means=[mean for mean in means if mean is not None])


def _second_mode(statement: Statement, frozen: ThesisModes, basis: Basis) -> Conclusion:
    second, third = frozen.converged[1:3]
    holds = second.holds(statement.low)
    is_third = not holds and third.holds(statement.low)
    facts = {"second": second, "third": third, "cubic": frozen.cubic[1], "is_third": is_third}
    return _conclude("second_mode", statement, HOLDS if holds else NOT, inference=is_third, **facts)


def _signs(statement: Statement, frozen: ThesisModes, basis: Basis) -> Conclusion:
    fast = [mode for mode, share in enumerate(frozen.alternating, start=1) if share >= MOSTLY]
    holds = frozen.alike[0] >= MOSTLY and bool(fast)
    facts = {"alternating": frozen.alternating, "alike": frozen.alike[0], "modes": fast if holds else ()}
    return _conclude("signs", statement, HOLDS if holds else NOT, inference=holds, **facts)


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
        return _conclude("depends", statement, UNCHECKABLE, changes=None)
    return _conclude("depends", statement, HOLDS if min(changes.values()) > DEPENDS else NOT, changes=changes)


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
    differs = statement.holds(excess)
    outcome = CANNOT_FOLLOW if excess and not differs else UNCHECKABLE
    return _conclude("post_excess", statement, outcome, excess=summary_of(list(excess.values())), halves=halves, differs=differs)


def _excess(results: Sequence[CaseResult]) -> dict[int, float]:
    """Run -> single cubic over reference after the return, over the same before it; each over the channels that both resolve."""
    excess = {}
    for number, result in thesis_runs(results).items():
        ratios = [[difference.ratio for difference in differences([result], MODEL, "frequency", half=half)] for half in HALVES]
        if all(ratios):
            excess[number] = ratios[1][0] / ratios[0][0]
    return excess


def _joint(statement: Statement, basis: Basis) -> Conclusion:
    """What is softer than expected, by the study: a spring, which affects both halves, or the one roller that carries after the return."""
    own = [row for row in basis.finding if row.engine == REFERENCE]
    linear, one_sided = ([row for row in own if row.effect == effect] for effect in ("linear", "post-side"))
    if not linear or not one_sided:
        return _conclude("not_recorded", statement, UNCHECKABLE)
    lowers = any(row.tells_halves_apart and (row.apart or 0.0) < 0.0 for row in one_sided)
    splits = lowers and not any(row.tells_halves_apart for row in linear)
    outcome, middle = UNCHECKABLE if splits else CANNOT_FOLLOW, len(linear) // 2
    facts = {"linear": linear[middle].apart, "one_sided": one_sided[middle].apart, "strength": linear[middle].strength}
    return _conclude("joint", statement, outcome, inference=splits, splits=splits, **facts)


def _two_modes(statement: Statement, basis: Basis) -> Conclusion:
    ratios = [difference.ratio for difference in differences(basis.results, MODEL, "frequency")]
    inside = [ACCURATE[0] <= ratio <= ACCURATE[1] for ratio in ratios]
    outcome = UNCHECKABLE if not ratios else HOLDS if all(inside) else IN_PART if any(inside) else NOT
    return _conclude("two_modes", statement, outcome, ratios=summary_of(ratios), frozen=basis.thesis_modes)


def _more_elements(statement: Statement, frozen: ThesisModes, basis: Basis) -> Conclusion:
    """Whether more elements of the same kind are a way to a better response."""
    falls = all(finer < FALLS * coarser for coarser, finer in pairwise(frozen.elements))
    return _conclude("more_elements", statement, HOLDS if falls else NOT, excess=dict(zip(ELEMENTS, frozen.elements, strict=True)))


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
