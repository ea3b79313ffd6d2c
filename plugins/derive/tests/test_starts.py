"""Starts that a check must not refuse: equilibria, where forces cancel, and shapes of many families; and what it must refuse."""

import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.polynomial import Polynomial, legendre

from quickreturn.derive import Beam, DescriptionError, Model, Statics, System, natural_frequencies, natural_shapes, turned, vector
from quickreturn.plugins.derive.tests.descriptions import described
from quickreturn.plugins.derive.tests.linkages import four_bar

Shape = Callable[[Any], Any]


def powers(count: int) -> list[Shape]:
    return [lambda u, k=k: u ** (k + 2) for k in range(count)]  # type: ignore[misc]


def orthogonal(count: int) -> list[Shape]:
    """Legendre's polynomials times the square of x/L."""
    held = Polynomial([0.0, 0.0, 1.0])
    shapes = [(held * legendre.Legendre.basis(k, domain=[0.0, 1.0]).convert(kind=Polynomial)).coef for k in range(count)]
    return [lambda u, c=c: sum(float(a) * u**j for j, a in enumerate(c)) for c in shapes]  # type: ignore[misc]


def cantilever(shapes: list[Shape], length: float, stiffness: float, mass: float, force: float, gravity: float) -> System:
    system = System("cantilever")
    system.gravity = vector(0, -gravity)
    p = system.constants(L=(length, "m"), EI=(stiffness, "N*m^2"), mu=(mass, "kg/m"), F=(force, "N"))
    eta = system.amplitudes("eta", len(shapes), "m", size=0.01 * length)
    beam = Beam(
        system, "beam", origin=vector(0, 0), angle=0, edges=[0, p.L / 2, p.L], points=8, foreshortening=False,
        deflection=lambda x: sum(eta[k] * shape(x / p.L) for k, shape in enumerate(shapes)),
        mass_per_length=p.mu, bending_stiffness=p.EI,
    )  # fmt: skip
    system.load("tip", beam.end(), vector(0, -p.F))
    system.output("tip_y", beam.end()[1], "mm")
    return system


@pytest.mark.parametrize("family", [powers, orthogonal, lambda count: natural_shapes("clamped-free", count)])
@pytest.mark.parametrize("seed", [1, *(pytest.param(k, marks=pytest.mark.verify) for k in (0, *range(2, 8)))])
def test_a_generated_cantilever_stays_in_its_equilibrium(family: Callable[[int], list[Shape]], seed: int) -> None:
    """The closed form is F L^3/(3 EI) + mu g L^4/(8 EI), which polynomials hold exactly."""
    random = np.random.default_rng(seed)
    count = int(random.integers(3, 5))
    length, stiffness, mass, force = (float(10.0 ** random.uniform(*each)) for each in ((-2, 1), (-3, 5), (-3, 2), (-3, 3)))
    gravity = float(random.choice([0.0, 9.81]))
    # a deflection of some per cent of the length
    scale = 0.03 * length / (force * length**3 / (3 * stiffness) + mass * gravity * length**4 / (8 * stiffness))
    stiffness /= scale
    model = Model(cantilever(family(count), length, stiffness, mass, force, gravity))
    rest = Statics(model).equilibrium({})
    sag = 1e3 * (force * length**3 / (3 * stiffness) + mass * gravity * length**4 / (8 * stiffness))
    # natural shapes have no moment's slope at the end that a force makes there: 3 leave 0.3 %
    exact = family in (powers, orthogonal) and (count > 2 + (gravity > 0) or not gravity)
    assert rest.outputs["tip_y"] == pytest.approx(-sag, rel=1e-8 if exact else 1e-2)
    period = 2 * np.pi / 3.516 * np.sqrt(mass * length**4 / stiffness)
    found = model.simulate(rest, 0.2 * float(period), 0.1 * float(period))
    np.testing.assert_allclose(found["tip_y"], rest.outputs["tip_y"], rtol=1e-7)


def test_a_four_bar_closes_in_the_way_that_its_guess_is_near() -> None:
    """It closes in two ways at a crank angle."""
    model, pin = Model(four_bar((1.0, 0.4, 0.9, 0.8), (1.0, 2.0, 1.5))), 0.4 * np.exp(0.5j)
    chord, c = 1.0 - pin, abs(1.0 - pin)
    along = (0.9**2 - 0.8**2 + c**2) / (2.0 * c)
    for side in (1, -1):
        joint = pin + chord / c * (along + side * 1j * np.sqrt(0.9**2 - along**2))
        right = np.array([np.angle(joint - pin), np.angle(joint - 1.0)])
        for guess in right + np.random.default_rng(0).uniform(-0.3, 0.3, (5, 2)):
            model.system.coordinates[1:] = [c._replace(guess=g) for c, g in zip(model.system.coordinates[1:], guess, strict=True)]
            np.testing.assert_allclose(np.exp(1j * model.start({"crank": 0.5})[1:3]), np.exp(1j * right), atol=1e-9)


def test_an_unstable_equilibrium_has_a_frequency_below_zero() -> None:
    """Two links with springs in their hinges, a load along them: it buckles at k/L (3 - sqrt 5)/2, the columns of textbooks."""
    system = System("column")
    p = system.constants(k=(10.0, "N*m/rad"), length=(0.5, "m"), mass=(1.0, "kg"), load=(0.0, "N"))
    one, two = system.coordinate("one", "rad"), system.coordinate("two", "rad")
    middle = turned(one, p.length)
    top = middle + turned(two, p.length)
    system.body("middle", p.mass, middle)
    system.body("top", p.mass, top)
    system.spring("foot", one, p.k)
    system.spring("knee", two - one, p.k)
    system.load("weight", top, vector(-p.load, 0))
    model, critical = Model(system), 10.0 / 0.5 * (3.0 - np.sqrt(5.0)) / 2.0
    for part in (0.999, 1.001):
        changed = {"load": part * critical}
        rest = Statics(model, parameters=changed).equilibrium({})
        assert (natural_frequencies(model, rest, parameters=changed)[0] > 0.0) == (part < 1.0)


def test_frequencies_where_forces_move_the_system_are_told() -> None:
    """A pendulum at 57 degrees; a wheel with a motor, at any angle."""
    system = System("pendulum")
    system.gravity = vector(0, -9.81)
    p = system.constants(mass=(1.0, "kg"), length=(1.0, "m"), torque=(0.0, "N*m"))
    angle, wheel = system.coordinate("angle", "rad"), system.coordinate("wheel", "rad")
    system.body("bob", p.mass, turned(angle, 0.0, -p.length))
    system.body("wheel", inertia=p.mass * p.length**2, angle=wheel)
    system.load("motor", wheel, p.torque)
    model = Model(system)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        np.testing.assert_allclose(natural_frequencies(model, {}), [0.0, np.sqrt(9.81) / (2 * np.pi)], atol=1e-12)
        natural_frequencies(model, {}, hold=["wheel"], parameters={"torque": 1.0})
    for at, torque, name in (({"angle": 1.0}, 0.0, "angle"), ({}, 1.0, "wheel")):
        with pytest.warns(UserWarning, match=f"'pendulum' is not at rest there: forces move '{name}'"):
            natural_frequencies(model, at, parameters={"torque": torque})


@pytest.mark.parametrize("count", [8, *(pytest.param(each, marks=pytest.mark.verify) for each in (9, 12))])
def test_shapes_that_are_nearly_alike_are_named(count: int) -> None:
    model = Model(described("spin_up").spin_up(count))
    sentence = (
        r"the inertias of ('eta_\d+', )+'eta_\d+' of 'spin-up' are nearly alike \(condition of the mass matrix \de\+1\d\): rounding is in"
        r" the way of a tolerance below \S+; take shapes that differ more, such as Legendre polynomials or"
        r" natural_shapes"
    )
    with pytest.raises(DescriptionError, match=sentence):
        model.simulate({"eta_1": 0.05}, 1.0, 0.5)


@pytest.mark.parametrize("scale", [1e-9, 1.0, 1e6])
def test_a_loop_of_lengths_closes_as_well_in_a_machine_of_any_size(scale: float) -> None:
    """A bead on a circle, its height given: the search ends by the coordinate's size."""
    system = System("bead on a circle")
    u = system.constants(m=(scale, "m"), kg=(1.0, "kg"))
    x, y = (system.coordinate(name, "m", size=scale, guess=0.6 * scale) for name in "xy")
    system.body("bead", u.kg, vector(x, y))
    system.loop("circle", x**2 + y**2 - u.m**2, "m^2", gives=[x])
    assert Model(system).start({"y": 0.28 * scale})[0] / scale == pytest.approx(0.96, rel=1e-14)
