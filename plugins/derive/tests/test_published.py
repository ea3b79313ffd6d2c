"""Mechanisms of benchmark libraries and textbooks against the numbers or the closed forms that they were published with."""

from collections.abc import Callable

import numpy as np
import pytest

from quickreturn.derive import Model, Statics, System, natural_frequencies
from quickreturn.plugins.derive.equations import Form
from quickreturn.plugins.derive.tests import published as of
from quickreturn.plugins.derive.tests.linkages import scott_russell

MOTIONS = [
    of.andrews_squeezer,
    of.double_pendulum,
    of.cart_pole,
    of.elastic_pendulum,
    of.inversor,
    of.falling_ladder,
    of.two_link_arm,
]


@pytest.mark.filterwarnings("error")  # each starts as its guesses say
@pytest.mark.parametrize(
    ("mechanism", "form"),
    [
        (of.simple_pendulum, "multipliers"),
        *((each, "projection") for each in MOTIONS),
        *(pytest.param(each, "multipliers", marks=pytest.mark.verify) for each in MOTIONS),
    ],
    ids=lambda each: getattr(each, "__name__", each),
)
def test_it_moves_as_published(mechanism: Callable[[], of.Published], form: Form) -> None:
    each = mechanism()
    found = Model(each.system, form).simulate(each.start, each.duration, each.duration / each.rows, tolerance=1e-11)
    for name, right in each.right(found).items():
        values = found[name] if np.ndim(right) else found[name].iloc[-1]
        tolerance = next((looser for part, looser in each.looser.items() if part in name), each.tolerance)
        np.testing.assert_allclose(values, right, rtol=0, atol=tolerance * np.max(np.abs(right)), err_msg=name)
    assert np.ptp(found["energy_balance"]) < 1e-6 * (found["kinetic_energy"].max() + found["work"].abs().max())


@pytest.mark.parametrize("form", ["projection", "multipliers"])
def test_rows_are_on_their_loops_and_keep_the_energy(form: Form) -> None:
    """Rows between the steps of a slow motion: they stood off their loops by 5e-6 m, and 8e-4 J were lacking."""
    found = Model(scott_russell(), form).simulate({"left": 0.6}, 0.5, 0.002)
    np.testing.assert_allclose(found["y"], 0.6 * np.sin(found["left"]), rtol=0, atol=1e-15)
    np.testing.assert_allclose(found[["x", "tilt"]], 0.0, atol=1e-15)
    np.testing.assert_allclose(found["left_foot"], 0.6 * np.cos(found["left"]), rtol=0, atol=1e-15)
    np.testing.assert_allclose(found["y_rate"], 0.6 * np.cos(found["left"]) * found["left_rate"], rtol=0, atol=1e-13)
    assert np.ptp(found["energy_balance"]) < 1e-8 * found["kinetic_energy"].max()


@pytest.mark.parametrize(
    ("system", "rest", "tolerance"),
    [
        (of.porter_governor(133.8), {"radius": 150.0}, 0.2),  # the book rounds the speed: 0.05 rpm are 0.2 mm
        (of.porter_governor(154.5), {"radius": 200.0}, 0.2),
        (of.porter_governor(150.0), {"radius": 250 * np.sqrt(1 - (4 * 9.81 / (5 * np.pi) ** 2 / 0.25) ** 2)}, 1e-7),
        (of.elastica(1.0), {"drop": 0.30172, "drawn_in": 0.05643, "slope": 0.46135}, 6e-6),  # five decimals
        (of.elastica(10.0), {"drop": 0.81061, "drawn_in": 0.55500, "slope": 1.43029}, 6e-6),
        (of.elastica(30.0), of.elastica_by_integrals(30.0), 6e-6),  # full Newton steps find one load or another, by the processor
    ],
    ids=lambda each: each.name if isinstance(each, System) else "",
)
def test_it_rests_as_published(system: System, rest: dict[str, float], tolerance: float) -> None:
    found = Statics(Model(system)).equilibrium({"arm": 0.8} if "governor" in system.name else {})
    assert {name: found.outputs[name] for name in rest} == pytest.approx(rest, abs=tolerance)


@pytest.mark.parametrize(
    ("system", "squares"),
    [
        (of.landau(), [(2 - np.sqrt(2)) * 9.81, (2 + np.sqrt(2)) * 9.81]),
        (of.elastic_pendulum().system, [np.pi**2, 4 * np.pi**2]),
        (of.rocking_half_cylinder(), [8 * 9.81 / ((9 * np.pi - 16) * 0.4)]),
    ],
    ids=lambda each: each.name if isinstance(each, System) else "",
)
def test_it_vibrates_as_published(system: System, squares: list[float]) -> None:
    at = {"r": 1.0} if system.name == "elastic pendulum" else {}
    np.testing.assert_allclose(natural_frequencies(Model(system), at), np.sqrt(squares) / (2 * np.pi), rtol=1e-9)
