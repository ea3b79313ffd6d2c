"""Rows of points, held against the road of `run`, which marches, climbs the engine's ladder and fits the same measures by itself."""

import math
from dataclasses import replace

import numpy as np
import pytest

from quickreturn.cases.library import library_case
from quickreturn.cases.motion.catalogue import MEASURES, numbers
from quickreturn.cases.motion.endings import Ending
from quickreturn.cases.motion.request import RunRequest
from quickreturn.cases.motion.stability import NOT_CONVERGED
from quickreturn.cases.motion.steady_state import steady_state
from quickreturn.engines.base import NoSteadyState
from quickreturn.engines.own.reference import ReferenceEngine, ReferenceSettings
from quickreturn.engines.start import standard_start
from quickreturn.plugins.studies.sweep.rows import LEFT, MeasureRequest, row
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


def test_a_search_that_strays_says_nothing_of_whether_a_machine_can_be_built(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its reason is the place to which it strayed; that a loop cannot close is a status of scenes whose parts do not fit."""

    def strayed(*_: object) -> None:
        raise NoSteadyState("the loop cannot be closed")

    monkeypatch.setattr("quickreturn.plugins.studies.sweep.rows.periodic_state", strayed)
    found = row([at(110.0)], MeasureRequest(measures=("peak.stress",)))
    assert (found.statuses, found.sentences) == ((NOT_CONVERGED,), ("no periodic state was found: the loop cannot be closed",))


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


def test_every_measure_has_a_unit_and_a_meaning() -> None:
    assert len(MEASURES) > 150
    assert all(each.unit and each.meaning and each.name == name for name, each in MEASURES.items())


@pytest.mark.verify
def test_the_other_engines_stand_by_the_points() -> None:
    scenes = [at(90.0), at(120.0), at(150.0)]
    names = ("peak.tip_acceleration", "peak.slider_force")
    ours = row(scenes, MeasureRequest(measures=names))
    for engine in ("mujoco", "exudyn"):
        other = row(scenes, MeasureRequest(measures=names, engine=engine))
        assert other.statuses == (Ending.SETTLED,) * 3
        assert np.all(np.abs(other.values - ours.values) <= other.errors + ours.errors)
