"""Studies beside the 24 runs."""

from dataclasses import replace

from quickreturn.cases.benchmark.methods import Method
from quickreturn.cases.case_file import load_case
from quickreturn.cases.studies import convergence
from quickreturn.engines.error_parts import ESTIMATED
from quickreturn.engines.own.fixed_shapes import FixedShapesEngine, FixedShapesSettings


def test_errors_fall_towards_the_finest_settings() -> None:
    ladder = [FixedShapesSettings(shapes=shapes, tolerance=tolerance) for shapes in (4, 6, 12) for tolerance in (1e-6, 1e-8)]
    case = replace(load_case("thesis-24"), duration=0.3)
    found = convergence(Method("fixed-shapes", FixedShapesEngine(), tuple(ladder)), case)
    for channel in ESTIMATED:
        errors = [point.error(channel) or 0.0 for point in found]
        assert errors[-1] == 0.0
        assert errors[1] > errors[3] > 0.0  # the tighter tolerance
