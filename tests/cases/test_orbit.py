"""Where marching begins, and what is known beforehand of how it will go."""

import dataclasses
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.interpolate import CubicHermiteSpline

import cases.stored_jobs
from cases.case_file import load_case
from cases.measures.steady_state import GREATEST_NUMBER, TOLERANCE
from cases.orbit import Curve, Orbit, begins_in_orbit, cycles_needed, find_orbit, orbit_key, orbits
from cases.runner import Named, run_tasks
from cases.steady_run import DIRECT, FROM_ORBIT, NOT_SETTLED, SETTLED, STANDARD, Task, steady_run
from cases.store import Store, key_of
from engines.base import NoSteadyState
from engines.own.reference import ReferenceEngine
from engines.registry import MAIN, RIVALS, engine
from engines.start import Start, standard_start
from reference_model.mechanism import Mechanism

MECHANISM = load_case("thesis-17").mechanism  # the one that settles soonest
CHEAP = {"links": "8"}


def task(name: str = "mujoco", mechanism: Mechanism = MECHANISM, **changes: Any) -> Task:
    return Task(mechanism=mechanism, duration=0.2, engine=name, **changes)


def damped(factor: float) -> Mechanism:
    """Run 24 with another damping of the beam, on which its multipliers depend."""
    mechanism = load_case("thesis-24").mechanism
    return dataclasses.replace(mechanism, follower=dataclasses.replace(mechanism.follower, damping=factor * mechanism.follower.damping))


@pytest.mark.parametrize("multiplier", [0.3, 0.77, 0.9, 0.95])
@pytest.mark.parametrize("error", [1e-3, 1e-2])
def test_cycles_needed_are_those_of_a_disturbance_made_anew_in_every_cycle(multiplier: float, error: float) -> None:
    left, cycles = error / (1.0 - multiplier), 0
    while left > TOLERANCE:
        left, cycles = multiplier * left, cycles + 1
    assert math.ceil(cycles_needed(multiplier, error)) == cycles


def test_whoever_settles_quickly_is_never_turned_away() -> None:
    """Largest accuracy that can be asked for: 5 %; the estimate may be twice as large and counts double."""
    assert Orbit(standard_start(MECHANISM), 0.85).hopeless(0.2) == ""


def test_a_march_that_cannot_end_is_refused_with_the_multiplier() -> None:
    slow, unstable = Orbit(standard_start(MECHANISM), 0.9931), Orbit(None, 1.25, "the periodic state is not stable")
    assert f"{GREATEST_NUMBER} cycles will not do" in slow.hopeless(1e-2)
    assert "0.993" in slow.hopeless(1e-2)
    assert "grows 1.250-fold" in unstable.hopeless(1e-9)
    assert Orbit(None, None, "none found").hopeless(1.0) == ""


def test_a_curve_is_the_spline_that_it_was_made_of_and_told_apart_by_its_content() -> None:
    x = np.linspace(0.0, 0.6, 7)
    spline = CubicHermiteSpline(x, np.sin(x), np.cos(x))
    at = np.linspace(0.0, 0.6, 50)
    curve = Curve(spline.x, spline.c)
    for order in range(3):
        assert np.array_equal(curve(at, order), spline(at, order))
    start = Start(1.0, 2.0, curve, curve)
    other = Start(1.0, 2.0, curve, Curve(spline.x, 1.0001 * spline.c))
    assert key_of({"start": start}) == key_of({"start": dataclasses.replace(start)}) != key_of({"start": other})


def test_engines_of_other_equations_begin_elsewhere() -> None:
    found = {name: begins_in_orbit(engine(name)) for name in (*MAIN, *RIVALS)}
    assert {name for name, wanted in found.items() if not wanted} == {"thesis"}


def test_the_orbit_is_searched_once_and_kept_to_the_last_bit(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    store = Store(tmp_path)
    (first,) = orbits([MECHANISM, dataclasses.replace(MECHANISM)], store, jobs=1).values()
    assert first.reason == ""
    assert first.multiplier is not None
    assert 0.0 < first.multiplier < 1.0

    def refuse(*jobs: object, **_: object) -> None:
        assert not jobs[0], "a job was started"
        return (outcome for outcome in ())  # type: ignore[return-value]

    monkeypatch.setattr(cases.stored_jobs, "run_jobs", refuse)
    again = orbits([MECHANISM], store)[orbit_key(MECHANISM)]
    assert key_of({"orbit": again}) == key_of({"orbit": first})


@pytest.mark.parametrize("outcome", ["none found", "unstable", "rigid"])
def test_what_there_is_none_to_begin_in_says_why(monkeypatch: pytest.MonkeyPatch, outcome: str) -> None:
    search = ReferenceEngine.steady_state

    def steady_state(self: ReferenceEngine, *arguments: Any) -> Any:
        if outcome == "none found":
            raise NoSteadyState("the search went astray")
        return dataclasses.replace(search(self, *arguments), stable=False, multipliers=(-1.25 + 0.0j,))  # type: ignore[type-var]

    mechanism = MECHANISM
    if outcome == "rigid":
        mechanism = load_case("rigid").mechanism
    else:
        monkeypatch.setattr(ReferenceEngine, "steady_state", steady_state)
    document, arrays = find_orbit(mechanism)
    assert arrays == {}
    assert document["multiplier"] == (1.25 if outcome == "unstable" else None)
    assert {"none found": "astray", "unstable": "not stable", "rigid": "rigid follower"}[outcome] in document["reason"]


def test_the_runner_lets_them_begin_where_they_shall(tmp_path: Path) -> None:
    tasks = [
        Named(("orbit",), task(settings=CHEAP)),
        Named(("straight",), task(settings=CHEAP, straight=True, estimated=False)),
        Named(("thesis",), task("thesis", settings={"tolerance": "1e-6"})),
        Named(("reference",), task("reference", settings={"modes": "2", "tolerance": "1e-6"})),
    ]
    runs = run_tasks(tasks, Store(tmp_path), jobs=1)
    assert {name[0]: run.start for name, run in runs.items()} == {
        "orbit": FROM_ORBIT,
        "straight": STANDARD,
        "thesis": STANDARD,
        "reference": DIRECT,
    }
    assert all(run.status == SETTLED for run in runs.values()), [run.document["remark"] for run in runs.values()]
    assert {name[0] for name, run in runs.items() if run.unestimated} == {"straight", "thesis"}


def test_a_run_that_will_not_do_is_not_begun(monkeypatch: pytest.MonkeyPatch) -> None:
    start = find_start(MECHANISM)
    monkeypatch.setattr("cases.steady_run.settle", lambda *_: pytest.fail("it marched"))
    for orbit in (Orbit(start, 0.993), Orbit(None, 1.02, "the periodic state is not stable")):
        document = steady_run(task(settings=CHEAP, orbit=orbit)).document
        assert (document["status"], document["settled"], document["cycles"]) == (NOT_SETTLED, False, 0)
        assert f"{orbit.multiplier:.3f}" in document["remark"]
        assert document["error_estimate"] is not None, "what was found out before is kept"


def test_where_there_is_no_orbit_the_standard_start_serves_and_it_is_said() -> None:
    document = steady_run(task(settings=CHEAP, orbit=Orbit(None, None, "the search went astray"))).document
    assert (document["status"], document["start"]) == (SETTLED, STANDARD)
    assert "begun in the standard start" in document["remark"]
    assert "the search went astray" in document["remark"]


def find_start(mechanism: Mechanism) -> Start:
    reference = ReferenceEngine()
    return reference.periodic_start(mechanism, reference.settings_for(reference.default_accuracy, mechanism))


@pytest.mark.verify
@pytest.mark.parametrize("factor", [0.7, 0.5, 0.4, 0.3, 0.25, 0.2, 0.1])
def test_whoever_is_let_go_arrives(factor: float) -> None:
    """Less and less damping: multipliers of 0.82 to 0.97. Each run settles within sixty cycles or is not begun."""
    mechanism = damped(factor)
    document, _ = find_orbit(mechanism)
    orbit = Orbit(find_start(mechanism), document["multiplier"])
    run = steady_run(Task(mechanism=mechanism, duration=2.0, engine="mujoco", orbit=orbit)).document
    assert run["status"] == SETTLED or "not marched" in run["remark"], run["remark"]
    assert (run["status"] == SETTLED) or document["multiplier"] > 0.85
