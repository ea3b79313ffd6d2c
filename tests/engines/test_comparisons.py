"""What an error is estimated with: another model than that of the run, whatever settings are accepted."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from quickreturn.engines.base import Comparison, Engine, EngineFailure
from quickreturn.engines.error_parts import Compared, compared
from quickreturn.engines.own.thesis import THESIS_ERROR_PER_DECADE, ThesisEngine, ThesisSettings
from quickreturn.engines.settings import Settings
from quickreturn.plugins.methods.rivals import fixed_shapes, multiplier, nodal_load, stiff_spring
from quickreturn.plugins.methods.rivals.fixed_shapes import FixedShapesSettings
from quickreturn.plugins.methods.rivals.multiplier import MultiplierSettings
from quickreturn.plugins.methods.rivals.nodal_load import NodalLoadSettings
from quickreturn.plugins.methods.rivals.staying_shapes import ShapeSettings
from quickreturn.plugins.methods.rivals.stiff_spring import LEAST_STIFFNESS, MOST_DAMPING, MOST_STIFFNESS, StiffSpringSettings
from quickreturn.reference_model.slider import Slider
from tests.engines.scenes import run_24

numbers = st.integers(1, 64)
families = st.sampled_from(["clamped-free", "hermite"])
tolerances = st.floats(1e-12, 1e-2)


def pairs_of(engine: Engine, settings: Settings) -> tuple[Comparison, ...]:
    pairs = engine.comparisons(settings, run_24(), 1e-3)
    assert all(pair.run == settings != pair.other for pair in pairs)
    return pairs


def assert_finer_has_the_smaller_error(pair: Comparison, size: str) -> None:
    own, other = (getattr(settings, size) for settings in (pair.run, pair.other))
    assert other != own
    assert (pair.factor < 1.0) == (other > own)


@given(numbers, families, st.sampled_from([(fixed_shapes.ENGINE, FixedShapesSettings), (multiplier.ENGINE, MultiplierSettings)]))
def test_shapes_are_compared_with_other_numbers_of_them(shapes: int, family: str, chosen: tuple[Engine, type[ShapeSettings]]) -> None:
    engine, settings = chosen
    for pair in pairs_of(engine, settings(integrator="explicit", tolerance=1e-9, shapes=shapes, family=family)):
        assert_finer_has_the_smaller_error(pair, "shape_count")


@given(numbers, families, st.floats(LEAST_STIFFNESS, MOST_STIFFNESS), st.floats(0.0, MOST_DAMPING))
def test_springs_are_compared_with_other_shapes_and_springs_apart(shapes: int, family: str, stiffness: float, damping: float) -> None:
    settings = StiffSpringSettings(
        integrator="explicit", tolerance=1e-9, shapes=shapes, family=family, stiffness=stiffness, damping=damping
    )
    *of_shapes, of_spring = pairs_of(stiff_spring.ENGINE, settings)
    for pair in of_shapes:
        assert_finer_has_the_smaller_error(pair, "shape_count")
        assert (pair.other.stiffness, pair.other.damping) == (stiffness, damping)
    assert of_spring.other.shapes == shapes
    assert of_spring.factor == stiffness / of_spring.other.stiffness


def test_spring_of_a_compliant_joint_is_no_error() -> None:
    scene = run_24(slider=Slider(joint_stiffness=2e4))
    pairs = stiff_spring.ENGINE.comparisons(StiffSpringSettings(integrator="explicit", tolerance=1e-9), scene, 1e-3)
    assert len(pairs) == 2
    assert all(isinstance(pair.other, StiffSpringSettings) and pair.other.shapes < 12 for pair in pairs)


def test_spring_is_stiffened_and_shapes_are_added_as_the_parts_ask() -> None:
    engine, settings = (
        stiff_spring.ENGINE,
        StiffSpringSettings(integrator="explicit", tolerance=1e-9, shapes=12, stiffness=1e6, damping=30.0),
    )
    softer, fewer = (engine.finer(settings, {"modes": modes, "spring": spring}, 1e-3) for modes, spring in ((0.2, 3.0), (4.0, 0.1)))
    assert (softer.shapes, softer.stiffness / settings.stiffness) == (12, pytest.approx(8.0))
    assert softer.damping / settings.damping == pytest.approx(8.0)
    assert (fewer.shapes, fewer.stiffness) == (24, 1e6)


@given(st.integers(1, 64))
def test_elements_are_compared_with_other_numbers_of_them(elements: int) -> None:
    for pair in pairs_of(nodal_load.ENGINE, NodalLoadSettings(elements=elements, integrator="explicit", tolerance=1e-9)):
        for each in (pair, pair.instead or pair):
            assert_finer_has_the_smaller_error(each, "elements")


@given(tolerances)
def test_tolerances_are_compared_a_decade_apart(tolerance: float) -> None:
    (pair,) = pairs_of(ThesisEngine(), ThesisSettings(tolerance=tolerance))
    decade, error = pair.other.tolerance / tolerance, pair.factor
    assert max(decade, 1.0 / decade) > 9.999
    assert max(error, 1.0 / error) == THESIS_ERROR_PER_DECADE
    assert (decade > 1.0) == (error > 1.0)


@pytest.mark.parametrize(("first", "second"), [(1.0, 3.0), (3.0, 1.0)])
def test_of_two_pairs_that_show_the_same_part_the_larger_counts(first: float, second: float) -> None:
    besides = Compared(0.0, second, 3.0, of="the other")
    runs = Compared(0.0, first, 3.0, of="the one", besides=besides).mapped(lambda value: 2.0 * value)
    part = runs.part(lambda one, other: abs(one - other))
    assert (part.of, part.error) == ("the one" if first > second else "the other", 3.0)  # 6 / (3 - 1)
    assert runs.pairs == ((0.0, 2.0 * first), (0.0, 2.0 * second))


def test_the_other_pair_is_run_and_its_failure_is_one_of_the_estimate() -> None:
    own = ShapeSettings(shapes=4)
    pair = Comparison(own, own.replaced(shapes=6), 0.5, besides=Comparison(own, own.replaced(shapes=5), 0.8, of="passing"))

    def run(settings: Settings) -> int:
        if settings.shapes == broken:
            raise EngineFailure(0.0, "breaks down", "")
        return settings.shapes

    broken = 0
    assert compared(pair, own, run).pairs == ((4, 6), (4, 5))
    broken = 5
    with pytest.raises(EngineFailure):
        compared(pair, own, run)
