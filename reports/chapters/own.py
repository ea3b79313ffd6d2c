"""The user's own machine: whether it holds, what happens in a turn, and what to do next."""

import shlex
from collections.abc import Sequence
from typing import Final

from quickreturn.cases.loads import HARDLY, Loads
from quickreturn.reports.page.chapter import Chapter
from quickreturn.reports.page.content import Content
from quickreturn.reports.results.loads import CaseLoads, Load, from_p, name_of, numbers_of_case
from quickreturn.reports.results.turn import leading_statements
from quickreturn.reports.tables.cells import CASE
from quickreturn.reports.tables.table import Cell, Column, ColumnList, Table
from quickreturn.reports.words import counted, listed, off_by, quantity, size, span

#: Topics of a turn that no table of the page shows.
TOPICS: Final = ("sides", "limit", "trust")


def strength(content: Content) -> Chapter | None:
    """The chapter; None for a report on the thesis' runs, or if no engine gives the stress."""
    cases = [case for case in content.loads if case.lead]
    if not cases:
        return None
    sections = [{"title": each.case.title, "verdict": each.verdict, "lacking": lacking(each.loads[each.lead])} for each in cases]
    facts = {"sections": sections, "table": strength_table(content.loads)}
    return Chapter("strength", "Will it hold?", strength_finding(cases), facts)


def strength_finding(cases: Sequence[CaseLoads]) -> str:
    """The largest stress in the first case, the least safety factor, and the distance to resonance, as far as they are known."""
    case = cases[0]
    loads, resonance, units = case.loads[case.lead], case.resonance, case.case.units
    assert loads.stress is not None
    stress = loads.stress.largest
    text = f"{quantity(stress.value, units.of('Pa'))} at {from_p(stress, units)}"
    for against, factor in loads.factors[:1]:
        text += f", safety {factor.text} against {against}"
    if resonance and not (case.share is not None and case.share < HARDLY):
        text += f"; harmonic {resonance.harmonic} is {size(resonance.detuning)} from resonance"
    return f"{case.case.name}: {text}" if len(cases) > 1 else text


def lacking(loads: Loads) -> tuple[str, list[str]]:
    """The safety factors that are not known, as a clause, and the keys of `[follower]` that give them; no keys if both are known."""
    factors = {"yield_strength": ("yielding", loads.yield_factor), "fatigue_strength": ("fatigue", loads.fatigue_factor)}
    missing = {key: against for key, (against, factor) in factors.items() if factor is None}
    return "No safety factor" if len(missing) > 1 else f"No factor against {''.join(missing.values())}", [*missing]


def strength_table(cases: Sequence[CaseLoads]) -> Table:
    """All numbers of all cases."""
    units = cases[0].case.units
    columns: ColumnList = (
        *(CASE, "engine", Column("quantity", words=name_of)),
        Column("value", unit="[SI]", form=".4g"),
        Column("error", "off by", unit="[SI]", form=".2g", meaning="by the spacing of rows and places, and the engine's own estimate"),
        Column("unit", in_page=False),
        Column("place", "from P", "m", ".0f", meaning="arc length").shown_in(units),
        Column("crank_angle", "crank at", "°", ".0f"),
        Column("lowest", in_page=False),
        Column("highest", in_page=False),
    )
    table = Table(
        "strength",
        """Loads on the parts in a steady cycle, as each engine computes them: largest value, its error, and its place. Stress: at the
        surface of the arm by bending and the normal force, which is positive where it pulls; amplitude: half of the range of stress at a
        place in a cycle, with its mean; equivalent amplitude: of the fully reversed stress that is as bad, with notch factor and mean;
        safety: yield strength over the largest stress, fatigue strength over the equivalent amplitude. The first mode is that of the arm
        with the crank held.""",
        columns,
    )
    for case in cases:
        for engine, load in numbers_of_case(case):
            value = Cell(load.value, load.text(units))
            table.add(load, case=case.case.name, engine=engine, value=value, error=Cell(load.error, _off(load)))
    return table


def _off(load: Load) -> str:
    """The error in words; of a safety factor its interval, which is not even about the value."""
    if load.lowest is not None:
        if load.highest is None:
            return f"{load.lowest:.3g} or more"
        ends = span(load.lowest, load.highest, ".3g")
        return off_by(load.highest - load.value, load.value) if len({*ends.split(" to ")}) == 1 else ends
    return "" if load.error is None else off_by(load.error, load.value)


def turn(content: Content) -> Chapter | None:
    """What happens in a turn; None for a report on the thesis' runs, or without a settled turn."""
    results = content.results if content.is_own else []
    cases = [(result.case.title, found) for result in results if (found := leading_statements(result))]
    if not cases:
        return None
    sentences = [(title, [each.sentence for each in found if each.topic in TOPICS]) for title, found in cases]
    return Chapter("turn", "What happens in a turn", cases[0][1][0].sentence.removesuffix("."), {"cases": sentences})


def next_steps(content: Content) -> Chapter | None:
    """What to do next; None where the report is not about the user's own machines."""
    if not content.is_own:
        return None
    case = content.results[0].case
    failures = [f"{result.case.name}, {run.engine}: {run.remark or run.status}" for result in content.results for run in result.failures]
    departing = [result.case.name for result in content.results if result.missed]
    facts = {
        "file": shlex.quote(case.source if case.source not in ("", "library") else case.name),
        "shorter": case.units.of("m").text(0.9 * case.mechanism.crank.length),
        "failures": failures,
        "departing": departing,
    }
    return Chapter("next", "What to do next", next_finding(len(failures), departing), facts)


def next_finding(failures: int, departing: Sequence[str]) -> str:
    """The number of simulations that failed, or the cases in which engines disagree, or what can be done."""
    if failures:
        return f"{counted(failures, 'simulation')} did not deliver"
    return f"Engines disagree in {listed(departing)}" if departing else "Change a value, measure the cost, take the data"
