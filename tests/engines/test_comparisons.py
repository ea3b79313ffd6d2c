"""What an error is estimated with: another model than that of the run, whatever settings are accepted."""

from hypothesis import given
from hypothesis import strategies as st

from engines.base import Comparison, Engine
from engines.own.fixed_shapes import FixedShapesEngine, FixedShapesSettings
from engines.own.multiplier import MultiplierEngine, MultiplierSettings
from engines.own.nodal_load import NodalLoadEngine, NodalLoadSettings
from engines.own.staying_shapes import fewer_shapes
from engines.own.stiff_spring import StiffSpringEngine, StiffSpringSettings
from engines.own.thesis import THESIS_ERROR_PER_DECADE, ThesisEngine, ThesisSettings
from engines.settings import Settings
from tests.engines.scenes import run_24

numbers = st.integers(1, 64)
families = st.sampled_from(["clamped-free", "hermite"])
tolerances = st.floats(1e-12, 1e-2)


def pair_of(engine: Engine, settings: Settings) -> Comparison:
    (pair,) = engine.comparisons(settings, run_24(), 1e-3)
    assert pair.run == settings
    return pair


def assert_finer_has_the_smaller_error(pair: Comparison, own: int, other: int) -> None:
    assert other != own
    assert (pair.factor < 1.0) == (other > own)


@given(numbers, families)
def test_fixed_shapes_are_compared_with_another_number_of_shapes(shapes: int, family: str) -> None:
    engine = FixedShapesEngine()
    pair = pair_of(engine, FixedShapesSettings(shapes=shapes, family=family))
    assert_finer_has_the_smaller_error(pair, *(engine.shape_count(run_24(), each) for each in (pair.run, pair.other)))


@given(numbers, families)
def test_multipliers_are_compared_with_another_number_of_shapes(shapes: int, family: str) -> None:
    pair = pair_of(MultiplierEngine(), MultiplierSettings(shapes=shapes, family=family))
    assert_finer_has_the_smaller_error(pair, *(MultiplierEngine().shape_count(run_24(), each) for each in (pair.run, pair.other)))


@given(numbers, families, st.floats(1e3, 1e9))
def test_springs_are_compared_with_another_number_of_shapes_on_a_stiffer_one(shapes: int, family: str, stiffness: float) -> None:
    pair = pair_of(StiffSpringEngine(), StiffSpringSettings(shapes=shapes, family=family, stiffness=stiffness))
    assert_finer_has_the_smaller_error(pair, *(StiffSpringEngine().shape_count(run_24(), each) for each in (pair.run, pair.other)))
    assert isinstance(pair.other, StiffSpringSettings)
    assert pair.other.stiffness == min(2.0 * stiffness, 1e9)


@given(st.integers(1, 32))
def test_elements_are_compared_with_another_number_of_them(elements: int) -> None:
    pair = pair_of(NodalLoadEngine(), NodalLoadSettings(elements=elements))
    assert isinstance(pair.other, NodalLoadSettings)
    assert_finer_has_the_smaller_error(pair, elements, pair.other.elements)


@given(tolerances)
def test_tolerances_are_compared_a_decade_apart(tolerance: float) -> None:
    pair = pair_of(ThesisEngine(), ThesisSettings(tolerance=tolerance))
    assert isinstance(pair.other, ThesisSettings)
    decade, error = pair.other.tolerance / tolerance, pair.factor
    assert max(decade, 1.0 / decade) > 9.999
    assert max(error, 1.0 / error) == THESIS_ERROR_PER_DECADE
    assert (decade > 1.0) == (error > 1.0)


@given(numbers, families)
def test_fewer_shapes_are_of_the_family(shapes: int, family: str) -> None:
    other, _ = fewer_shapes(shapes, family)
    assert 1 <= other <= 64
    assert family != "hermite" or other % 2 == 0
