"""The explicit equations against the computer's derivation at random states far beyond what a run visits."""

import math

import numpy as np
import pytest

from quickreturn.plugins.derive.tests.reference.oracle_scene import (
    ABSENT,
    COMPILED,
    build,
    computed,
    draw_case,
    expected_cubic,
    expected_shapes,
    flexible,
    largest_difference,
    prescribed,
    state_vector,
)
from quickreturn.reference_model.shapes import hermite_elements
from quickreturn.reference_model.thesis.parameters import UnsuitableShapes, build_workspace

#: Every integral of the single cubic is exact and the 3 x 3 systems have condition numbers up to 1e4: rounding leaves 1e-13.
ROUNDING = 1e-10


@pytest.mark.parametrize("seed", range(24))
@pytest.mark.parametrize("present", [0.0, 0.5, 1.0])
def test_single_cubic_equals_the_computers_derivation(seed: int, present: float) -> None:
    lacking = ABSENT if seed % 4 == 3 else ABSENT[seed % len(ABSENT) :][:1] if seed % 4 == 2 else ()
    parameters, state = draw_case(seed, present=present, lacking=lacking)
    p, _shapes = build(parameters)
    found = computed(COMPILED, p, state_vector(p, state, *flexible(state)))
    difference, where = largest_difference(found, expected_cubic(parameters, state))
    assert difference < ROUNDING, where


@pytest.mark.parametrize("seed", range(6))
def test_prescribed_speed_holds_the_crank_and_names_its_torque(seed: int) -> None:
    parameters, state = draw_case(50 + seed, present=1.0, lacking=("crank_torque", "crank_damping"))
    p, expected = prescribed(parameters, state)
    found = computed(COMPILED, p, state_vector(p, state, *flexible(state)))
    difference, where = largest_difference(found, expected)
    assert difference < ROUNDING, where


@pytest.mark.parametrize(("elements", "finest"), [(1, 8), (2, 16)])
def test_exact_geometry_converges_to_the_oracle_with_the_quadrature(elements: int, finest: int) -> None:
    """The foreshortening is no polynomial then: six Gauss points a cell leave an error that falls at least like the cells' 6th power."""
    parameters, state = draw_case(1, present=1.0, lacking=("slider_inertia",) if elements == 2 else ())
    eta, eta_rate = flexible(state)
    if elements == 2:
        L = parameters["length"]
        middle = np.array([[1 / 2, -L / 8], [3 / (2 * L), -1 / 4]])  # deflection and slope of the cubic at L/2, bent further
        eta, eta_rate = np.r_[middle @ eta + [0.01, 0.02], eta], np.r_[middle @ eta_rate + [0.3, -2.0], eta_rate]
    expected = expected_shapes(parameters, state, hermite_elements(parameters["length"], elements), eta, eta_rate, exact=True)
    errors = []
    for cells in (finest // 4, finest // 2, finest):
        p, _shapes = build(parameters, elements=elements, exact=True, cells=cells)
        errors.append(largest_difference(computed(COMPILED, p, state_vector(p, state, eta, eta_rate)), expected)[0])
    # halving the cells divides the error by 64 or more until rounding (1e-12 with four flexible coordinates) is met
    assert errors[1] < max(errors[0] / 40, 1e-11)
    assert errors[2] < max(errors[1] / 40, 1e-11)
    assert errors[2] < 1e-10


def test_states_that_cannot_be_are_refused_with_nan() -> None:
    parameters, state = draw_case(0)
    p, _ = build(parameters, exact=True)
    w = build_workspace(p.tables)
    for eta in ([0.0, 1.2], [0.9 * p.L, 0.9], [math.nan, 0.0]):
        y = state_vector(p, state, np.array(eta), np.zeros(2))
        rate = np.zeros_like(y)
        assert not COMPILED.right_hand_side(p, w, y, rate, np.empty(0))
        assert np.all(np.isnan(rate))


def test_a_slider_with_inertia_needs_continuous_curvature() -> None:
    parameters, _ = draw_case(1, present=1.0)
    with pytest.raises(UnsuitableShapes, match="continuous curvature"):
        build(parameters, elements=2)
