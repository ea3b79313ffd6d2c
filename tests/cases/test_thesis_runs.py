"""The 24 runs of the thesis: every engine against the reference, with the tolerances that the cases' data give and explain."""

import dataclasses
import math

import pytest

from cases.case import Case
from cases.case_file import load_case
from cases.comparison import compare
from cases.engine_run import EngineRun, engine_run
from cases.library import case_names
from cases.measures import CHANNELS, measure_cycle, time_scale
from cases.steady_run import OUTPUT_STEP, SETTLED, Task, settle, whole_cycles
from engines.pseudo_coordinate.reference import ReferenceEngine
from engines.registry import engine
from engines.start import Start

RUNS = [name for name in case_names() if name.startswith("thesis-")]
#: The fastest run: its steady state is found by Exudyn itself, as all are in the long verification. In the others it begins in the
#: reference's periodic state.
FROM_STANDARD_START = ("thesis-10",)
#: Those of every test run: all crank lengths and tip bodies, the slowest and the fastest. The others take as long each, in the long one.
SHORT = ("thesis-01", "thesis-06", "thesis-08", "thesis-10", "thesis-15", "thesis-17", "thesis-20", "thesis-24")


def steady(case: Case, name: str) -> EngineRun:
    run = engine_run(Task(mechanism=case.mechanism, duration=case.duration, engine=name))
    return EngineRun(run.document, run.cycle)


def periodic_start(case: Case) -> Start:
    chosen = ReferenceEngine()
    settings = chosen.settings_for(chosen.default_accuracy, case.mechanism)
    speed = case.mechanism.crank.drive.initial_speed
    simulation = chosen.prepare(case.mechanism, Start(math.pi, speed), settings)
    settle(simulation, speed, {})
    return simulation.present_start()


def two_cycles_from(case: Case, name: str, start: Start) -> EngineRun:
    """The second of two whole cycles, measured like a steady one."""
    chosen = engine(name)
    simulation = chosen.prepare(case.mechanism, start, chosen.settings_for(chosen.default_accuracy, case.mechanism))
    # a start anywhere in a cycle needs up to three turns for two whole ones
    duration = OUTPUT_STEP * math.ceil(3.1 * 2.0 * math.pi / start.crank_speed / OUTPUT_STEP)
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


@pytest.mark.parametrize("name", [name if name in SHORT else pytest.param(name, marks=pytest.mark.verify) for name in RUNS])
def test_every_engine_stays_within_the_tolerances_of_the_case(name: str) -> None:
    case = load_case(name)
    runs = {engine: steady(case, engine) for engine in ("reference", "thesis", "mujoco")}
    if name in FROM_STANDARD_START:
        runs["exudyn"] = steady(case, "exudyn")
    else:
        runs["exudyn"] = two_cycles_from(case, "exudyn", periodic_start(case))
    result = compare(case, runs)
    assert not result.failures, [run.document["remark"] for run in result.failures]
    # the single cubic is judged by its frequency alone, which not every run resolves
    assert {"mujoco", "exudyn"} <= {check.engine for check in result.checks}
    assert not result.missed, [check.as_dict() for check in result.missed]


@pytest.mark.verify
@pytest.mark.parametrize("name", RUNS)
def test_exudyn_finds_every_steady_state_from_the_standard_start(name: str) -> None:
    case = load_case(name)
    result = compare(case, {engine: steady(case, engine) for engine in ("reference", "exudyn")})
    assert not result.failures, [run.document["remark"] for run in result.failures]
    assert not result.missed, [check.as_dict() for check in result.missed]
