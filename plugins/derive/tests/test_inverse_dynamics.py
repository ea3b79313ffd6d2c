"""The force at one part that makes a motion given at another."""

from typing import Any

import casadi as ca
import numpy as np
import pytest

from quickreturn.derive import DescriptionError, Model, Statics, System, natural_frequencies, vector
from quickreturn.plugins.derive.equations import Form
from quickreturn.plugins.derive.tests.linkages import G, Rods, four_bar, rods_of_four_bar, rods_of_slider_crank, slider_crank

FORMS: list[Form] = ["projection", "multipliers"]
BEGIN, SPEED = 0.7, 3.0


def torque(rods: Rods, masses: Any, block: float, angle: Any) -> Any:
    """At a crank that turns steadily: T = J'(a) w^2 / 2 + V'(a), with the energies of uniform rods and a block at the last one's end."""

    def energies(a: float) -> tuple[float, float]:
        ends = rods(a)
        inertia = sum(m / 3 * (abs(u) ** 2 + abs(v) ** 2 + (u * np.conj(v)).real) for m, (*_, u, v) in zip(masses, ends, strict=True))
        weight = sum(m * G * (begin + end).imag / 2 for m, (begin, end, *_) in zip(masses, ends, strict=True))
        return inertia + block * abs(ends[-1][3]) ** 2, weight

    def at(a: float, h: float = 1e-4) -> float:
        one, two, three, four = (np.array(energies(a + k * h)) for k in (-2, -1, 1, 2))
        inertia, weight = (one - 8 * two + 8 * three - four) / (12 * h)
        return float(inertia * SPEED**2 / 2 + weight)

    return np.vectorize(at)(angle)


def press() -> System:
    """The block moves as a crank that turns steadily would move it, by the torque at the crank."""
    system = slider_crank(0.2, 0.5, (1.0, 2.0, 3.0), "crank")
    p = system.constants(speed=(SPEED, "rad/s"), begin=(BEGIN, "rad"), r=(0.2, "m"), l=(0.5, "m"))
    angle = p.begin + p.speed * system.time
    crank, _, block = (c.q for c in system.coordinates)
    system.loop("ram", block - p.r * ca.cos(angle) - ca.sqrt(p.l**2 - p.r**2 * ca.sin(angle) ** 2), gives=[crank], by=(crank, "rad"))
    return system


def rocked(lengths: tuple[float, float, float, float], form: Form, begin: float, rate: float) -> Model:
    """The rocker of a four-bar turns at a given rate, by the torque at the crank."""
    system = four_bar(lengths, (1.0, 2.0, 1.5))
    p = system.constants(rate=(rate, "rad/s"), begin=(begin, "rad"))
    crank, _, rocker = (c.q for c in system.coordinates)
    system.loop("drive", rocker - p.begin - p.rate * system.time, "rad", gives=[crank], by=(crank, "rad"))
    return Model(system, form)


@pytest.mark.parametrize("form", FORMS)
def test_the_torque_at_the_crank_for_a_motion_of_the_ram(form: Form) -> None:
    """Between two dead points of the ram."""
    system = press()
    guesses = {"crank": BEGIN, "rod": -0.26, "block": 0.64}
    system.coordinates[:] = [c._replace(guess=guesses[c.name]) for c in system.coordinates]
    found = Model(system, form).simulate({}, 0.75, 0.01, tolerance=1e-10)
    angle = BEGIN + SPEED * found["time"]
    np.testing.assert_allclose(found["crank"], angle, atol=1e-8)
    right = torque(rods_of_slider_crank(0.2, 0.5), (1.0, 2.0), 3.0, angle)
    np.testing.assert_allclose(found["ram_force"], right, atol=1e-7 * np.max(np.abs(right)))
    assert found.attrs["units"]["ram_force"] == "J/rad"
    assert np.ptp(found["energy_balance"]) < 1e-7


@pytest.mark.parametrize("form", FORMS)
def test_the_torque_at_rest_is_that_of_the_weight(form: Form) -> None:
    lengths = (1.0, 0.4, 0.9, 0.8)
    rest = Statics(rocked(lengths, form, 2.0, 0.0)).equilibrium({})
    rods, h = rods_of_four_bar(*lengths), 1e-5
    assert rest["rocker"] == pytest.approx(2.0)
    crank = rest["crank"]
    weights = [sum(m * G * (b + e).imag / 2 for m, (b, e, *_) in zip((1.0, 2.0, 1.5), rods(crank + d), strict=True)) for d in (-h, h)]
    assert rest.outputs["drive_force"] == pytest.approx((weights[1] - weights[0]) / (2 * h), rel=1e-7)


def test_a_link_that_stands_still_cannot_drive() -> None:
    """The rocker turns fully, the crank only swings: at its extremes no torque moves the rest."""
    model = rocked((1.0, 0.9, 0.6, 0.4), "projection", 1.5, 2.0)
    with pytest.raises(
        DescriptionError, match=r"the force of loop 'drive' of 'four-bar' cannot make its motion at 1\.29 s: what it acts on"
    ):
        model.simulate({}, 3.0, 0.01)
    found = model.simulate({}, 1.2, 0.01)
    rods = rods_of_four_bar(1.0, 0.9, 0.6, 0.4)
    joints = np.array([rods(a)[2][1] for a in found["crank"]])
    assert found["rocker"].iloc[-1] == pytest.approx(1.5 + 2.0 * 1.2)
    np.testing.assert_allclose(np.angle(joints - 1.0), np.angle(np.exp(1j * found["rocker"])), atol=1e-8)
    with pytest.raises(DescriptionError, match=r"loops \['drive'\] act elsewhere than they hold; leave them out, and hold the coordinates"):
        natural_frequencies(model, {})


def test_what_a_force_cannot_do_is_told() -> None:
    def two(gives: int) -> System:
        system = System("two")
        p = system.constants(m=(1, "kg"), k=(50, "N/m"), a=(0.1, "m"), w=(3, "rad/s"))
        one, other = system.coordinate("one", "m"), system.coordinate("other", "m")
        system.body("one", p.m, vector(one, 0))
        system.body("other", p.m, vector(other, 0))
        system.spring("spring", other - one, p.k)
        system.loop("drive", other - p.a * ca.sin(p.w * system.time) ** 2, gives=[(one, other)[gives]], by=(one, "m"))
        return system

    with pytest.raises(DescriptionError, match=r"the loops of 'two' do not contain all that they give, \['one'\]"):
        Model(two(0))
    with pytest.raises(DescriptionError, match=r"the forces of the loops of 'two' do not act on all that these give, \['other'\]"):
        Model(two(1))
    with pytest.raises(DescriptionError, match=r"cannot make its motion at 0 s: .* does not reach it without delay"):
        Model(two(1), "multipliers").simulate({}, 1.0, 0.1)  # the spring delays it
    with pytest.raises(DescriptionError, match="loop 'pin' of 'two' has 1 rows and acts on 2: it needs as many forces"):
        (system := two(1)).loop("pin", system.coordinates[0].q, by=(vector(0, 0), "m"))
