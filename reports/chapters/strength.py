"""Will it hold? The loads on the parts of the user's own machine, by each engine."""

from collections.abc import Sequence
from typing import Final

from quickreturn.cases.loads import HARDLY, Loads
from quickreturn.cases.shown import Units
from quickreturn.reports.page.chapter import Chapter
from quickreturn.reports.page.content import Content
from quickreturn.reports.page.part import nearness_of
from quickreturn.reports.results.loads import STRAIN, CaseLoads, Load, axial_words, from_p, name_of, notch_lines, numbers_of_case
from quickreturn.reports.tables.cells import CASE
from quickreturn.reports.tables.table import Cell, Column, ColumnList, Table
from quickreturn.reports.words import counted, degrees, listed, number, off_by, quantity, size, span

#: Number of ranges of counted cycles that are given.
SHOWN: Final = 3


def strength(content: Content) -> Chapter | None:
    """The chapter; None for a report on the thesis' runs, or if no engine gives the stress."""
    cases = [case for case in content.loads if case.lead]
    if not cases:
        return None
    near = content.of(nearness_of)
    sections = [
        {
            "title": case.case.title,
            "stress": stress_sentences(case),
            "fatigue": fatigue_sentences(case),
            "lacking": lacking(case.loads[case.lead]),
            "mode": mode_sentences(case, near.get(case.case.name, "")),
        }
        for case in cases
    ]
    return Chapter(
        "strength",
        "Will it hold?",
        finding(cases),
        {"sections": sections, "table": strength_table(content.loads)},
    )


def finding(cases: Sequence[CaseLoads]) -> str:
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


def stress_sentences(case: CaseLoads) -> str:
    """Whether the arm holds, and where it is stressed most, by the leading engine."""
    loads, units = case.loads[case.lead], case.case.units
    assert loads.stress is not None
    assert loads.strain is not None
    stress, amplitude, mean = loads.stress.largest, loads.stress.amplitude, loads.stress.mean
    assert stress.crank_angle is not None
    strain = f" (a surface strain of {quantity(loads.strain.value, STRAIN)})" if loads.strain.value else ""
    axial = axial_words(loads.stress.axial, units)
    alone = "; the engine gives no normal force, so that this is bending alone" if not axial else f": {axial}"
    at_most, half_range = (quantity(each, units.of("Pa")) for each in (stress.value, amplitude.value))
    return (
        f"{case.verdict} By {case.lead}, the arm is stressed most {from_p(stress, units)}, with {at_most} when the crank stands at"
        f" {degrees(stress.crank_angle)}{strain}{alone}. The range of stress in a turn is widest {from_p(amplitude, units)}: an amplitude"
        f" of {half_range} about {_about(mean, amplitude.value, units)}."
    )


def _about(mean: float, amplitude: float, units: Units) -> str:
    return "zero" if abs(mean) < 0.005 * amplitude else f"a mean of {quantity(mean, units.of('Pa'))}"


def fatigue_sentences(case: CaseLoads) -> str:
    """What counts for fatigue, by the leading engine: the place, its notch, the mean stress, and the cycles of stress in a turn."""
    follower, stress, units = case.case.mechanism.follower, case.loads[case.lead].stress, case.case.units
    assert stress is not None
    fatigue, unit = stress.fatigue, units.of("Pa")
    place, cycles = from_p(fatigue.equivalent, units), len(fatigue.ranges)
    notch = f", where the notch factor is {fatigue.notch_factor:.3g}" if fatigue.notch_factor > 1.0 else ""
    nominal = f"an amplitude of {quantity(fatigue.amplitude, unit)} about {_about(fatigue.mean, fatigue.amplitude, units)}"
    told = f"For fatigue the arm is worst {place}{notch}: {nominal}"
    if fatigue.equivalent.value > 1.0001 * fatigue.amplitude:
        told += f" is as bad as a fully reversed one of {quantity(fatigue.equivalent.value, unit)}"
    ranges = [quantity(each, unit) for each in fatigue.ranges[:SHOWN]]
    if cycles > SHOWN:
        ranges.append(f"{cycles - SHOWN} smaller ones")
    told += f". A turn has {counted(cycles, 'cycle')} of stress there, with ranges of {listed(ranges)}."
    if follower.fatigue_strength is not None and follower.tensile_strength is None:
        told += " The mean stress does not count: that takes tensile_strength."
    return " ".join([told, *(f"{line[0].upper()}{line[1:]}." for line in notch_lines(case.loads[case.lead], case.case))])


def lacking(loads: Loads) -> tuple[str, list[str]]:
    """The safety factors that are not known, as a clause, and the keys of `[follower]` that give them; no keys if both are known."""
    factors = {"yield_strength": ("yielding", loads.yield_factor), "fatigue_strength": ("fatigue", loads.fatigue_factor)}
    missing = {key: against for key, (against, factor) in factors.items() if factor is None}
    return "No safety factor" if len(missing) > 1 else f"No factor against {''.join(missing.values())}", [*missing]


def mode_sentences(case: CaseLoads, nearness: str = "") -> str:
    """The first mode beside the crank's frequency; "" where there is no such mode; `nearness`: how near a resonance is."""
    resonance, units = case.resonance, case.case.units
    if resonance is None:
        return ""
    first, lowest, crank = (quantity(each, units.of("Hz")) for each in (resonance.first_mode, resonance.lowest, resonance.crank))
    return (
        f"The first mode, with the crank held, has {first} in the mean over the turn,"
        f" {number(resonance.ratio, '.2f')} times the crank’s {crank}. At a whole number that harmonic drives it."
        f" {nearness or case.resonance_sentence} The frequency changes over the turn, from {lowest} up, so a resonance is blunt. The"
        " rotation of the crank, and its compliance under a driving torque, change the mean by"
        f" {size(case.shift_of_motion / resonance.first_mode)}; this is taken as its error."
    )


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
