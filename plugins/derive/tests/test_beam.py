"""Beams: natural shapes against closed forms, and bending that is too large for a deflection."""

import warnings

import numpy as np
import pytest

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


def beam(supports: str, count: int = 3, points: int = 14) -> System:
    system = System("beam")
    p = system.constants(length=(LENGTH, "m"), mass=(MASS_PER_LENGTH, "kg/m"), stiffness=(STIFFNESS, "N*m^2"))
    eta, shapes = system.amplitudes("eta", count, "m", size=0.01), natural_shapes(supports, count)
    Beam(
        system, "strip", origin=vector(0, 0), angle=0, edges=[0, p.length], points=points,
        deflection=lambda x: sum(eta[k] * shapes[k](x / p.length) for k in range(count)),
        foreshortening=False, mass_per_length=p.mass, bending_stiffness=p.stiffness,
    )  # fmt: skip
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


@pytest.mark.parametrize(("supports", "count", "points"), [*((supports, 3, 14) for supports in ROOTS), ("clamped-free", 6, 10)])
@pytest.mark.filterwarnings("error")
def test_natural_shapes_have_the_frequencies_of_the_uniform_beam(supports: str, count: int, points: int) -> None:
    found = natural_frequencies(Model(beam(supports, count, points)), {})[:3]
    expected = np.array(ROOTS[supports]) ** 2 / (2 * np.pi * LENGTH**2) * np.sqrt(STIFFNESS / MASS_PER_LENGTH)
    # ten digits; polynomials of degree eleven and more leave 1e-7 of the third; of zero the root of rounding is left
    np.testing.assert_allclose(found, expected, rtol=1e-6 if count == 3 else 1e-4, atol=1e-4)


@pytest.mark.parametrize(("count", "points"), [(5, 6), (6, 6), (8, 10)])
def test_too_few_points_for_the_shapes_are_told(count: int, points: int) -> None:
    """Six shapes at six points have a first frequency that is 12 % too low and a second one that is 78 % too low."""
    with pytest.warns(UserWarning, match="the Gauss points of beam 'strip' of 'beam' are too few for its shapes"):
        Model(beam("clamped-free", count, points))
