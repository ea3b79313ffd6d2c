"""The curvature of a cable between its nodes, against closed forms."""

import numpy as np
import pytest

from quickreturn.engines.exudyn.cable import Cable, Kink


@pytest.mark.parametrize("x", [0.0, 0.02, 0.1, 0.33, 0.5, 0.999, 1.0])
def test_curvature_is_of_third_order_anywhere_and_better_inside(x):
    """The plane curve r = (x, x³/3 - x⁵/20), given exactly at the nodes."""
    slope = x**2 - x**4 / 4
    exact = (2 * x - x**3) / (1 + slope**2)
    errors = []
    for elements in (16, 32):
        cable = Cable(1.0, elements, 1.0, 1.0, 1.0)
        nodes = cable.nodes
        q = np.column_stack([nodes, nodes**3 / 3 - nodes**5 / 20, np.ones_like(nodes), nodes**2 - nodes**4 / 4])[None]
        errors.append(abs(cable.curvatures(q, np.array([[x]]))[0, 0] - exact))
    h = 1 / 16
    # inside, r'' is exact to the fifth degree and between nodes the slope is the cubic's, third order with a small factor;
    # in the first and last element r'' at the very end errs by a twelfth of h³ times the fifth derivative
    assert errors[0] < (h**3 / 100 if h < x < 1 - h else h**3)
    assert errors[1] < max(1e-9, errors[0] / 5)


@pytest.mark.parametrize("x", [0.05, 0.33, 0.5, 0.512])
@pytest.mark.parametrize("place", [0.5, 0.515, 0.53, 0.9])
def test_curvature_has_the_kink_of_a_point_force(x, place):
    """The line of the test above with a jump in its third derivative, given exactly at the nodes, and kinks in rows of their own."""
    jump, beyond = 3.0, max(0.0, x - place)
    bent, slope = 2 * x - x**3 + jump * beyond, x**2 - x**4 / 4 + jump * beyond**2 / 2
    exact = bent / (1 + slope**2)
    cable = Cable(1.0, 32, 1.0, 1.0, 1.0)
    nodes, kinks = cable.nodes, np.array([place, 0.8])
    levers = np.maximum(0.0, nodes - kinks[:, None])
    lines = nodes**3 / 3 - nodes**5 / 20 + jump * levers**3 / 6, nodes**2 - nodes**4 / 4 + jump * levers**2 / 2
    q = np.stack([np.broadcast_to(nodes, levers.shape), lines[0], np.ones_like(levers), lines[1]], axis=2)
    kink = Kink(kinks, np.array([[0.0, jump], [0.0, jump]]))
    places = np.full((1, 2), x)
    found, rounded_off = (cable.curvatures(q, places, *known)[0, 0] - exact for known in ((kink,), ()))
    assert abs(found) < 1e-4 * abs(exact)  # the slope, a cubic's, misses 2e-5 of it at most
    assert abs(rounded_off) > 10 * abs(found) or abs(x - place) > 2 / 32
