"""Arguments of a wrong kind or shape: each gets one sentence, where CasADi would broadcast, drop or misread it."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from quickreturn.derive import Beam, DescriptionError, Model, System, natural_frequencies, natural_shapes, turned, vector


def pendulum() -> tuple[System, Any, Any]:
    system = System("pendulum")
    p = system.constants(length=(1, "m"), mass=(2, "kg"), force=(3, "N"), stiffness=(4, "N*m/rad"))
    angle = system.coordinate("angle", "rad")
    system.body("bob", p.mass, turned(angle, p.length))
    return system, p, angle


def beam(system: System, p: Any, **changed: Any) -> Beam:
    given = {"deflection": lambda x: p.length * (x / p.length) ** 2, "edges": [0, p.length]} | changed
    return Beam(system, "arm", origin=vector(0, 0), angle=0, mass_per_length=p.mass / p.length, **given)


def foreign(system: System, p: Any, angle: Any) -> None:
    _, _, twin = pendulum()
    system.spring("spring", angle - twin, p.stiffness)
    Model(system)


def scalar_gravity(system: System, p: Any, angle: Any) -> None:
    system.gravity = 9.81  # type: ignore[assignment]
    Model(system)


WRONG: dict[str, Callable[[System, Any, Any], Any]] = {
    "constant 'height' of 'pendulum' is 3; give a finite number and its unit": lambda s, p, a: s.constants(height=3),  # type: ignore[arg-type]
    "constant 'height' of 'pendulum' is (nan, 'm')": lambda s, p, a: s.constants(height=(np.nan, "m")),
    "constant 'height' of 'pendulum' is ('3', 'm')": lambda s, p, a: s.constants(height=("3", "m")),  # type: ignore[arg-type]
    "needs a size above zero and a finite guess, not 0 and 0.0": lambda s, p, a: s.coordinate("x", "m", size=0),
    "needs a size above zero and a finite guess, not 1.0 and nan": lambda s, p, a: s.coordinate("x", "m", guess=np.nan),
    "-1 amplitudes 'x' of 'pendulum' cannot be": lambda s, p, a: s.amplitudes("x", -1, "m"),
    "body 'rod' of 'pendulum' has mass but no place, so that it would not count": lambda s, p, a: s.body("rod", p.mass),
    "body 'rod' of 'pendulum' has inertia but no angle": lambda s, p, a: s.body("rod", p.mass, turned(a, p.length), p.mass * p.length**2),
    "the place of 'rod' of 'pendulum' has 1 component; it needs 2 components": lambda s, p, a: s.body("rod", p.mass, p.length),
    "the place of 'rod' of 'pendulum' is a tuple; it needs 2 components, such as vector(x, y)": lambda s, p, a: s.body(
        "rod", p.mass, (a, 0)
    ),
    "the load 'wind' of 'pendulum' has 1 component": lambda s, p, a: s.load("wind", turned(a, p.length), p.force),
    "the energy of 'well' of 'pendulum' has 2 components; it needs one number": lambda s, p, a: s.energy("well", p.force * vector(1, 1)),
    "the output 'tip' of 'pendulum' has 2 components": lambda s, p, a: s.output("tip", turned(a, p.length), "m"),
    "loop 'stop' of 'pendulum' gives angle; write a list of coordinates": lambda s, p, a: s.loop("stop", a, "rad", gives=a),
    "turn is no coordinate of 'pendulum'": lambda s, p, a: s.loop("stop", a, "rad", gives=["turn"]),
    "the energy of 'spring' of 'pendulum' contains 'angle', which this system did not declare": foreign,
    "the gravity of 'pendulum' is 9.81; give two components": scalar_gravity,
    "a feedback of -1 1/s opens the loops of 'pendulum'": lambda s, p, a: Model(s, feedback=-1.0),
    "the deflection of beam 'arm' is no function": lambda s, p, a: beam(s, p, deflection=p.length),
    "with tangent= keeps its length exactly": lambda s, p, a: beam(s, p, deflection=None, tangent=lambda x: a * x, stretch=lambda x: a * x),
    "beam 'arm' has an axial stiffness but does not stretch": lambda s, p, a: beam(s, p, axial_stiffness=p.force),
    "beam 'arm' needs two or more edges, from 0 to its end, and one or more points": lambda s, p, a: beam(s, p, points=0),
    "2 shapes between 'clamped-fre' cannot be": lambda s, p, a: natural_shapes("clamped-fre", 2),
    "2 shapes between 'clamped' cannot be": lambda s, p, a: natural_shapes("clamped", 2),
}


@pytest.mark.parametrize("sentence", WRONG, ids=lambda each: each[:30])
def test_a_wrong_argument_is_named(sentence: str) -> None:
    with pytest.raises(DescriptionError) as raised:
        WRONG[sentence](*pendulum())
    assert sentence in str(raised.value)
    assert "\n" not in str(raised.value)


def cantilever(shapes: int, points: int) -> System:
    system = System("cantilever")
    p = system.constants(length=(1, "m"), mass_per_length=(1, "kg/m"), stiffness=(1, "N*m^2"))
    eta, functions = system.amplitudes("eta", shapes, "m", size=0.01), natural_shapes("clamped-free", shapes)
    Beam(
        system,
        "strip",
        origin=vector(0, 0),
        angle=0,
        edges=[0, p.length],
        points=points,
        mass_per_length=p.mass_per_length,
        bending_stiffness=p.stiffness,
        deflection=lambda x: sum(eta[k] * functions[k](x / p.length) for k in range(shapes)),
    )
    return system


@pytest.mark.parametrize(("shapes", "points"), [(5, 6), (6, 6), (8, 10)])
def test_too_few_points_for_the_shapes_are_told(shapes: int, points: int) -> None:
    """Six shapes at six points have a first frequency that is 12 % too low and a second one that is 78 % too low."""
    with pytest.warns(
        UserWarning, match=r"the Gauss points of beam 'strip' of 'cantilever' are too few for its shapes: integrals .* off by"
    ):
        Model(cantilever(shapes, points))


@pytest.mark.parametrize(("shapes", "points"), [(4, 6), (6, 10)])
@pytest.mark.filterwarnings("error")
def test_enough_points_are_not(shapes: int, points: int) -> None:
    found = natural_frequencies(Model(cantilever(shapes, points)), {})[:3] * 2.0 * np.pi
    np.testing.assert_allclose(found, np.array([1.87510407, 4.69409113, 7.85475744]) ** 2, rtol=1e-4)
