"""The linear model with inputs and outputs: poles, zeros and time responses against closed forms and the whole equations."""

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.linalg import eigvals
from scipy.signal import StateSpace, lsim

from quickreturn.derive import Beam, Model, Statics, System, natural_frequencies, natural_shapes, state_space, turned, vector
from quickreturn.plugins.derive.equations import Form


def hub() -> Model:
    """A hub with a clamped beam; a torque turns it."""
    system, shapes = System("hub"), natural_shapes("clamped-free", 5)
    p = system.constants(L=(1, "m"), EI=(10, "N*m^2"), mu=(0.5, "kg/m"), J=(0.01, "kg*m^2"), T=(0, "N*m"))
    angle, eta = system.coordinate("angle", "rad"), system.amplitudes("eta", 5, "mm", size=10)
    Beam(
        system, "arm", origin=vector(0, 0), angle=angle, edges=[0, p.L], points=12, mass_per_length=p.mu, bending_stiffness=p.EI,
        deflection=lambda x: sum(eta[k] * shape(x / p.L) for k, shape in enumerate(shapes)),
    )  # fmt: skip
    system.body("hub", inertia=p.J, angle=angle)
    system.load("motor", angle, p.T)
    return Model(system)


def frequencies(values: NDArray[np.complex128]) -> NDArray[np.float64]:
    """Hz, of pairs of imaginary numbers."""
    return np.sort(np.abs(values.imag))[::2] / (2.0 * np.pi)


def test_the_poles_and_zeros_of_a_hub_with_a_beam() -> None:
    """With the hub held the beam vibrates as if it were clamped: from torque to angle these are the zeros."""
    model = hub()
    A, B, C, D = plant = state_space(model, {}, "T", "angle")
    np.testing.assert_allclose(frequencies(eigvals(A)), natural_frequencies(model, {}), atol=1e-5)
    n, roots = len(A), np.array([1.8751040687, 4.6940911330, 7.8547574382])
    zeros = eigvals(np.block([[A, B], [C, D]]), np.diag([*np.ones(n), 0.0]))
    held = frequencies(zeros[np.isfinite(zeros)])[:3]
    np.testing.assert_allclose(held, roots**2 / (2.0 * np.pi) * np.sqrt(10.0 / 0.5), rtol=1e-6)
    assert plant.states == [f"{name}{rate}" for rate in ("", "_rate") for name in ("angle", *(f"eta_{k}" for k in range(1, 6)))]
    assert (plant.units["eta_2_rate"], plant.units["T"], plant.units["angle"]) == ("mm/s", "N*m", "rad")


def press(form: Form) -> Model:
    """A crank on its spring: units that differ, gravity, a loop, a damper, and two inputs."""
    system = System("press")
    p = system.constants(
        r=(100, "mm"), l=(300, "mm"), J=(2, "g*m^2"), m=(1, "kg"), k=(900, "N/m"), c=(3, "N*s/m"), T=(0.1, "N*m"), anchor=(350, "mm"),
    )  # fmt: skip
    system.gravity = vector(0, -9.81)
    crank, rod = system.coordinate("crank", "deg", guess=40), system.coordinate("rod", "rad", guess=-0.2)
    x = system.coordinate("x", "mm", guess=380)
    system.body("crank", p.m, turned(crank, p.r), p.J, crank)
    system.body("block", p.m, vector(x, 0))
    system.loop("pin", turned(crank, p.r) + turned(rod, p.l) - vector(x, 0), gives=[rod, x])
    system.spring("spring", x - p.anchor, p.k)
    system.damper("oil", x, p.c)
    system.load("motor", crank, p.T)
    system.output("acceleration", system.rate(system.rate(x)), "mm/s^2")
    return Model(system, form)


@pytest.mark.parametrize("form", ["projection", "multipliers"])
def test_a_small_step_is_that_of_the_whole_equations(form: Form) -> None:
    model, outputs = press(form), ["x", "rod", "crank_rate", "acceleration", "pin_force_1"]
    rest, steps = Statics(model).equilibrium({"crank": 40}), {"T": 1e-5, "anchor": 1e-4}
    plant, still = state_space(model, rest, list(steps), outputs), model.simulate(rest, 0.3, 0.003, tolerance=1e-12)
    for k, (name, step) in enumerate(steps.items()):
        changed = {name: {"T": 0.1, "anchor": 350.0}[name] + step}
        right = (model.simulate(rest, 0.3, 0.003, tolerance=1e-12, parameters=changed) - still)[outputs].to_numpy() / step
        _, found, _ = lsim(StateSpace(*plant), np.tile(np.eye(2)[k], (101, 1)), np.array(still["time"]))
        sizes = np.abs(right).max(axis=0)
        np.testing.assert_allclose(found / sizes, right / sizes, atol=2e-5)  # second-order terms of the steps, 7e-6 at most
