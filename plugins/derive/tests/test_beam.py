"""Beams: natural shapes, large bending, and what a section gives, against closed forms."""

import warnings

import casadi as ca
import numpy as np
import pytest
from scipy.integrate import solve_bvp

from quickreturn.derive import Beam, Model, Statics, System, natural_frequencies, natural_shapes, vector

LENGTH, MASS_PER_LENGTH, STIFFNESS = 0.8, 0.3, 4.0
#: First roots of the frequency equations of the uniform beam (W. C. Young, Roark's Formulas, chapter 16), to the digits printed here.
ROOTS = {
    "clamped-free": [1.8751040687, 4.6940911330, 7.8547574382],
    "pinned-pinned": [np.pi, 2 * np.pi, 3 * np.pi],
    "clamped-clamped": [4.7300407449, 7.8532046241, 10.9956078380],
    "clamped-pinned": [3.9266023120, 7.0685827456, 10.2101761228],
    "pinned-free": [0.0, 3.9266023120, 7.0685827456],
    "free-free": [0.0, 0.0, 4.7300407449],
}


def beam(supports: str, count: int = 3, load: bool = False) -> System:
    system = System("beam")
    p = system.constants(length=(LENGTH, "m"), mass=(MASS_PER_LENGTH, "kg/m"), stiffness=(STIFFNESS, "N*m^2"), force=(0, "N"))
    eta, shapes = system.amplitudes("eta", count, "m", size=0.01), natural_shapes(supports, count)

    def deflection(x: ca.SX) -> ca.SX:
        return sum(eta[k] * shapes[k](x / p.length) for k in range(count))

    strip = Beam(
        system, "strip", origin=vector(0, 0), angle=0, edges=[0, p.length], points=14,
        deflection=deflection, foreshortening=False, mass_per_length=p.mass, bending_stiffness=p.stiffness,
    )  # fmt: skip
    system.output("end", strip.end()[1], "m")
    return system


@pytest.mark.parametrize(("load", "told"), [(0.5, ""), (1.0, "by about 12 %"), (3.78, "by about 1.8e+02 %")])
def test_a_beam_that_bends_too_far_for_its_deflection_is_told(load: float, told: str) -> None:
    """Under F = load EI/L^2 the cubic has a slope of load/2 at the end, and hangs by load/3 of its length: 504 mm of 400."""
    system = System("rod")
    u = system.constants(m=(1.0, "m"), kg=(1.0, "kg"), s=(1.0, "s"), load=(load, "1"))
    w = system.coordinate("w", "m")
    rod = Beam(
        system, "strip", origin=vector(0, 0), angle=0, edges=[0, 0.4 * u.m],
        deflection=lambda x: w * (3 * (x / u.m) ** 2 / 0.32 - (x / u.m) ** 3 / 0.128),
        mass_per_length=u.kg / u.m, bending_stiffness=u.kg * u.m**3 / u.s**2, foreshortening=False,
    )  # fmt: skip
    system.load("end", rod.end()[1], u.load / 0.16 * u.kg * u.m / u.s**2)
    model = Model(system)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        rest = Statics(model).equilibrium({})
        model.simulate(rest, 0.01, 0.01)
    assert rest["w"] == pytest.approx(0.4 * load / 3)
    assert len(caught) == (2 if told else 0)
    assert all("beam 'strip' of 'rod' has a slope of" in str(each.message) and told in str(each.message) for each in caught)


@pytest.mark.parametrize("supports", ROOTS)
def test_natural_shapes_have_the_frequencies_of_the_uniform_beam(supports: str) -> None:
    found = natural_frequencies(Model(beam(supports)), {})
    expected = np.array(ROOTS[supports]) ** 2 / (2 * np.pi * LENGTH**2) * np.sqrt(STIFFNESS / MASS_PER_LENGTH)
    # ten digits; polynomials of degree eleven and more leave 1e-7 of the third; of zero the root of rounding is left
    np.testing.assert_allclose(found, expected, rtol=1e-6, atol=1e-4)


def test_a_cantilever_bent_by_its_tip_is_the_elastica() -> None:
    """EI theta'' = -F cos theta, theta(0) = theta'(L) = 0, solved as a boundary value problem."""
    force, count = 20.0, 7
    system = System("elastica")
    p = system.constants(length=(LENGTH, "m"), mass=(MASS_PER_LENGTH, "kg/m"), stiffness=(STIFFNESS, "N*m^2"))
    eta = system.amplitudes("eta", count, "rad")
    strip = Beam(
        system, "strip", origin=vector(0, 0), angle=0, edges=[0, p.length / 2, p.length], points=8,
        tangent=lambda x: sum(eta[k] * (x / p.length) ** (k + 1) for k in range(count)),
        mass_per_length=p.mass, bending_stiffness=p.stiffness,
    )  # fmt: skip
    load = system.constants(force=(force, "N"))
    system.load("pull", strip.end(), vector(0, load.force))
    rest = Statics(Model(system)).equilibrium({})
    x = np.linspace(0.0, LENGTH, 41)
    exact = solve_bvp(
        lambda x, y: np.array([y[1], -force / STIFFNESS * np.cos(y[0])]),
        lambda a, b: np.array([a[0], b[1]]),
        x,
        np.zeros((2, 41)),
        tol=1e-10,
    )
    angle = sum(rest[f"eta_{k + 1}"] * (x / LENGTH) ** (k + 1) for k in range(count))
    assert exact.sol(LENGTH)[0] > 0.8
    # a polynomial of degree seven
    np.testing.assert_allclose(angle, exact.sol(x)[0], atol=1e-6)
