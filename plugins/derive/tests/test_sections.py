"""Beams with a section that varies, and their moments and shear."""

from typing import Any

import casadi as ca
import numpy as np
import pytest
from numpy.polynomial import Legendre, Polynomial

from quickreturn.derive import Beam, Model, Statics, System, natural_frequencies, natural_shapes, vector


def legendre(count: int, power: int = 2) -> list[Any]:
    """Shapes of a beam that is clamped at its beginning: Legendre's polynomials times a power of x/L."""
    bases = [Legendre.basis(k, [0, 1]).convert(kind=Polynomial).coef for k in range(count)]
    return [lambda u, basis=basis: sum(float(c) * u ** (k + power) for k, c in enumerate(basis)) for basis in bases]


def cantilever(shapes: list[Any], **given: Any) -> tuple[System, Any, Beam]:
    """A beam of 1 m under a force of 1 N at its end."""
    system = System("cantilever")
    p = system.constants(L=(1, "m"), EI=(10, "N*m^2"), mu=(0.5, "kg/m"), F=(1, "N"), E=(70, "GPa"), rho=(2700, "kg/m^3"))
    eta = system.amplitudes("eta", len(shapes), "m", size=0.01)
    varying = {"mass_per_length": p.mu, "bending_stiffness": p.EI} | {name: value(system, p) for name, value in given.items()}
    beam = Beam(
        system, "rod", origin=vector(0, 0), angle=0, edges=[0, p.L], points=2 * len(shapes) + 6, foreshortening=False,
        deflection=lambda x: sum(eta[k] * shape(x / p.L) for k, shape in enumerate(shapes)), **varying,
    )  # fmt: skip
    system.load("end", beam.end(), vector(0, p.F))
    system.output("end", beam.end()[1], "mm")
    return system, p, beam


def test_a_cone_has_its_deflection_and_its_frequencies() -> None:
    """From 10 to 5 mm: F L^3 / (3 E I0) r0 / r1; frequencies by Bessel's functions of order 2 (G. Kirchhoff 1879)."""

    def area(p: Any, x: Any) -> Any:
        return np.pi * (0.01 * p.L - 0.005 * x) ** 2

    system, _, _ = cantilever(
        legendre(8), mass_per_length=lambda _, p: lambda x: p.rho * area(p, x),
        bending_stiffness=lambda _, p: lambda x: p.E / (4 * np.pi) * area(p, x) ** 2,
    )  # fmt: skip
    model = Model(system)
    end = Statics(model).equilibrium({}).outputs["end"]
    assert end == pytest.approx(1e3 / (3 * 70e9 * np.pi / 4 * 0.01**4) * 2, rel=1e-5)
    free = natural_frequencies(model, {}, parameters={"F": 0.0})[:3]
    np.testing.assert_allclose(free, [18.74058397, 79.20471038, 196.83618746], rtol=1e-6)


def test_a_stiffness_by_points() -> None:
    """Linear from EI to EI / 2: the end moves by F L^3 / EI (2 ln 2 - 1)."""
    system, _, _ = cantilever(legendre(7), bending_stiffness=lambda s, p: s.table("EI", ([0, 1], "m"), ([10, 5], "N*m^2")))
    assert Statics(Model(system)).equilibrium({}).outputs["end"] == pytest.approx(1e2 * (2 * np.log(2.0) - 1), rel=1e-6)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("shapes", [legendre(2), [*natural_shapes("clamped-free", 3), lambda u: u**2 * (3 - u)]])
def test_moment_and_shear_under_a_force_at_the_end(shapes: list[Any]) -> None:
    system, p, beam = cantilever(shapes)
    for k, part in enumerate((0.0, 0.3, 1.0)):
        system.output(f"moment_{k}", beam.moment(part * p.L), "N*m")
        system.output(f"shear_{k}", beam.shear(part * p.L), "N")
    found = Statics(Model(system)).equilibrium({}).outputs
    expected = {"moment_0": 1.0, "moment_1": 0.7, "moment_2": 0.0, "shear_0": 1.0, "shear_1": 1.0, "shear_2": 1.0}
    assert {name: found[name] for name in expected} == pytest.approx(expected, abs=1e-6)


@pytest.mark.parametrize(("supports", "count"), [("clamped-free", 1), ("pinned-pinned", 3), ("free-free", 5), ("clamped-free", 9)])
def test_natural_shapes_are_told_to_have_no_shear(supports: str, count: int) -> None:
    _, _, beam = cantilever(natural_shapes(supports, count))
    with pytest.warns(UserWarning, match="the shapes of beam 'rod' of 'cantilever' are natural ones: they do not have the shear") as caught:
        beam.shear(0)
    assert caught[0].filename == __file__


def test_a_taper_tells_that_few_shapes_have_its_shear_roughly() -> None:
    """From 30 to 12 mm of height: six polynomials are off by two fifths at the root, where the deflection is right to 1e-4."""

    def stiffness(_: System, p: Any) -> Any:
        return lambda x: p.EI * (1 - 0.6 * x / p.L) ** 3

    shears = {}
    for count in (6, 10):
        system, _, beam = cantilever(legendre(count), bending_stiffness=stiffness)
        with pytest.warns(UserWarning, match="the stiffness of beam 'rod' of 'cantilever' varies along it: few shapes have"):
            system.output("shear", beam.shear(0), "N")
        shears[count] = Statics(Model(system)).equilibrium({}).outputs["shear"]
    assert 0.3 < shears[6] - 1.0 < 0.5
    assert abs(shears[10] - 1.0) < 0.02


def test_the_moment_at_the_root_of_a_moving_beam_is_that_of_its_clamp() -> None:
    """The loop that turns the root has the moment by the balance of inertia and gravity, the beam by its curvature."""
    system, shapes = System("swung"), legendre(5, power=1)
    p = system.constants(L=(1, "m"), EI=(10, "N*m^2"), mu=(0.5, "kg/m"), rate=(6, "rad/s"), size=(0.5, "rad"))
    system.gravity = vector(0, -9.81)
    root, eta = system.coordinate("root", "rad"), system.amplitudes("eta", 5, "rad", size=0.01)
    beam = Beam(
        system, "rod", origin=vector(0, 0), angle=root, edges=[0, p.L], points=10, mass_per_length=p.mu, bending_stiffness=p.EI,
        tangent=lambda x: sum(eta[k] * shape(x / p.L) for k, shape in enumerate(shapes)),
    )  # fmt: skip
    system.loop("clamp", root - p.size * (1 - ca.cos(p.rate * system.time)), "rad", gives=[root])
    system.output("moment", beam.moment(0), "N*m")
    model = Model(system)
    found = model.simulate(Statics(model).equilibrium({}), 1.0, 0.01)
    size = float(found["clamp_force"].abs().max())
    np.testing.assert_allclose(-found["moment"] / size, found["clamp_force"] / size, atol=2e-3)  # five shapes leave 7e-4
