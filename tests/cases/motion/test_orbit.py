"""Where marching begins, and what is known beforehand of how it will go."""

import dataclasses
import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.interpolate import CubicHermiteSpline

from quickreturn.cases.library import load_case
from quickreturn.cases.motion.endings import Ending
from quickreturn.cases.motion.orbit import Curve, Orbit, PeriodicStart, begins_in_orbit, cycles_needed, find_orbit, orbits
from quickreturn.cases.motion.request import STANDARD, RunRequest
from quickreturn.cases.motion.settling import GREATEST_NUMBER, TOLERANCE
from quickreturn.cases.motion.steady_state import steady_state
from quickreturn.cases.running.isolation import LocalProcesses
from quickreturn.cases.running.key import hash_of
from quickreturn.cases.running.store import Store
from quickreturn.cases.running.workshop import Workshop
from quickreturn.engines.base import NoSteadyState
from quickreturn.engines.own.reference import ReferenceEngine
from quickreturn.engines.registry import MAIN, engine
from quickreturn.engines.start import Start
from quickreturn.plugins.methods.rivals import RIVALS
from quickreturn.reference_model.mechanism import Mechanism

MECHANISM = load_case("thesis-17").mechanism  # the one that settles soonest
CHEAP = {"links": "8"}
STRAIGHT = Curve(np.array([0.0, 1.0]), np.zeros((4, 1)))
SOMEWHERE = PeriodicStart(math.pi, 10.0, STRAIGHT, STRAIGHT)


def request(name: str = "mujoco", mechanism: Mechanism = MECHANISM, **changes: Any) -> RunRequest:
    return RunRequest(mechanism=mechanism, duration=0.2, engine=name, **changes)


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
    assert Orbit(SOMEWHERE, 0.85).hopeless(0.2) == ""


def test_a_march_that_cannot_end_is_refused_with_the_multiplier() -> None:
    slow, unstable = Orbit(SOMEWHERE, 0.9931), Orbit(None, 1.25, "the periodic state is not stable")
    assert f"{GREATEST_NUMBER} cycles do not suffice" in slow.hopeless(1e-2)
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
    assert hash_of(start) == hash_of(dataclasses.replace(start)) != hash_of(other)
    same = Start(1.0, 2.0, Curve(spline.x.copy(), spline.c.copy()), Curve(spline.x.copy(), spline.c.copy()))
    assert start == same != other
    assert len({start.deflection, same.deflection, other.deflection_rate}) == 2


def test_engines_of_other_equations_begin_elsewhere() -> None:
    found = {name: begins_in_orbit(engine(name)) for name in (*MAIN, *RIVALS)}
    assert {name for name, wanted in found.items() if not wanted} == {"thesis", "moving-boundaries"}


def test_the_orbit_is_searched_once_and_kept_to_the_last_bit(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    workshop = Workshop(Store(tmp_path))
    first, same = orbits([MECHANISM, dataclasses.replace(MECHANISM)], workshop)
    assert first.reason == ""
    assert 0.0 < first.multiplier < 1.0
    assert len(list(tmp_path.glob("*.result"))) == 1

    def refuse(_: object, jobs: Sequence[object], *__: object) -> Iterator[Any]:
        assert not jobs, "a job was started"
        yield from ()

    monkeypatch.setattr(LocalProcesses, "run", refuse)
    (again,) = orbits([MECHANISM], workshop)
    assert hash_of(again) == hash_of(first) == hash_of(same)


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
    found = find_orbit(mechanism)
    assert found.begin is None
    assert found.multiplier == (1.25 if outcome == "unstable" else None)
    assert {"none found": "astray", "unstable": "not stable", "rigid": "rigid follower"}[outcome] in found.reason


def test_a_run_that_will_not_do_is_not_begun(monkeypatch: pytest.MonkeyPatch) -> None:
    start = find_orbit(MECHANISM).begin
    monkeypatch.setattr("quickreturn.cases.motion.steady_state.settle", lambda *_: pytest.fail("it marched"))
    for orbit in (Orbit(start, 0.993), Orbit(None, 1.02, "the periodic state is not stable")):
        found = steady_state(request(settings=CHEAP, orbit=orbit))
        assert (found.status, found.approach.settled, found.approach.cycles) == (Ending.NOT_SETTLED, False, 0)
        assert f"{orbit.multiplier:.3f}" in found.remark
        assert found.computation.error_estimate is not None, "what was found out before is kept"


def test_where_there_is_no_orbit_the_standard_start_serves_and_it_is_said() -> None:
    found = steady_state(request(settings=CHEAP, orbit=Orbit(None, None, "the search went astray"), estimated=False))
    assert (found.status, found.approach.start) == (Ending.SETTLED, STANDARD)
    assert "begun in the standard start" in found.remark
    assert "the search went astray" in found.remark


@pytest.mark.verify
@pytest.mark.parametrize("factor", [0.7, 0.5, 0.4, 0.3, 0.25, 0.2, 0.1])
def test_whoever_is_let_go_arrives(factor: float) -> None:
    """Less and less damping: multipliers of 0.82 to 0.97. Each run settles within sixty cycles or is not begun."""
    mechanism = damped(factor)
    orbit = find_orbit(mechanism)
    run = steady_state(RunRequest(mechanism=mechanism, duration=2.0, engine="mujoco", orbit=orbit))
    assert run.status == Ending.SETTLED or "not marched" in run.remark, run.remark
    assert (run.status == Ending.SETTLED) or (orbit.multiplier or 0.0) > 0.85
