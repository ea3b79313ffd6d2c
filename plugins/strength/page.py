"""The page of a report on the user's own machines: the first screen, and the chapter on strength."""

import math
from collections.abc import Mapping, Sequence
from typing import Any, Final

import numpy as np
from markupsafe import Markup

from quickreturn.cases.files.shown import Units
from quickreturn.cases.motion.number import Number
from quickreturn.plugins.strength.case_loads import CaseLoads, loads_on, numbers_of_case
from quickreturn.plugins.strength.loads import UNITS
from quickreturn.plugins.strength.words import NAMES, Load, axial_words, from_p, name_of, verdict
from quickreturn.reports.page.chapter import Chapter
from quickreturn.reports.page.content import Content
from quickreturn.reports.page.first_screen import Figure, FirstScreen, accuracies_missed
from quickreturn.reports.page.part import Part
from quickreturn.reports.tables import CASE, Cell, Column, ColumnList, Table
from quickreturn.reports.words import degrees, listed, number, off_by, quantity, size

#: Places along the arm at which its stress is drawn.
ALONG: Final = 61


def machines(content: Content) -> Mapping[str, FirstScreen]:
    """Case -> what the first screen says of it; empty if no engine gives the stress of any machine's arm."""
    cases, units = content.of(loads_on), content.results[0].case.units
    if not any(case.lead for case in cases):
        return {}
    return {case.case.name: machine_screen(case, units) for case in cases}


def machine_screen(case: CaseLoads, units: Units) -> FirstScreen:
    """What the person who builds a machine asks first.

    Args:
        case: the loads.
        units: those of what is drawn along the arm.
    """
    if not case.lead:
        none = "No engine gives the stress of this machine’s arm: the chapter Provenance gives the reasons."
        return FirstScreen(case.case.title, "", [none], [])
    missed, warning = accuracies_missed(case.result), ""
    if missed:
        warning = (
            f"These numbers miss their accuracy: {'; '.join(missed)}. An error beside a number below is the engine’s own estimate of it."
        )
    sentences = [verdict(case.loads[case.lead]), departure_words(case)]
    nearest = f"Of the crank’s speed {case.nearness}." if case.nearness else ""
    return FirstScreen(case.case.title, warning, sentences, machine_figures(case), nearest, along_arm(case, units))


def departure_words(case: CaseLoads) -> str:
    """How much more or less stress the other engines find; "" without any."""
    found = [f"{name} finds {size(part)} {'more' if part > 0.0 else 'less'}" for name, part in case.departures().items()]
    return f"{case.lead} says so; {listed(found)}." if found else ""


def machine_figures(case: CaseLoads) -> list[Figure]:
    """The large numbers: stress, safety, forces, and the first mode over the crank's frequency."""
    peaks, resonance, units = case.loads[case.lead].peaks, case.resonance, case.case.units
    largest, parts = case.stress.largest, axial_words(case.stress.axial, units) or "bending alone"
    where = f"largest stress in the arm, {from_p(largest, units)}, crank at {degrees(largest.crank_angle or 0.0)}"
    figures = [(quantity(largest.value, units.of("Pa")), f"{where}: {parts}{_error(largest)}"), safety_figure(case)]
    for name, si in UNITS.items():
        if (peak := peaks[name]) and peak.value:
            at = f"crank at {degrees(peak.crank_angle or 0.0)}"
            figures.append((quantity(peak.value, units.of(si)), f"largest {NAMES[name]}, {at}{_error(peak)}"))
    if resonance:
        mean = f"first mode (mean {quantity(resonance.first_mode, units.of('Hz'))}) over the crank’s frequency"
        off = off_by(case.shift_of_motion, resonance.first_mode)
        figures.append((number(resonance.ratio, ".2f"), f"{mean}; {off}"))
    return figures


def safety_figure(case: CaseLoads) -> Figure:
    """The safety factors that are known, the least first, and the keys that give the others."""
    strengths = {"yielding": ("yield_strength", "at"), "fatigue": ("fatigue_strength", "at an amplitude of")}
    factors, unit = case.loads[case.lead].factors, case.case.units.of("Pa")
    texts = list[str]()
    for against, factor in factors.items():
        key, at = strengths[against]
        strength = getattr(case.case.mechanism.follower, key)
        texts.append(f"{factor.text if texts else 'safety'} against {against} {at} {number(strength / unit.size, '.4g')} {unit.sign}")
    if missing := [f"<code>{key}</code>" for against, (key, _) in strengths.items() if against not in factors]:
        texts.append(f"{'' if texts else 'safety: '}give {' and '.join(missing)} in <code>[follower]</code>")
    return next((factor.text for factor in factors.values()), "–"), Markup("; ".join(texts))


def _error(peak: Number) -> str:
    return "; the engine gives no error" if math.isnan(peak.error) else f"; {off_by(peak.error, peak.value)}"


def along_arm(case: CaseLoads, units: Units) -> dict[str, Any]:
    """Least and greatest stress along the arm over the cycle, at even arc lengths from P to the tip."""
    stress, unit = case.stress, units.of("Pa")
    places = np.linspace(0.0, stress.places[-1], ALONG)
    low, high = (np.interp(places, stress.places, values / unit.size) for values in (stress.lowest, stress.highest))
    place = stress.largest.place
    return {
        "engine": case.lead,
        "low": [float(f"{value:.4g}") for value in low],
        "high": [float(f"{value:.4g}") for value in high],
        "largest": stress.largest.value / unit.size,
        "unit": unit.sign,
        "at": None if place is None else place / float(stress.places[-1]),
    }


def strength(content: Content) -> Chapter | None:
    """The chapter; None for a report on the thesis' runs, or if no engine gives the stress."""
    cases = content.of(loads_on)
    if not (judged := [case for case in cases if case.lead]):
        return None
    return Chapter("strength", "Will it hold?", strength_finding(judged), {"table": strength_table(cases)})


def strength_finding(cases: Sequence[CaseLoads]) -> str:
    """The largest stress in the first case, and the least safety factor that is known."""
    case = cases[0]
    loads, units, largest = case.loads[case.lead], case.case.units, case.stress.largest
    text = f"{quantity(largest.value, units.of('Pa'))} at {from_p(largest, units)}"
    if loads.factors:
        against, factor = next(iter(loads.factors.items()))
        text += f", safety {factor.text} against {against}"
    return f"{case.case.name}: {text}" if len(cases) > 1 else text


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
    """The error in words; of a safety factor without a bound above its least value."""
    if load.lowest is not None and load.highest is None:
        return f"{load.lowest:.3g} or more"
    return "" if load.error is None else off_by(load.error, load.value)


PAGE = Part(chapters={strength: 10}, templates=("quickreturn.plugins.strength",), machines=machines)
