"""The 24 runs of the thesis: every engine against the reference, with the tolerances that the cases' data give and explain."""

import dataclasses
import math

import pytest

from cases.case import Case
from cases.case_file import load_case
from cases.comparison import CaseResult, compare
from cases.cross_validation import cross_validate
from cases.engine_run import EngineRun, engine_run
from cases.library import case_names
from cases.measures import CHANNELS, measure_cycle, time_scale
from cases.steady_run import OUTPUT_STEP, SETTLED, Task, whole_cycles
from cases.store import Store
from engines.pseudo_coordinate.reference import ReferenceEngine
from engines.registry import engine
from engines.start import Start

RUNS = [name for name in case_names() if name.startswith("thesis-")]
#: Those of every test run: all crank lengths and tip bodies, the slowest and the fastest.
SHORT = ("thesis-01", "thesis-06", "thesis-08", "thesis-10", "thesis-15", "thesis-17", "thesis-20", "thesis-24")


def steady(case: Case, name: str) -> EngineRun:
    run = engine_run(Task(mechanism=case.mechanism, duration=case.duration, engine=name))
    return EngineRun(run.document, run.cycle)


def periodic_start(case: Case) -> Start:
    reference = ReferenceEngine()
    return reference.periodic_start(case.mechanism, reference.settings_for(reference.default_accuracy, case.mechanism))


def two_cycles_from(case: Case, name: str, start: Start) -> EngineRun:
    """The second of two cycles, measured like a steady one; `start` is where a cycle begins."""
    chosen = engine(name)
    simulation = chosen.prepare(case.mechanism, start, chosen.settings_for(chosen.default_accuracy, case.mechanism))
    # it begins where a cycle does; a twentieth more for a crank that turns slower than there
    duration = OUTPUT_STEP * math.ceil(2.1 * 2.0 * math.pi / start.crank_speed / OUTPUT_STEP)
    cycle = whole_cycles(simulation.advance(duration, OUTPUT_STEP))[1]
    columns = {"time": cycle.time, "crank_angle": cycle.crank_angle, **cycle.channels}
    channels = {channel: columns[channel] for channel in CHANNELS}
    found = measure_cycle(time_scale(case.mechanism), cycle.time, cycle.crank_angle, channels)
    document = {
        "engine": name,
        "status": SETTLED,
        "measures": [dataclasses.asdict(measure) for measure in found.measures],
        "consensus": [dataclasses.asdict(consensus) for consensus in found.consensus],
    }
    return EngineRun(document, columns)


@pytest.mark.parametrize("name", SHORT)
def test_every_engine_stays_within_the_tolerances_of_the_case(name: str) -> None:
    """The engines that march for minutes begin in the reference's periodic state."""
    case = load_case(name)
    start = periodic_start(case)
    runs = {engine: steady(case, engine) for engine in ("reference", "thesis")}
    runs |= {engine: two_cycles_from(case, engine, start) for engine in ("mujoco", "exudyn")}
    assert_within_tolerances(compare(case, runs))


@pytest.mark.verify
@pytest.mark.parametrize("name", RUNS)
def test_every_engine_finds_its_steady_state_from_the_standard_start(name: str) -> None:
    """What the report shows; kept where it finds it, and taken from there."""
    (result,) = cross_validate([load_case(name)], Store(), jobs=1)
    assert_within_tolerances(result)


def assert_within_tolerances(result: CaseResult) -> None:
    assert not result.failures, [run.document["remark"] for run in result.failures]
    # the single cubic is judged by its frequency alone, which not every run resolves
    assert {"mujoco", "exudyn"} <= {check.engine for check in result.checks}
    assert not result.missed, [check.as_dict() for check in result.missed]
