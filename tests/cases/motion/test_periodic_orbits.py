"""Steady states found directly, in the runs of the thesis: the same as by marching, and a start for other engines."""

import dataclasses
import math
from typing import Any

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from quickreturn.cases.library import case_names, load_case
from quickreturn.cases.motion.cycle import HALVES
from quickreturn.cases.motion.endings import Ending
from quickreturn.cases.motion.marching import columns_of, output_step, whole_cycles
from quickreturn.cases.motion.orbit import find_orbit
from quickreturn.cases.motion.request import FROM_ORBIT, STANDARD, Run, RunRequest
from quickreturn.cases.motion.steady_state import steady_state
from quickreturn.cases.motion.time_scale import CHANNELS
from quickreturn.engines.base import NoSteadyState, SteadyState
from quickreturn.engines.own.reference import ReferenceEngine
from quickreturn.engines.registry import engine
from quickreturn.engines.settings import Settings, as_texts
from quickreturn.engines.start import Start, standard_start
from quickreturn.plugins.thesis.starts import cycle_difference
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.cycles.periodic import periodic_orbit
from quickreturn.reference_model.cycles.poincare import PoincareMap
from quickreturn.reference_model.mechanism import Mechanism
from quickreturn.reference_model.model import BeamModel

QUICK = ("thesis-06", "thesis-24", "hard-speed-x2")
GRID = np.linspace(0.0, 2.0 * np.pi, 400)
#: Cheap settings: what is compared is one way to the steady state with another, at the same settings.
SETTINGS = {"modes": "3", "tolerance": "1e-8"}


def on_grid(cycle: dict[str, Array]) -> dict[str, Array]:
    """Channels over the angle turned since the cycle's beginning."""
    turned = np.abs(cycle["crank_angle"] - cycle["crank_angle"][0])
    return {name: CubicSpline(turned, cycle[name])(GRID) for name in (*CHANNELS, "crank_speed", "tip_deflection")}


def differences(one: dict[str, Array], other: dict[str, Array]) -> dict[str, float]:
    a, b = on_grid(one), on_grid(other)
    return {name: float(np.sqrt(np.mean((a[name] - b[name]) ** 2) / np.mean(b[name] ** 2))) for name in a}


@pytest.mark.parametrize(
    "name", [name if name in QUICK else pytest.param(name, marks=pytest.mark.verify) for name in (*case_names()[:24], "hard-speed-x2")]
)
def test_same_orbit_as_marching(name: str) -> None:
    """After 60 cycles or more. At twice the speed Newton's method fails from the state after two cycles, and succeeds after more."""
    mechanism = load_case(name).mechanism
    # two modes: the way to the orbit is the same whatever the number of modes, and 24 times a hundred cycles take their time
    model = BeamModel.following(mechanism, 2)
    state = model.straight_state(math.pi, mechanism.crank.drive.initial_speed)
    orbit = periodic_orbit(model, state, 1e-7, 1e-10)
    march = PoincareMap(model, 1e-10)
    # the slowest disturbance must shrink to 1e-8
    for _ in range(math.ceil(math.log(1e-8) / math.log(abs(orbit.multipliers[0])))):
        passage = march.passage(state, orbit.period)
        state = passage.state
    assert passage.duration == pytest.approx(orbit.period, rel=1e-7)
    assert orbit.stable
    assert np.max(np.abs(march.point(state) - march.point(orbit.state)) / passage.sizes) < 1e-6


@pytest.fixture(scope="module")
def found() -> Run:
    return steady_state(request("thesis-24", "reference", settings=SETTINGS))


def request(name: str, engine_name: str, **changes: Any) -> RunRequest:
    case = load_case(name)
    return RunRequest(mechanism=case.mechanism, duration=0.2, engine=engine_name, **changes)


def test_a_run_of_the_reference_is_one_cycle_of_its_orbit(found: Run) -> None:
    cycle, orbit = found.cycle, found.approach.periodic_orbit
    assert found.status == Ending.SETTLED
    assert found.approach.settled
    assert orbit.stable
    assert orbit.iterations <= found.approach.cycles < 20
    assert np.hypot(*orbit.multipliers[0]) == pytest.approx(0.773, abs=8e-3)
    assert cycle["time"][-1] - cycle["time"][0] == pytest.approx(orbit.period, rel=1e-6)
    assert abs(cycle["crank_angle"][-1] - cycle["crank_angle"][0]) == pytest.approx(2.0 * math.pi, abs=1e-8)
    for name in (*CHANNELS, "tip_deflection", "slider_force"):
        # a tenth of the search's tolerance is left; channels are interpolated to the end of the cycle
        assert cycle[name][-1] == pytest.approx(cycle[name][0], abs=1e-4 * np.max(np.abs(cycle[name]))), name


class Searching(ReferenceEngine):
    """The reference with another outcome of its search."""

    def __init__(self, stable: bool | None) -> None:
        self.stable = stable

    def steady_state(self, mechanism: Mechanism, start: Start, settings: Settings, near: SteadyState | None = None) -> SteadyState | None:
        if self.stable is None:
            raise NoSteadyState("the search went astray")
        steady = super().steady_state(mechanism, start, settings, near)
        return dataclasses.replace(steady, stable=self.stable, multipliers=(-1.25 + 0.0j, *steady.multipliers))


def outcome_with(monkeypatch: pytest.MonkeyPatch, stable: bool | None) -> Run:
    monkeypatch.setattr("quickreturn.cases.motion.steady_state.engine_of_name", lambda _: Searching(stable))
    return steady_state(request("thesis-17", "reference", settings={"modes": "2", "tolerance": "1e-6"}))


def test_without_an_orbit_it_marches_and_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    run = outcome_with(monkeypatch, None)
    assert (run.status, run.approach.start) == (Ending.SETTLED, STANDARD)
    assert "marched, because no periodic state was found directly: the search went astray" in run.remark
    assert run.approach.settling_error < 1e-3


def test_with_an_unstable_orbit_it_does_not_march(monkeypatch: pytest.MonkeyPatch) -> None:
    run = outcome_with(monkeypatch, False)
    assert (run.status, run.approach.settled, run.approach.cycles) == (Ending.NOT_SETTLED, False, 0)
    assert "1.250-fold" in run.remark
    assert not run.approach.periodic_orbit.stable


@pytest.mark.verify
def test_two_cycles_from_the_orbit_show_the_errors_of_settled_ones() -> None:
    """Three runs of six turns from the standard start estimate no more than three of two turns from the orbit.

    Two turns show 0.99 to 1.16 of it, but count 1.96 times, as an error would that lies in the slowest mode alone: measured 1.93 to 2.27.
    """
    case = load_case("thesis-17")
    of_case = {"mechanism": case.mechanism, "duration": case.duration, "engine": "mujoco", "settings": {"links": "15"}}
    early, settled = (steady_state(RunRequest(**of_case, **way)) for way in ({"orbit": find_orbit(case.mechanism)}, {"straight": True}))
    ratios = [
        early.measured.extreme_estimates[name][half] / settled.measured.extreme_estimates[name][half]
        for name in (*CHANNELS, "tip_deflection", "slider_force")
        for half in HALVES
    ]
    assert 1.0 < min(ratios) < max(ratios) < 2.6


@pytest.mark.verify
@pytest.mark.parametrize("engine_name", ["exudyn", "mujoco"])
@pytest.mark.parametrize("name", ["thesis-06", "thesis-10", "thesis-16", "thesis-24"])
def test_packages_from_the_orbit_settle_where_they_settle_straight(name: str, engine_name: str) -> None:
    mechanism, chosen = load_case(name).mechanism, engine(engine_name)
    texts = as_texts(chosen.settings_for(chosen.default_accuracy, mechanism).as_dict())
    straight = steady_state(request(name, engine_name, settings=texts))
    from_orbit = steady_state(request(name, engine_name, settings=texts, orbit=find_orbit(mechanism)))
    assert [run.status for run in (straight, from_orbit)] == [Ending.SETTLED, Ending.SETTLED]
    assert [run.approach.start for run in (straight, from_orbit)] == [STANDARD, FROM_ORBIT]
    assert from_orbit.approach.cycles < straight.approach.cycles
    assert cycle_difference(straight.cycle, from_orbit.cycle) < sum(run.approach.settling_error or 0.0 for run in (straight, from_orbit))


def test_the_reference_marched_from_its_own_orbit_stays_there(found: Run) -> None:
    mechanism, reference = load_case("thesis-24").mechanism, ReferenceEngine()
    settings = reference.settings_for(1e-3, mechanism).with_texts(SETTINGS)
    steady = reference.steady_state(mechanism, standard_start(mechanism), settings)
    trajectory = reference.prepare(mechanism, steady.simulation.present_start(), settings).advance(0.8, output_step(mechanism))
    cycle = whole_cycles(trajectory)[-1]
    columns = columns_of(cycle)
    # the start is a deflection on 240 points and its projection: 1e-4
    assert max(differences(columns, found.cycle).values()) < 5e-4
