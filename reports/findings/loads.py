"""Loads on the parts of a machine, by each engine on each case, and by the leading engine."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

from quickreturn.cases.case import Case
from quickreturn.cases.loads import Loads, Resonance, loads_of_run, resonance, shift_of_motion
from quickreturn.cases.units import in_si
from quickreturn.reports.words import degrees, off_by, quantity

if TYPE_CHECKING:
    from quickreturn.cases.runs.comparison import CaseResult


@dataclass(frozen=True)
class CaseLoads:
    """The loads of a case by each engine."""

    case: Case
    loads: dict[str, Loads]  # by engine, for those with a usable cycle
    models: frozenset[str] = frozenset()  # engines whose discretization is their model: a difference is not an error of theirs

    @property
    def lead(self) -> str:
        """The engine whose numbers are shown: `reference`, or else the first that gives a stress; "" if none does, or if it is zero."""
        from quickreturn.cases.runs.comparison import REFERENCE  # the loads of a single trajectory need no comparison

        stressed = [name for name, found in self.loads.items() if found.stress is not None and found.stress.largest.value > 0.0]
        return REFERENCE if REFERENCE in stressed else next(iter(stressed), "")

    @cached_property
    def resonance(self) -> Resonance | None:
        """First mode and crank."""
        return resonance(self.case.mechanism)

    @property
    def verdict(self) -> str:
        """Whether the arm holds, by the engine that leads (a sentence); "" where no strength is given."""
        return verdict(self.loads[self.lead])

    @cached_property
    def shift_of_motion(self) -> float:
        """Change of the mean first frequency, Hz, by the rotation of the crank, which frequencies with the crank held do not contain."""
        return abs(shift_of_motion(self.case.mechanism))

    def departures(self) -> dict[str, float]:
        """Largest stress by the other engines with the same model, over that by the leading engine, minus one."""
        same = {name: found for name, found in self.loads.items() if name not in self.models}
        stress = {name: found.stress.largest.value for name, found in same.items() if found.stress is not None}
        lead = stress.pop(self.lead, 0.0)
        return {name: value / lead - 1.0 for name, value in stress.items()} if lead else {}


def loads_of_case(result: "CaseResult") -> CaseLoads:
    """The loads of a case by each engine; recorded tables are left out, because they may lack the moments."""
    mechanism = result.case.mechanism
    found = {name: loads for name, run in result.runs.items() if (loads := loads_of_run(mechanism, run)) is not None}
    return CaseLoads(result.case, found, frozenset(name for name, run in result.runs.items() if run.estimate_of == "integration"))


def leading_loads(result: "CaseResult") -> CaseLoads:
    """The loads of a case by the leading engine alone."""
    from quickreturn.cases.runs.comparison import REFERENCE

    mechanism, names = result.case.mechanism, sorted(result.runs, key=lambda name: name != REFERENCE)
    for name in names:
        loads = loads_of_run(mechanism, result.runs[name])
        if loads is not None and loads.stress is not None:
            return CaseLoads(result.case, {name: loads})
    return CaseLoads(result.case, {})


def loads_of_cases(results: "Sequence[CaseResult]") -> list[CaseLoads]:
    """The loads of several cases."""
    return [loads_of_case(result) for result in results]


def verdict(loads: Loads) -> str:
    """Whether the arm holds (a sentence); "" where no strength is given."""
    factors = {"yielding": loads.yield_factor, "fatigue": loads.fatigue_factor}
    known = {against: factor for against, factor in factors.items() if factor is not None}
    if not known:
        return ""
    told = " and ".join(f"{factor.value:.3g} against {against}" for against, factor in known.items())
    broken = any(factor.value + (factor.error or 0.0) < 1.0 for factor in known.values())
    close = any(abs(factor.value - 1.0) <= (factor.error or 0.0) for factor in known.values())
    begin = "The arm does not hold" if broken else "Whether the arm holds is too close to tell" if close else "The arm holds"
    below = ", below one" if broken and len(known) == 1 else ""
    return f"{begin}: the safety factor is {told}{below}."


def stress_text(loads: Loads, length: float) -> str:
    """The largest stress and where it is, and whether the arm holds, in a line; `length` is the arm's, m. There must be a stress."""
    assert loads.stress is not None
    found, places = loads.stress.largest, []
    if found.place is not None:
        places.append(f"{found.place / in_si('mm'):.0f} mm from P ({100.0 * found.place / length:.0f} % of the arm)")
    if found.crank_angle is not None:
        places.append(f"crank at {degrees(found.crank_angle)}")
    error = "" if found.error is None else f" ({off_by(found.error, found.value)})"
    largest = f"largest stress {quantity(found.value, 'MPa')}{error}, {', '.join(places)}"
    return f"{largest}. {told.removesuffix('.')}" if (told := verdict(loads)) else largest
