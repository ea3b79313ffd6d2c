"""Studies beside the 24 runs."""

import pytest

from quickreturn.cases.case_file import load_case
from quickreturn.cases.studies import ACCURACY_CASE, PRESCRIBED_CASE, convergence, prescribed_speed
from quickreturn.engines.accurate import ESTIMATED
from quickreturn.engines.own.fixed_shapes import FixedShapesEngine, FixedShapesSettings
from tests.engines.scenes import run_24


def test_errors_fall_towards_the_finest_settings() -> None:
    ladder = [FixedShapesSettings(shapes=shapes, tolerance=tolerance) for shapes in (4, 6, 12) for tolerance in (1e-6, 1e-8)]
    found = convergence(FixedShapesEngine(), run_24(), ladder, 0.3, 1e-3)
    assert [run.is_reference for run in found] == [False] * 5 + [True]
    assert set(found[-1].errors.values()) == {0.0}
    for channel in ESTIMATED:
        assert found[1].errors[channel] > found[3].errors[channel] > 0.0  # the tighter tolerance


def test_a_prescribed_speed_and_a_linear_beam_each_have_their_own_error() -> None:
    """Over 0.6 s; a model's error is against the exact one at the same speed, its estimate of the integration alone."""
    driven, prescribed = (load_case(name).mechanism for name in (ACCURACY_CASE, PRESCRIBED_CASE))
    exact, linear, foreshortened = prescribed_speed(driven, 0.6, 2e-3, prescribed)
    assert exact.errors["tip_deflection"] == pytest.approx(0.158, rel=0.02)
    assert linear.errors["tip_deflection"] == pytest.approx(0.0343, rel=0.02)
    assert foreshortened.errors["tip_deflection"] < 0.5 * linear.errors["tip_deflection"]
    for run in (linear, foreshortened):
        assert 0.0 < run.error_estimate < 1e-4  # type: ignore[operator]
