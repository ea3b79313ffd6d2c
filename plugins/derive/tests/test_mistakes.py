"""Mistakes in a description: each gets one sentence that names it."""

from collections.abc import Callable
from typing import Any

import casadi as ca
import numpy as np
import pytest

from quickreturn.derive import Beam, DescriptionError, Model, Statics, System, latex, natural_frequencies, sensitivities, turned, vector
from quickreturn.plugins.derive.checks import check_units
from quickreturn.plugins.derive.tests.descriptions import described


def crank() -> tuple[System, Any, Any]:
    system = System("crank")
    p = system.constants(length=(10, "cm"), mass=(1, "kg"), stiffness=(3, "N/m"))
    angle = system.coordinate("angle", "rad")
    system.body("arm", mass=p.mass, place=turned(angle, p.length))
    return system, p, angle


def units_of_place(system: System, p: Any, angle: Any) -> None:
    system.body("weight", mass=p.mass, place=turned(angle, p.length) + vector(p.mass, 0))


def units_of_spring(system: System, p: Any, angle: Any) -> None:
    system.spring("hair spring", angle, p.stiffness)


def units_of_load(system: System, p: Any, angle: Any) -> None:
    system.load("motor", angle, p.stiffness)


def units_of_damper(system: System, p: Any, angle: Any) -> None:
    system.damper("oil", angle, p.stiffness)


def units_of_output(system: System, p: Any, angle: Any) -> None:
    system.output("tip_speed", p.length * angle, "m/s")


def units_in_a_function(system: System, p: Any, angle: Any) -> None:
    system.energy("well", p.stiffness * p.length**2 * ca.exp(p.length))


def no_inertia(system: System, p: Any, angle: Any) -> None:
    system.spring("spring", system.coordinate("idle", "m"), p.stiffness)


def no_inertia_alone(system: System, p: Any, angle: Any) -> None:
    place = system.coordinate("along", "m") + system.coordinate("beside", "m")
    system.body("both", mass=p.mass, place=vector(place, 0))


def inertia_that_changes(system: System, p: Any, angle: Any) -> None:
    system.body("ball", inertia=p.mass * system.coordinate("radius", "m") ** 2, angle=angle)


def mass_that_changes(system: System, p: Any, angle: Any) -> None:
    system.body("bucket", p.mass * (1 + angle), turned(angle, p.length))


def too_far(system: System, p: Any, angle: Any) -> None:
    rod = system.coordinate("rod", "rad")
    x = system.coordinate("x", "m")
    system.body("rod", inertia=p.mass * p.length**2, angle=rod)
    system.body("block", mass=p.mass, place=vector(x, 0))
    system.loop("pin", turned(angle, p.length) + turned(rod, p.length) - vector(x, 4 * p.length), gives=[rod, x])


def too_few(system: System, p: Any, angle: Any) -> None:
    system.loop("pin", turned(angle, p.length) - vector(p.length, 0), gives=[angle])


def opening(system: System, p: Any, angle: Any) -> None:
    system.loop("motor", angle - 3.0 * system.time / system.constants(second=(1, "s")).second, "rad")


def force_of_a_loop(system: System, p: Any, angle: Any) -> None:
    hinge = system.coordinate("hinge", "rad")
    force = system.loop("hold", hinge - angle, "rad", gives=[hinge])
    system.load("friction", angle, -0.1 * force)


def no_number(system: System, p: Any, angle: Any) -> None:
    system.energy("well", p.stiffness * p.length**2 * ca.sqrt(angle - 1))


def no_number_of_an_output(system: System, p: Any, angle: Any) -> None:
    system.output("depth", p.length * ca.log(angle - 1), "m")


def twice(system: System, p: Any, angle: Any) -> None:
    system.coordinate("length", "m")


def reserved(system: System, p: Any, angle: Any) -> None:
    system.output("work", p.stiffness * p.length**2, "J")


def stranger(system: System, p: Any, angle: Any) -> None:
    system.freeze(2 * angle)


def unknown_unit(system: System, p: Any, angle: Any) -> None:
    system.constants(width=(3, "lenth"))


def electric(system: System, p: Any, angle: Any) -> None:
    system.constants(current=(3, "ampere"))


def no_shape(system: System, p: Any, angle: Any) -> None:
    Beam(system, "strip", origin=vector(0, 0), angle=angle, edges=[0, p.length], mass_per_length=p.mass / p.length)


def units_of_number(system: System, p: Any, angle: Any) -> None:
    system.body("weight", 2.0, vector(p.length, 0))


MISTAKES: dict[Callable[..., None], str] = {
    units_of_place: "units do not fit: the place of 'weight' is not in m; look for a sum or a function of different dimensions",
    units_of_number: "dimensions, or for a plain number: constants(NAME=(VALUE, UNIT)) gives it a unit",
    units_of_spring: "units do not fit: the energy of 'hair spring' is not in J; ",
    units_of_load: "units do not fit: the load 'motor' times what it acts on is not in J; ",
    units_of_damper: "units do not fit: the coefficient of damper 'oil' times the square of what it acts on is not in J*s; ",
    units_of_output: "units do not fit: the output 'tip_speed' is not in m/s; ",
    units_in_a_function: "units do not fit: the energy of 'well' is not in J; ",
    no_inertia: "coordinate 'idle' of 'crank' has no inertia, and no loop holds it; give a body whose place or angle follows it",
    no_inertia_alone: "of 'crank' has no inertia, and no loop holds it",
    inertia_that_changes: "the inertia of 'ball' depends on a coordinate; describe a mass that moves by its place",
    mass_that_changes: "the mass of 'bucket' depends on a coordinate; ",
    too_far: "loop 'pin' of 'crank' cannot close at the start: 0.3 m remain",  # a rod of 10 cm to a line 40 cm away
    too_few: "the loops of 'crank' have 2 rows and give ['angle']: projection needs as many coordinates, each once; name",
    opening: "loop 'motor' of 'crank' opens at the start by 3 rad a second; leave out the rates of the coordinates that it gives",
    force_of_a_loop: "a load of 'crank' depends on an acceleration or on a loop's force; only outputs may",
    no_number: "rate of angle_rate is nan at the start; look for a root of a negative number or a division by zero there",
    no_number_of_an_output: "depth is nan at the start; look for",
    twice: "the name 'length' is used twice in 'crank'",
    reserved: "the name 'work' is used twice in 'crank'",
    stranger: "is no coordinate of 'crank'; declare it with coordinate(...)",
    unknown_unit: "unit 'lenth' is not known; write it as in 'kg*m^2'",
    electric: "unit 'ampere' is not mechanical: it contains [current]",
    no_shape: "beam 'strip' needs one of tangent and deflection",
}


@pytest.mark.parametrize("mistake", MISTAKES, ids=lambda each: each.__name__)
def test_a_mistake_is_named_in_one_sentence(mistake: Callable[..., None]) -> None:
    def described_and_moved() -> None:
        parts = crank()
        mistake(*parts)
        Model(parts[0], "multipliers" if mistake is opening else "projection").simulate({}, 0.1, 0.1)

    with pytest.raises(DescriptionError) as raised:
        described_and_moved()
    assert MISTAKES[mistake] in str(raised.value)
    assert "\n" not in str(raised.value)


def test_without_a_mistake_the_crank_turns() -> None:
    system, _, _ = crank()
    assert Model(system).simulate({"angle_rate": 2.0}, 0.1, 0.1)["angle"].iloc[-1] == pytest.approx(0.2, rel=1e-9)


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
    with pytest.raises(DescriptionError, match=r"'lenght' is no parameter of 'crank'"):
        sensitivities(model, ["lenght"], {}, 0.1, 0.1)
    with pytest.raises(DescriptionError, match=r"'x' is no coordinate of 'crank'"):
        natural_frequencies(model, {}, hold=["x"])


def negative(system: System) -> None:
    p = system.parameters
    system.body("hole", mass=-2.0 * p["mass"][0], place=turned(system.coordinates[0].q, p["length"][0]))


@pytest.mark.parametrize(
    ("change", "arguments", "sentence"),
    [
        (None, {"start": {"angle": np.nan}}, "coordinate or rate 'angle' of 'crank' is nan, which is no finite number"),
        (None, {"start": {"angle": "30 deg"}}, "coordinate or rate 'angle' of 'crank' is '30 deg', which is no finite number"),
        (None, {"parameters": {"mass": np.inf}}, "parameter 'mass' of 'crank' is inf, which is no finite number"),
        (None, {"step": 0.0}, "a duration of 0.1 s cannot have rows 0 s apart"),
        (None, {"step": 0.2}, "a duration of 0.1 s cannot have rows 0.2 s apart"),
        (None, {"duration": "1 s"}, "the duration '1 s' and the step 0.1 must be numbers, in s"),
        (None, {"duration": -0.1}, "a duration of -0.1 s cannot have rows 0.1 s apart"),
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


def test_a_system_too_large_for_latex_or_without_sensitivities() -> None:
    with pytest.raises(DescriptionError, match="instructions; LaTeX is for"):
        latex(described("spin_up").spin_up())
    model = Model(described("four_bar").four_bar(1), "multipliers")
    with pytest.raises(DescriptionError, match="need the form 'projection'"):
        sensitivities(model, ["crank"], {}, 0.1, 0.1)


@pytest.mark.filterwarnings("error")  # the sentence is all that the user reads
def test_a_motion_that_ends_says_when() -> None:
    system, p, angle = crank()
    system.energy("well", p.stiffness * p.length**2 * ca.sqrt(1 - angle))
    model, start = Model(system), {"angle_rate": 1.0}
    for moved in (lambda: model.simulate(start, 3.0, 0.01), lambda: sensitivities(model, ["length"], start, 3.0, 0.01)):
        with pytest.raises(DescriptionError, match=r"the integration of 'crank' gets stuck after 0\.[4-9]"):
            moved()


def test_units_are_those_given_and_rates_have_them() -> None:
    system, p, angle = crank()
    system.output("height", p.length * ca.sin(angle), "mm")
    found = Model(system).simulate({"angle": 0.5}, 0.1, 0.1)
    assert found["height"][0] == pytest.approx(100 * np.sin(0.5))
    assert found.attrs["units"]["height"] == "mm"
    assert found.attrs["units"]["angle_rate"] == "rad/s"
