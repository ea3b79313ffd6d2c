"""Loads on the parts, as `simulate` and `run` show them."""

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, Final

from quickreturn.cases.files.case import Case
from quickreturn.cases.files.shown import Cell
from quickreturn.engines.accurate import Result
from quickreturn.plugins.strength.arm import missing
from quickreturn.plugins.strength.loads import UNITS, Loads, loads_job, loads_of_run
from quickreturn.plugins.strength.words import NAMES, loads_document, stress_text
from quickreturn.readings import Reading
from quickreturn.reference_model.columns import MOMENTS
from quickreturn.reports.words import TIED, quantity

if TYPE_CHECKING:
    from quickreturn.cases.comparison.engines import CaseResult


def of_simulation(case: Case, result: Result, loads: Loads) -> Iterator[tuple[str, Cell]]:
    """The largest stress, or why there is none."""
    columns = result.trajectory.columns
    if loads.stress is not None:
        yield "arm", f"with the transient of its start, {stress_text(loads, case)}".replace(TIED, " ")
        if case.scene.crank is not None:
            yield "", "`run` gives the settled machine, with its safety against fatigue"
    elif {*MOMENTS} <= columns.keys():
        yield "arm", f"no stress along it: {missing(case.scene, columns)}"


def lines(result: "CaseResult") -> Iterator[str]:
    """Loads on the parts by the leading engine, and the nearest resonance."""
    from quickreturn.plugins.strength.case_loads import leading_loads

    case, units = leading_loads(result), result.case.units
    texts = list[str]()
    if case.lead:
        loads = case.loads[case.lead]
        texts.append(f"{case.lead}: {stress_text(loads, case.case)}")
        peaks = [f"{NAMES[name]} {quantity(peak.value, units.of(UNITS[name]))}" for name, peak in loads.peaks.items() if peak]
        texts += [f"{case.lead}: largest {', '.join(peaks)}"] * bool(peaks)
        if case.resonance is not None:
            texts.append(f"first mode over the crank's frequency {case.resonance.ratio:.2f}: {case.nearness}")
    return (text.replace(TIED, " ") for text in texts)


def rows(result: "CaseResult") -> Iterator[dict[str, Any]]:
    """All numbers, each with its engine; "" where it needs none."""
    from quickreturn.plugins.strength.case_loads import loads_of_case, numbers_of_case

    return ({"engine": engine} | vars(number) for engine, number in numbers_of_case(loads_of_case(result)))


LOADS: Final = Reading(job=loads_job, of_run=loads_of_run, document=loads_document, of_simulation=of_simulation, lines=lines, rows=rows)
