"""Scenes and states handed to the thesis' model, and what it and the computer's derivation say about them under common names."""

import cmath
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from quickreturn.plugins.derive.tests.descriptions import described
from quickreturn.plugins.derive.tests.reference.derived_thesis import of_shapes, one_cubic
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.columns import BEARINGS, MOMENTS, ROW, SHAPE, by_column, recorded_columns
from quickreturn.reference_model.compiled_state import state_of
from quickreturn.reference_model.follower import Follower
from quickreturn.reference_model.mechanism import Base, Crank, Mechanism, PrescribedSpeed, TorqueDrive
from quickreturn.reference_model.native.compilation import compiled
from quickreturn.reference_model.native.memory import Placed
from quickreturn.reference_model.shapes import ShapeSet, hermite_elements
from quickreturn.reference_model.slider import Slider
from quickreturn.reference_model.thesis import equations as thesis_equations
from quickreturn.reference_model.thesis import kinematics
from quickreturn.reference_model.thesis.dynamics import evaluate
from quickreturn.reference_model.thesis.parameters import (
    ThesisParameters,
    ThesisWorkspace,
    build_parameters,
    build_workspace,
    parameters_at,
    state_size,
    workspace_at,
)
from quickreturn.reference_model.tip import Tip

_DESCRIBED = described("quick_return")
#: Run 24, SI, by the names of `examples/derive/quick_return.py`.
RUN_24 = {name: value for name, (_, value, _) in _DESCRIBED.quick_return(_DESCRIBED.one_cubic).parameters.items()}
#: Dampings are magnified in random scenes, where the thesis' values would hide a wrong sign behind the flywheel.
MAGNIFIED = {"base_damping": 1e4, "beam_damping": 10.0}
#: Largest magnitudes of what the thesis leaves out, SI; each is as large as what it competes with.
LEFT_OUT = {
    "tip_center_of_mass": 0.03,
    "slider_mass": 0.5,
    "slider_inertia": 5e-4,
    "gravity_1": 15.0,
    "gravity_2": 15.0,
    "force_1": 10.0,
    "force_2": 10.0,
}


Values = dict[str, Array]
Case = tuple[dict[str, float], dict[str, float]]

#: Parts that a scene can lack besides those which `draw_case` leaves out.
ABSENT = ("tip_mass", "tip_inertia", "base_inertia", "base_damping", "beam_damping", "crank_damping", "crank_torque")


@dataclass(frozen=True)
class Equations:
    """The functions under test, of parameters, workspace, state ...: the compiled ones, or the same source as plain Python."""

    evaluate: Callable[..., Any]
    right_hand_side: Callable[..., Any]  # ... rate and row


@compiled
def _evaluate(parameters: int, workspace: int, y: Array) -> tuple[bool, kinematics.Slider, kinematics.Contact]:
    p = parameters_at(parameters)
    return evaluate(p, workspace_at(workspace), state_of(y, p.n))


def _by_address(function: Callable[..., Any]) -> Callable[..., Any]:
    def call(p: ThesisParameters, w: ThesisWorkspace, *arrays: Array) -> Any:
        at = Placed(p), Placed(w)
        return function(at[0].address, at[1].address, *arrays)

    return call


COMPILED = Equations(_by_address(_evaluate), _by_address(thesis_equations.right_hand_side))


def draw_case(seed: int, *, present: float = 0.5, lacking: tuple[str, ...] = ()) -> Case:
    """A random scene in which the crank can turn all the way round, and a random state of it, in SI.

    Lengths vary by 10 to 40 %, everything else by up to 50 % around run 24, dampings around its `MAGNIFIED` values. Tip slope is at
    most 0.5, |W'| below 0.5 everywhere, rates are those of a violent run; the slider stands anywhere between d - LA and d + LA from
    P, before or after the return, and on the beam. Each of `LEFT_OUT` differs from zero with the probability `present`.
    """
    rng = np.random.default_rng(seed)
    while True:
        parameters = {name: value * MAGNIFIED.get(name, 1.0) * rng.uniform(0.5, 1.5) for name, value in RUN_24.items()}
        for name, spread in (("pivot_distance", 0.1), ("crank_length", 0.4), ("length", 0.15)):
            parameters[name] = RUN_24[name] * rng.uniform(1 - spread, 1 + spread)
        for name, largest in LEFT_OUT.items():
            sign = -1.0 if name not in ("slider_mass", "slider_inertia") and rng.random() < 0.5 else 1.0
            parameters[name] = sign * largest * rng.uniform(0.1, 1.0) if rng.random() < present else 0.0

        d, arm, length = parameters["pivot_distance"], parameters["crank_length"], parameters["length"]
        distance = rng.uniform(d - arm, d + arm)
        half_turn = math.acos(np.clip((d**2 + arm**2 - distance**2) / (2 * d * arm), -1.0, 1.0))
        deflection, slope = length * rng.uniform(-0.2, 0.2), rng.uniform(-0.5, 0.5)
        foreshortening = 0.6 * deflection**2 / length - 0.1 * deflection * slope + slope**2 * length / 15
        if distance + foreshortening < length and d + arm < length:
            state = {
                "crank_angle": rng.choice([-1.0, 1.0]) * half_turn + 2 * math.pi * int(rng.integers(-2, 3)),
                "tip_deflection": deflection,
                "tip_slope": slope,
                "crank_speed": rng.uniform(-35.0, 35.0),
                "tip_deflection_rate": rng.uniform(-3.0, 3.0),
                "tip_slope_rate": rng.uniform(-15.0, 15.0),
            }
            return parameters | dict.fromkeys(lacking, 0.0), state


def mechanism_of(parameters: Mapping[str, float]) -> Mechanism:
    """The scene as the package takes it."""
    p, length = parameters, parameters["length"]
    return Mechanism(
        pivot_distance=p["pivot_distance"],
        crank=Crank(
            length=p["crank_length"], mass=p["crank_mass"], center_of_mass=p["crank_center_of_mass"], inertia=p["crank_inertia"],
            drive=TorqueDrive(torque=p["crank_torque"], damping=p["crank_damping"], initial_speed=1.0),
        ),
        base=Base(inertia=p["base_inertia"], damping=p["base_damping"]),
        follower=Follower(
            length=length, mass_per_length=p["mass_per_length"], bending_stiffness=p["bending_stiffness"], thickness=3e-3, width=4e-2,
            damping=p["beam_damping"], strain_gauges=(0.25 * length, 0.5 * length, 0.75 * length),
        ),
        tip=Tip(
            mass=p["tip_mass"], inertia=p["tip_inertia"], center_of_mass=p["tip_center_of_mass"], force=(p["force_1"], p["force_2"])
        ),
        slider=Slider(mass=p["slider_mass"], inertia=p["slider_inertia"]),
        gravity=(p["gravity_1"], p["gravity_2"]),
    )  # fmt: skip


def build(parameters: Mapping[str, float], *, elements: int = 1, exact: bool = False, cells: int = 0) -> tuple[ThesisParameters, ShapeSet]:
    """Parameters of the equations with Hermite elements, and their shapes."""
    shapes = hermite_elements(parameters["length"], elements)
    return build_parameters(mechanism_of(parameters), shapes, exact_geometry=exact, cells=cells), shapes


def state_vector(p: ThesisParameters, crank: Mapping[str, float], eta: Array, eta_rate: Array) -> Array:
    y = np.zeros(state_size(p))
    y[0], y[p.n + 1] = crank["crank_angle"], crank["crank_speed"]
    y[1 : p.n + 1], y[p.n + 2 : 2 * p.n + 2] = eta, eta_rate
    return y


def flexible(state: Mapping[str, float]) -> tuple[Array, Array]:
    """Amplitudes and rates of the single cubic."""
    value = np.array([state["tip_deflection"], state["tip_slope"]])
    return value, np.array([state["tip_deflection_rate"], state["tip_slope_rate"]])


def computed(equations: Equations, p: ThesisParameters, y: Array) -> Values:
    """What the thesis' model says about the state `y`.

    Raises:
        ValueError: it cannot be evaluated.
    """
    w = build_workspace(p.tables)
    good, slider, contact = equations.evaluate(p, w, y)
    if not good:
        raise ValueError("the model refuses the state")
    size = p.n + 1 if p.crank_is_free else p.n
    factor = np.tril(w.reduced[:size, :size])  # the solution leaves Cholesky's factor of the projected mass matrix
    free = np.r_[w.acceleration[:1], w.acceleration[2:]] if p.crank_is_free else w.acceleration[2:].copy()
    matrix = factor @ factor.T
    values = {
        "follower": np.array([slider.q2, contact.q2_rate]),
        "slider": np.array([slider.s, contact.s_rate]),
        "projected_mass_matrix": matrix,
        "projected_force": matrix @ free,
        "accelerations": free,
        "follower_acceleration": w.acceleration[1:2].copy(),
    }
    rate, row = np.zeros_like(y), np.zeros(1, ROW)
    if not equations.right_hand_side(p, w, y, rate, row.view(np.float64)):
        raise ValueError("the model refuses the state")
    column = {name: values[0] for name, values in recorded_columns(by_column(row)).items()}
    n = p.n
    values |= {name: np.array([column[name]]) for name in ("slider_force", "kinetic_energy", "strain_energy", "gravity_energy")}
    values |= {
        "shape": np.array([column[name] for name in SHAPE]),
        "bearings": np.array([column[name] for name in BEARINGS]),
        "moments": np.array([column[name] for name in (*MOMENTS, "moment_slider")]),
        "end_moments": np.array([column["moment_inboard"] - column["moment_slider"], column["moment_base"], column["moment_tip"]]),
        "normal_forces": np.array([column["axial_base"], column["axial_tip"], column["axial_inboard"] - column["axial_slider"]]),
        "normal_force_at_slider": np.array([column["axial_slider"]]),
        "state_rate": np.r_[rate[: n + 1], rate[n + 1 + (not p.crank_is_free) : 2 * n + 2]],
        "dissipated_power": rate[2 * n + 2 : 2 * n + 3],
        "drive_power": rate[2 * n + 3 :],
        "tip_position": np.array([column["tip_x"], column["tip_y"]]),
        "tip_acceleration": np.array([column["tip_acceleration"]]),
    }
    return values


def expected_cubic(parameters: Mapping[str, float], state: Mapping[str, float]) -> Values:
    """What the computer's derivation says about the single cubic."""
    eta, eta_rate = flexible(state)
    found = one_cubic().at(parameters, state, eta, eta_rate)
    return found | {
        "shape": _cubic(parameters["length"], state),
        "moments": _moments_of_cubic(parameters, state, float(found["slider"][0])),
        "state_rate": np.r_[state["crank_speed"], eta_rate, found["accelerations"]],
    }


def prescribed(parameters: Mapping[str, float], state: Mapping[str, float]) -> tuple[ThesisParameters, Values]:
    """Parameters of the single cubic with the crank at the state's speed, and what the derivation says of a scene without motor."""
    oracle, speed = expected_cubic(parameters, state), state["crank_speed"]
    mass, force = oracle["projected_mass_matrix"], oracle["projected_force"]
    accelerations = np.linalg.solve(mass[1:, 1:], force[1:])
    torque = mass[0, 1:] @ accelerations - force[0]  # the row of the crank, which does not accelerate
    mechanism = mechanism_of(parameters)
    mechanism = replace(mechanism, crank=replace(mechanism.crank, drive=PrescribedSpeed(speed=speed)))
    p = build_parameters(mechanism, hermite_elements(parameters["length"], 1), exact_geometry=False, cells=0)
    return p, {
        "projected_mass_matrix": mass[1:, 1:],
        "accelerations": accelerations,
        "drive_power": torque * speed + oracle["drive_power"],  # without a motor the oracle's is that of the force on the tip
        "kinetic_energy": oracle["kinetic_energy"],
    }


def _cubic(length: float, state: Mapping[str, float]) -> Array:
    """Deflection of the single cubic at the interior twelfths, m."""
    u = np.arange(1, 12) / 12.0
    return np.asarray((3.0 * u**2 - 2.0 * u**3) * state["tip_deflection"] + length * (u**3 - u**2) * state["tip_slope"])


def _moments_of_cubic(parameters: Mapping[str, float], state: Mapping[str, float], slider: float) -> Array:
    """EI times the second derivative of the single cubic at the interior twelfths and at the slider, N m."""
    L = parameters["length"]
    u = np.append(np.arange(1, 12) / 12.0, slider / L)
    curvature = (6.0 - 12.0 * u) * state["tip_deflection"] / L**2 + (6.0 * u - 2.0) * state["tip_slope"] / L
    return np.asarray(parameters["bending_stiffness"] * curvature)


def expected_shapes(
    parameters: Mapping[str, float], state: Mapping[str, float], shapes: ShapeSet, eta: Array, eta_rate: Array, *, exact: bool
) -> Values:
    """What it says about shapes on cells of equal length."""
    chord = parameters["crank_length"] * cmath.exp(1j * state["crank_angle"]) - parameters["pivot_distance"]
    return of_shapes(shapes, abs(chord), exact=exact).at(parameters, state, eta, eta_rate)


def largest_difference(found: Values, expected: Values) -> tuple[float, str]:
    """Largest difference over all names in `expected`, relative to the name's largest element."""
    worst, where = 0.0, ""
    for name, value in expected.items():
        relative = float(np.max(np.abs(found[name] - value)) / (np.max(np.abs(value)) or 1.0))
        if not relative <= worst:
            worst, where = relative, name
    return worst, where
