"""Mistakes in a description and arguments that mean nothing: each gets one sentence that names it."""

from collections.abc import Callable
from typing import Any

import casadi as ca
import numpy as np
import pytest

from quickreturn.derive import (
    Beam,
    DescriptionError,
    Model,
    Statics,
    System,
    latex,
    natural_frequencies,
    natural_shapes,
    state_space,
    turned,
    vector,
)
from quickreturn.plugins.derive.checks import check_units
from quickreturn.plugins.derive.tests.descriptions import described


def crank() -> tuple[System, Any, Any]:
    system = System("crank")
    p = system.constants(length=(10, "cm"), mass=(1, "kg"), stiffness=(3, "N/m"))
    angle = system.coordinate("angle", "rad")
    system.body("arm", mass=p.mass, place=turned(angle, p.length))
    return system, p, angle


def beam(s: System, p: Any, **changed: Any) -> Beam:
    given = {"deflection": lambda x: p.length * (x / p.length) ** 2, "edges": [0, p.length]} | changed
    return Beam(s, "arm", origin=vector(0, 0), angle=0, mass_per_length=p.mass / p.length, **given)


def idle(s: System) -> tuple[Any, ...]:
    """Coordinates that nothing moves."""
    return s.coordinate("along", "m"), s.coordinate("beside", "m")


def of_casadi(u: Any) -> Any:
    return ca.interpolant("curve", "linear", [[0.0, 1.0]], [0.0, 1.0])(u)


def too_far(s: System, p: Any, a: Any) -> None:
    """A rod of 10 cm to a line 40 cm away."""
    rod, x = s.coordinate("rod", "rad"), s.coordinate("x", "m")
    s.body("rod", inertia=p.mass * p.length**2, angle=rod)
    s.body("block", mass=p.mass, place=vector(x, 0))
    s.loop("pin", turned(a, p.length) + turned(rod, p.length) - vector(x, 4 * p.length), gives=[rod, x])


def force_of_a_loop(s: System, p: Any, a: Any) -> None:
    hinge = s.coordinate("hinge", "rad")
    s.load("friction", a, -0.1 * s.loop("hold", hinge - a, "rad", gives=[hinge]))


def opening(s: System, p: Any, a: Any) -> None:
    s.loop("motor", a - 3.0 * s.time / s.constants(second=(1, "s")).second, "rad")
    Model(s, "multipliers").simulate({}, 0.1, 0.1)


def scalar_gravity(s: System, p: Any, a: Any) -> None:
    s.gravity = 9.81  # type: ignore[assignment]


#: What a sentence says -> the mistake, made in a system with a crank's angle.
MISTAKES: dict[str, Callable[[System, Any, Any], Any]] = {
    "the place of 'weight' is not in m": lambda s, p, a: s.body("weight", p.mass, turned(a, p.length) + vector(p.mass, 0)),
    "the energy of 'hair spring' is not in J": lambda s, p, a: s.spring("hair spring", a, p.stiffness),
    "the load 'motor' times what it acts on is not in J": lambda s, p, a: s.load("motor", a, p.stiffness),
    "damper 'oil' times the square of what it acts on is not in J*s": lambda s, p, a: s.damper("oil", a, p.stiffness),
    "the output 'tip_speed' is not in m/s": lambda s, p, a: s.output("tip_speed", p.length * a, "m/s"),
    "'along' of 'crank' has no inertia": lambda s, p, a: s.spring("spring", idle(s)[0], p.stiffness),
    "of 'crank' has no inertia, and no loop holds it": lambda s, p, a: s.body("both", p.mass, vector(sum(idle(s)), 0)),
    "the inertia of 'ball' depends on a coordinate": lambda s, p, a: s.body("ball", inertia=p.mass * s.coordinate("r", "m") ** 2, angle=a),
    "the mass of 'bucket' depends on a coordinate": lambda s, p, a: s.body("bucket", p.mass * (1 + a), turned(a, p.length)),
    "loop 'pin' of 'crank' cannot close at the start: 0.3 m remain": too_far,
    "have 2 rows and give ['angle']": lambda s, p, a: s.loop("pin", turned(a, p.length) - vector(p.length, 0), gives=[a]),
    "loop 'motor' of 'crank' opens at the start by 3 rad a second": opening,
    "depends on an acceleration or on a loop's force": force_of_a_loop,
    "rate of angle_rate is nan at the start": lambda s, p, a: s.energy("well", p.stiffness * p.length**2 * ca.sqrt(a - 1)),
    "depth is nan at the start": lambda s, p, a: s.output("depth", p.length * ca.log(a - 1), "m"),
    "'length' is used twice in 'crank'": lambda s, p, a: s.coordinate("length", "m"),
    "is no coordinate of 'crank'": lambda s, p, a: s.freeze(2 * a),
    "unit 'lenth' is not known": lambda s, p, a: s.constants(width=(3, "lenth")),
    "unit 'ampere' is not mechanical": lambda s, p, a: s.constants(current=(3, "ampere")),
    # where CasADi would broadcast, drop or misread an argument
    "constant 'height' of 'crank' is 3": lambda s, p, a: s.constants(height=3),  # type: ignore[arg-type]
    "a finite guess, not 0 and 0.0": lambda s, p, a: s.coordinate("x", "m", size=0),
    "-1 amplitudes 'x' of 'crank' cannot be": lambda s, p, a: s.amplitudes("x", -1, "m"),
    "body 'rod' of 'crank' has mass but no place": lambda s, p, a: s.body("rod", p.mass),
    "body 'rod' of 'crank' has inertia but no angle": lambda s, p, a: s.body("rod", p.mass, turned(a, p.length), p.mass * p.length**2),
    "the place of 'rod' of 'crank' has 1 component": lambda s, p, a: s.body("rod", p.mass, p.length),
    "the load 'wind' of 'crank' has 1 component": lambda s, p, a: s.load("wind", turned(a, p.length), p.stiffness * p.length),
    "the energy of 'well' of 'crank' has 2 components": lambda s, p, a: s.energy("well", p.stiffness * p.length**2 * vector(1, 1)),
    "the output 'tip' of 'crank' has 2 components": lambda s, p, a: s.output("tip", turned(a, p.length), "m"),
    "loop 'stop' of 'crank' gives angle; write a list": lambda s, p, a: s.loop("stop", a, "rad", gives=a),
    "turn is no coordinate of 'crank'": lambda s, p, a: s.loop("stop", a, "rad", gives=["turn"]),
    "contains 'angle', which this system did not declare": lambda s, p, a: s.spring("spring", a - crank()[2], p.stiffness * p.length**2),
    "the gravity of 'crank' is 9.81; give two components": scalar_gravity,
    "a feedback of -1 1/s opens the loops of 'crank'": lambda s, p, a: Model(s, feedback=-1.0),
    "beam 'arm' needs one of tangent and deflection": lambda s, p, a: beam(s, p, deflection=None),
    "the deflection of beam 'arm' is no function": lambda s, p, a: beam(s, p, deflection=p.length),
    "with tangent= keeps its length exactly": lambda s, p, a: beam(s, p, deflection=None, tangent=lambda x: a * x, stretch=lambda x: a * x),
    "has an axial stiffness but does not stretch": lambda s, p, a: beam(s, p, axial_stiffness=p.stiffness * p.length),
    "beam 'arm' needs two or more edges": lambda s, p, a: beam(s, p, points=0),
    "the damping of beam 'arm' of 'crank' has 7 values; give one, or a function": lambda s, p, a: beam(s, p, damping=ca.SX.ones(7)),
    "beam 'arm' of 'crank' has no bending stiffness": lambda s, p, a: beam(s, p).moment(0),
    "load 'motor' of 'crank' cannot be formed from what is given (CasADi does not take (str))": lambda s, p, a: s.load("motor", a, "3"),
    "'call' is not translated to machine code": lambda s, p, a: s.load("motor", a, of_casadi(a) * p.stiffness * p.length**2),
    "'call' has no LaTeX here": lambda s, p, a: s.load("motor", a, of_casadi(a)) or latex(s),
    # functions by points
    "table 'motor' of 'crank' has 2 x and 3 y": lambda s, p, a: s.table("motor", ([0, 1], "rad"), ([0, 1, 2], "J")),
    "x of table 'motor' of 'crank' does not ascend: 1 follows 2": lambda s, p, a: s.table("motor", ([0, 2, 1], "rad"), ([0, 1, 2], "J")),
    "y of table 'motor' of 'crank' contains nan": lambda s, p, a: s.table("motor", ([0, 1], "rad"), ([0, np.nan], "J")),
    "x of table 'motor' of 'crank' is [0, 1]; give numbers": lambda s, p, a: s.table("motor", [0, 1], ([0, 1], "J")),  # type: ignore[arg-type]
    "argument of table 'motor' is not in m": lambda s, p, a: s.load("motor", a, s.table("motor", ([0, 1], "m"), ([0, 1], "J"))(a)),
    # linear models
    "'torque' is no parameter of 'crank'": lambda s, p, a: state_space(Model(s), {}, "torque", "angle"),
    "'work' is no output of small motions of 'crank'": lambda s, p, a: state_space(Model(s), {}, [], "work"),
    "'length' moves a mass, a damper or a loop": lambda s, p, a: state_space(Model(s), {}, "length", "angle"),
    "'crank' is not at rest there": lambda s, p, a: (s.spring("up", a - 1, p.stiffness * p.length**2), state_space(Model(s), {}, [], [])),
    "'time' moves a mass": lambda s, p, a: (
        s.loop("drive", a - s.time / s.constants(t=(1, "s")).t, "rad", gives=[a]),
        state_space(Model(s), {}, [], []),
    ),
    "coordinate 'along' of 'crank' has no inertia": lambda s, p, a: (idle(s), natural_frequencies(Model(s), {})),
    "2 shapes between 'clamped-fre' cannot be": lambda s, p, a: natural_shapes("clamped-fre", 2),
}


@pytest.mark.parametrize("words", MISTAKES)
def test_a_mistake_is_named_in_one_sentence(words: str) -> None:
    def described_and_moved() -> None:
        system, p, angle = crank()
        MISTAKES[words](system, p, angle)
        Model(system).simulate({}, 0.1, 0.1)

    with pytest.raises(DescriptionError) as raised:
        described_and_moved()
    assert words in str(raised.value)
    assert "\n" not in str(raised.value)


def test_units_are_no_mistake_where_terms_cancel() -> None:
    """A gap that is zero but for rounding does not change as its unit says."""
    for rate in (0.127 / 0.113, 1.0, 1.27):  # q is tried 0.127 beyond its guess, time at 0.113
        system = System("wheel")
        p = system.constants(rate=(float(rate), "rad/s"), begin=(90.0, "deg"), inertia=(1.0, "kg*m^2"))
        angle = system.coordinate("angle", "rad", guess=np.pi / 2)
        system.body("wheel", inertia=p.inertia, angle=angle)
        system.loop("drive", angle - p.begin - p.rate * system.time, "rad", gives=[angle])
        check_units(system)


def test_unknown_names_are_listed() -> None:
    model = Model(crank()[0])
    with pytest.raises(DescriptionError, match=r"'agle' is no coordinate or rate of 'crank'; there are angle, angle_rate"):
        model.simulate({"agle": 1.0}, 0.1, 0.1)
    with pytest.raises(DescriptionError, match=r"'lenght' is no parameter of 'crank'; there are length, mass, stiffness"):
        model.simulate({}, 0.1, 0.1, parameters={"lenght": 1.0})
    with pytest.raises(DescriptionError, match=r"'x' is no coordinate of 'crank'"):
        natural_frequencies(model, {}, hold=["x"])


def negative(system: System) -> None:
    p = system.parameters
    system.body("hole", mass=-2.0 * p["mass"][0], place=turned(system.coordinates[0].q, p["length"][0]))


@pytest.mark.parametrize(
    ("change", "arguments", "sentence"),
    [
        (None, {"start": {"angle": np.nan}}, "coordinate or rate 'angle' of 'crank' is nan, which is no finite number"),
        (None, {"step": 0.0}, "a duration of 0.1 s cannot have rows 0 s apart"),
        (None, {"tolerance": 0.0}, "a tolerance of 0 is not between 0 and 1"),
        (negative, {}, "the inertia of 'angle' of 'crank' is negative; a mass or an inertia has the wrong sign"),
    ],
    ids=lambda each: "",
)
def test_numbers_that_mean_nothing_are_named(change: Callable[[System], None] | None, arguments: dict[str, Any], sentence: str) -> None:
    system = crank()[0]
    if change:
        change(system)
    with pytest.raises(DescriptionError) as raised:
        Model(system).simulate(**{"start": {}, "duration": 0.1, "step": 0.1} | arguments)
    assert str(raised.value) == sentence


def test_a_system_without_coordinates_and_an_unknown_form_are_named() -> None:
    with pytest.raises(DescriptionError, match="'nothing' has no coordinate"):
        Model(System("nothing"))
    with pytest.raises(DescriptionError, match="the form 'lagrange' is not known; take one of projection, multipliers"):
        Model(crank()[0], "lagrange")  # type: ignore[arg-type]


def test_an_equilibrium_that_is_not_there() -> None:
    system, p, angle = crank()
    system.load("motor", angle, p.stiffness * p.length**2)
    with pytest.raises(DescriptionError, match="no equilibrium of 'crank' is found from this start"):
        Statics(Model(system)).equilibrium({})


def test_a_system_too_large_for_latex() -> None:
    with pytest.raises(DescriptionError, match="instructions; LaTeX is for"):
        latex(described("four_bar").four_bar(1))


@pytest.mark.filterwarnings("error")  # the sentence is all that the user reads
def test_a_motion_that_ends_says_when() -> None:
    system, p, angle = crank()
    system.energy("well", p.stiffness * p.length**2 * ca.sqrt(1 - angle))
    with pytest.raises(DescriptionError, match=r"the integration of 'crank' gets stuck after 0\.[4-9]"):
        Model(system).simulate({"angle_rate": 1.0}, 3.0, 0.01)


def test_units_are_those_given_and_rates_have_them() -> None:
    system, p, angle = crank()
    system.output("height", p.length * ca.sin(angle), "mm")
    found = Model(system).simulate({"angle": 0.5}, 0.1, 0.1)
    assert found["height"][0] == pytest.approx(100 * np.sin(0.5))
    assert found.attrs["units"]["height"] == "mm"
    assert found.attrs["units"]["angle_rate"] == "rad/s"
