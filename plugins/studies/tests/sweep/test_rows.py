"""Rows of points, held against the road of `run`, which marches, climbs the engine's ladder and fits the same measures by itself."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from quickreturn.cases.files.case import case_of, document_of
from quickreturn.cases.library import library_case
from quickreturn.cases.motion.catalogue import numbers
from quickreturn.cases.motion.endings import Ending
from quickreturn.cases.motion.request import RunRequest
from quickreturn.cases.motion.steady_state import steady_state
from quickreturn.cases.running.isolation import STOPPED
from quickreturn.cases.running.job import Limits, Nobody, Outcome, ThisProcess
from quickreturn.cases.running.key import key_of
from quickreturn.cases.running.store import Store
from quickreturn.cases.running.workshop import Workshop
from quickreturn.engines.own.reference import ReferenceEngine, ReferenceSettings
from quickreturn.engines.start import standard_start
from quickreturn.plugins.studies.sweep import grid as of_grid
from quickreturn.plugins.studies.sweep.grid import Grid, axis
from quickreturn.plugins.studies.sweep.rows import LEFT, MeasureRequest, row
from quickreturn.plugins.studies.sweep.study import study
from quickreturn.reference_model.mechanism import Mechanism, PrescribedSpeed
from quickreturn.reference_model.model import BeamModel
from quickreturn.reference_model.scene_values import changed
from quickreturn.reference_model.slider import Slider
from tests.reference_model.multipliers import floquet_multipliers

RPM = math.pi / 30.0
NAMES = ("peak.tip_acceleration", "rms.strain_2", "min.slider_force", "peak.stress", "peak.crank_force", "multiplier", "turn.drive_work")


def at(speed: float, **values: float) -> Mechanism:
    scene = library_case("thesis-24").mechanism
    scene = replace(scene, crank=replace(scene.crank, drive=PrescribedSpeed(speed=speed * RPM)))
    return changed(scene, {key.replace("__", "."): value for key, value in values.items()})


def test_a_point_is_what_run_finds() -> None:
    scene = at(120.0)
    found = row([at(110.0), scene], MeasureRequest(measures=NAMES))
    run = steady_state(RunRequest(mechanism=scene, duration=2.0, engine="reference"))
    of_run = np.array([(each.value, each.error) for each in numbers(scene, run, NAMES).values()])
    assert found.statuses == (Ending.SETTLED, Ending.SETTLED)
    apart = np.abs(found.values[1] - of_run[:, 0])
    # `run` claims nothing of its multiplier, which is no better than the point's
    claimed = found.errors[1] + np.where(np.isfinite(of_run[:, 1]), of_run[:, 1], found.errors[1])
    assert np.all(apart <= claimed), dict(zip(NAMES, apart / claimed, strict=True))
    sharp = [name != "turn.drive_work" for name in NAMES]  # within a turn, work goes to and fro a hundred times what is left of it
    assert np.all((claimed < 0.02 * np.abs(found.values[1]))[sharp])


def test_a_motion_that_the_dampers_end_takes_from_the_drive_what_they_dissipate() -> None:
    found = row([at(100.0)], MeasureRequest(measures=("turn.drive_work", "turn.dissipated_energy"))).values[0]
    assert found[0] == pytest.approx(found[1], rel=5e-3)
    assert found[0] > 0.0


@pytest.mark.parametrize("speed", [60.0, 120.0])
def test_multipliers_err_by_no_more_than_they_claim(speed: float) -> None:
    """At 60 rpm the largest one is complex; two models with the same slow modes differ by a hundredth of the error."""
    scene = at(speed)
    found = row([scene], MeasureRequest(measures=("multiplier", "multiplier.real", "multiplier.imag")))
    orbit = ReferenceEngine().steady_state(scene, standard_start(scene), ReferenceSettings(modes=6, tolerance=1e-9))
    assert orbit is not None
    assert isinstance(orbit.simulation.model, BeamModel)
    whole = floquet_multipliers(orbit.simulation.model, orbit.orbit, 1e-9)[0]
    quotients = 5e-4  # error of the whole model's own difference quotients
    apart = np.abs(found.values[0] - [abs(whole), whole.real, whole.imag])
    assert np.all(apart < found.errors[0] + quotients)
    assert np.all(found.errors[0] < 0.02)


def test_frequencies_are_those_of_run() -> None:
    scene, names = at(120.0), ("pre.frequency", "post.frequency", "pre.amplitude.strain_2")
    found = row([scene], MeasureRequest(measures=names, claims=False))
    run = steady_state(RunRequest(mechanism=scene, duration=2.0, engine="reference", estimated=False))
    assert found.values[0] == pytest.approx([each.value for each in numbers(scene, run, names).values()], rel=2e-3)


def test_what_cannot_be_settled_has_a_status_and_the_row_goes_on() -> None:
    found = row(
        [at(700.0), at(100.0), replace(at(100.0), slider=Slider(friction=0.3))], MeasureRequest(measures=("multiplier",), claims=False)
    )
    assert found.statuses[0] == LEFT
    assert "left" in found.sentences[0]
    assert found.statuses[1] == Ending.SETTLED
    assert np.isfinite(found.values[1, 0])
    refused = row([replace(at(100.0), slider=Slider(friction=0.3))], MeasureRequest(measures=("multiplier",), engine="exudyn"))
    assert refused.statuses == (Ending.REFUSED,)


ASKED = MeasureRequest(measures=("peak.tip_acceleration", "multiplier"), claims=False)


def grid(*axes: str) -> Grid:
    return Grid(library_case("thesis-24"), tuple(axis(text) for text in axes))


def test_values_lie_where_their_place_says(tmp_path: Path) -> None:
    """Rows go backwards, and the second axis is the one along which they run."""
    some = grid("tip.mass = 0 g; 25 g", "crank.prescribed_speed = 120 rpm .. 80 rpm : 3")
    workshop = Workshop(Store(tmp_path), ThisProcess())
    found = study(some, ASKED, workshop)
    assert found.values.shape == (2, 3, 2)
    assert np.all(found.statuses == Ending.SETTLED)
    assert np.all(np.diff(found.values[:, :, 0], axis=1) < 0.0), "a faster crank shakes the tip more"
    assert np.all(np.diff(found.values[:, :, 1], axis=0) > 0.0), "a heavier tip keeps more of a disturbance"
    before = {file: file.stat().st_mtime_ns for file in tmp_path.glob("*.result")}
    again = study(some, ASKED, workshop)
    assert {file: file.stat().st_mtime_ns for file in tmp_path.glob("*.result")} == before
    assert np.array_equal(again.values, found.values, equal_nan=True)


class _Dies(ThisProcess):
    """Loses every job that holds the point at 100 rpm."""

    def run(self, jobs, watch=None):  # type: ignore[no-untyped-def]
        for outcome in super().run(jobs, watch):
            lost = any(change["crank.prescribed_speed"].text == "100 rpm" for change in outcome.job.arguments[1])
            yield Outcome(outcome.job, failure="killed by SIGSEGV") if lost else outcome


class _Slow(Nobody):
    """Stops every job at its time limit, and adds up the time that this takes."""

    limits = Limits(seconds=60.0)

    def __init__(self) -> None:
        self.spent: list[float] = []

    def run(self, jobs, watch=None):  # type: ignore[no-untyped-def]
        for each in jobs:
            self.spent.append((each.limits or self.limits).seconds)
            yield Outcome(each, failure=f"{STOPPED} of {self.spent[-1]:g} s")


@pytest.mark.parametrize(("points", "spent"), [("80 rpm", [60.0]), ("80 rpm .. 120 rpm : 3", [60.0, 20.0, 20.0, 20.0])])
def test_a_row_that_exceeds_its_time_gets_as_much_again_and_a_single_point_nothing(tmp_path: Path, points: str, spent: list[float]) -> None:
    executor = _Slow()
    found = study(grid(f"crank.prescribed_speed = {points}"), ASKED, Workshop(Store(tmp_path), executor))
    assert executor.spent == spent
    assert set(found.statuses.flat) == {Ending.FAILED}
    assert all(f"its process {STOPPED}" in sentence for sentence in found.sentences.flat)


@pytest.mark.verify
def test_engines_alone_may_vary(tmp_path: Path) -> None:
    """Each point is computed by its own engine, as in a study of that engine."""
    workshop, asked = Workshop(Store(tmp_path), ThisProcess()), MeasureRequest(measures=("peak.tip_acceleration",), claims=False)
    found = study(grid("engine = reference; thesis"), asked, workshop)
    alone = study(grid("base.friction_torque = 0 N*m"), replace(asked, engine="thesis"), workshop)
    assert found.values[1, 0] == pytest.approx(alone.values[0, 0], rel=1e-12)
    assert found.values[0, 0] > 1.02 * found.values[1, 0]


def test_equal_machines_that_a_change_makes_different_are_kept_apart() -> None:
    """A thickness changes the stiffness of a follower that is given by its material, and not that of one that is given by its stiffness."""
    as_material = library_case("shaper-cutting")
    as_stiffness = case_of(document_of(as_material))
    assert as_stiffness.scene == as_material.scene
    change = [{"follower.thickness": 0.03}]
    assert key_of(of_grid.job(as_material, change, ASKED)) != key_of(of_grid.job(as_stiffness, change, ASKED))


def test_a_point_that_kills_its_process_costs_that_point(tmp_path: Path) -> None:
    found = study(grid("crank.prescribed_speed = 80 rpm .. 120 rpm : 3"), ASKED, Workshop(Store(tmp_path), _Dies()))
    assert found.statuses.tolist() == [Ending.SETTLED, Ending.FAILED, Ending.SETTLED]
    assert "killed by SIGSEGV" in found.sentences[1]
    assert np.isnan(found.values[1]).all()
    assert np.isfinite(found.values[[0, 2]]).all()
