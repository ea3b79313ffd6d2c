"""Studies beside the 24 runs."""

from quickreturn.cases.studies import convergence
from quickreturn.engines.error_parts import ESTIMATED
from quickreturn.engines.own.fixed_shapes import FixedShapesEngine, FixedShapesSettings
from tests.engines.scenes import run_24


def test_errors_fall_towards_the_finest_settings() -> None:
    ladder = [FixedShapesSettings(shapes=shapes, tolerance=tolerance) for shapes in (4, 6, 12) for tolerance in (1e-6, 1e-8)]
    found = convergence(FixedShapesEngine(), run_24(), ladder, 0.3, 1e-3)
    assert [run.is_reference for run in found] == [False] * 5 + [True]
    assert set(found[-1].errors.values()) == {0.0}
    for channel in ESTIMATED:
        assert found[1].errors[channel] > found[3].errors[channel] > 0.0  # the tighter tolerance
