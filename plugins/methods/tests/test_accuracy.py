"""Studies beside the 24 runs."""

from dataclasses import replace
from pathlib import Path

import pytest

from quickreturn.cases.files.case_file import load_case
from quickreturn.cases.running.in_process import Nobody
from quickreturn.cases.running.store import Store
from quickreturn.cases.running.workshop import Workshop
from quickreturn.engines.error_parts import ESTIMATED
from quickreturn.engines.registry import MAIN
from quickreturn.plugins.methods.accuracy import convergence, run_studies, work
from quickreturn.plugins.methods.rivals import fixed_shapes
from quickreturn.plugins.methods.rivals.fixed_shapes import FixedShapesSettings
from quickreturn.plugins.methods.trials.methods import Method


def test_errors_fall_towards_the_finest_settings() -> None:
    ladder = [FixedShapesSettings(shapes=shapes, tolerance=tolerance) for shapes in (4, 6, 12) for tolerance in (1e-6, 1e-8)]
    case = replace(load_case("thesis-24"), duration=0.3)
    found = convergence(Method("fixed-shapes", fixed_shapes.ENGINE, tuple(ladder)), case)
    for channel in ESTIMATED:
        errors = [trial.error_of(channel) or 0.0 for trial in found]
        assert errors[-1] == 0.0
        assert errors[1] > errors[3] > 0.0  # the tighter tolerance


@pytest.mark.parametrize("engines", [(name,) for name in MAIN] + [("reference", "mujoco"), ("fixed-shapes",), MAIN])
def test_studies_of_some_engines_ask_no_others(tmp_path: Path, engines: tuple[str, ...]) -> None:
    """Of all main engines they are whole, with the models that need a prescribed speed."""
    planned, further = work(engines), ("moving-boundaries",) if engines == MAIN else ()
    asked = {name for job in planned.jobs for name in job.engines} | {request.engine for request in planned.requests.values()}
    assert asked == {*engines, *further} - {"fixed-shapes"}
    without = run_studies(Workshop(Store(tmp_path), Nobody()), engines)  # nothing is computed: each failure is of a part that was asked for
    assert len(without.failures) == len(planned.requests) / 2


@pytest.mark.verify
def test_a_prescribed_speed_and_a_linear_beam_each_have_their_own_error() -> None:
    """Of a model the error against the exact one at the same speed, beside its estimate, which is of the integration alone."""
    found = run_studies(Workshop(Store()))
    assert found.failures == []
    assert found.prescribed is not None
    linear, foreshortened = found.prescribed.runs
    changes = [found.prescribed.changed, linear.errors, foreshortened.errors]
    assert [each["tip_deflection"] for each in changes] == pytest.approx([0.179, 0.0587, 0.0100], rel=5e-3)
    for run in found.prescribed.runs:
        assert 0.0 < run.claim < 1e-4  # type: ignore[operator]
