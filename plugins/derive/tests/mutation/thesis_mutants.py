"""Mutants of the thesis' equations, each of which must miss the computer's derivation in some state."""

import dataclasses
import math
from functools import cache

import numpy as np

from quickreturn.plugins.derive.tests.mutation.mutation import Hunt, Source, plain
from quickreturn.plugins.derive.tests.reference.oracle_scene import (
    Equations,
    Values,
    build,
    computed,
    draw_case,
    expected_cubic,
    expected_shapes,
    flexible,
    largest_difference,
    mechanism_of,
    prescribed,
    state_vector,
)
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.shapes import ShapeSet
from quickreturn.reference_model.state import State
from quickreturn.reference_model.thesis import dynamics, equations, kinematics, observables
from quickreturn.reference_model.thesis.parameters import ThesisParameters, build_parameters

SOURCE = Source(
    modules=(kinematics, dynamics, observables, equations),
    no_equations=frozenset(
        {
            "factorize",
            "substitute",
            "_full_index",
            "observe",
            "curvature_of_shape",
            "base_right_hand_side",  # the follower alone has a test of its own
            "_no_slider",
        }
    ),
    stand_ins=dict.fromkeys(("compiled", "inlined", "inner", "parameters_at", "workspace_at"), plain)
    | {"state_of": lambda y, n: State.of(y, slider=False)},
    entry=lambda defined: Equations(lambda p, w, y: defined["evaluate"](p, w, State.of(y, slider=False)), defined["right_hand_side"]),
)

#: That of test_thesis_equations.py; the unchanged source lies three decades below.
TOLERANCE = 1e-10

#: Changes without effect, and why.
EQUIVALENT = {
    ("centre_line", "slope_rate -= t.dphi[p, i] * eta_rate[i]"): "the rate of W' enters H squared and nothing else",
    ("energies", "curvature -= p.tables.ddphi[point, i] * y.eta[i]"): "the strain energy is quadratic in the curvature",
}


@dataclasses.dataclass(frozen=True)
class Check:
    """One state with all optional parts on, and what the computer's derivation says about it."""

    parameters: ThesisParameters
    state: Array
    expected: Values

    def difference(self, equations: Equations) -> float:
        """From it; infinite where the state cannot be evaluated."""
        try:
            with np.errstate(all="ignore"):
                found = computed(equations, self.parameters, self.state)
            return largest_difference(found, self.expected)[0]
        except (ValueError, ZeroDivisionError, OverflowError, IndexError, np.linalg.LinAlgError):
            return np.inf


@cache
def checks() -> tuple[Check, ...]:
    """Two states of the single cubic, one with the crank's speed prescribed, one of other shapes, one in exact geometry."""
    made = []
    for seed in (1, 3):
        parameters, state = draw_case(seed, present=1.0)
        p, _ = build(parameters)
        made.append(Check(p, state_vector(p, state, *flexible(state)), expected_cubic(parameters, state)))
    return (*made, _exchanged(), _prescribed(), _quartics(), _exact())


def _exchanged() -> Check:
    """Crank's length and distance of the pivots exchanged, so that the follower turns fully."""
    parameters, state = draw_case(1, present=1.0)
    parameters |= {"crank_length": parameters["pivot_distance"], "pivot_distance": parameters["crank_length"]}
    state |= {"crank_angle": 2.0}  # the oracle's follower is in its first turn
    p, _ = build(parameters)
    return Check(p, state_vector(p, state, *flexible(state)), expected_cubic(parameters, state))


def _prescribed() -> Check:
    parameters, state = draw_case(5, present=1.0, lacking=("crank_torque", "crank_damping"))
    p, expected = prescribed(parameters, state)
    return Check(p, state_vector(p, state, *flexible(state)), {name: expected[name] for name in ("accelerations", "drive_power")})


def _quartics() -> Check:
    """(x/L)^2 and (x/L)^4 on two cells, the slider in the second: higher derivatives and cells that do not begin at the base."""
    parameters, state = draw_case(1, present=1.0)
    L = parameters["length"]
    coefficients = np.zeros((2, 5, 2))
    for i, power in enumerate((2, 4)):
        coefficients[0, power, i] = 0.5**power
        coefficients[1, : power + 1, i] = [math.comb(power, k) * 0.5**power for k in range(power + 1)]
    shapes = ShapeSet(np.array([0.0, 0.5 * L, L]), coefficients, has_continuous_curvature=True)
    eta, eta_rate = np.array([0.08, -0.03]), np.array([-1.0, 1.5])
    p = build_parameters(mechanism_of(parameters), shapes, exact_geometry=False, cells=16)  # quadrature error 2e-10 with eight
    expected = expected_shapes(parameters, state, shapes, eta, eta_rate, exact=False)
    return Check(p, state_vector(p, state, eta, eta_rate), expected)


def _exact() -> Check:
    parameters, state = draw_case(4, present=1.0)
    eta, eta_rate = flexible(state)
    p, shapes = build(parameters, exact=True, cells=8)  # quadrature error 3e-12, see test_thesis_equations.py
    return Check(p, state_vector(p, state, eta, eta_rate), expected_shapes(parameters, state, shapes, eta, eta_rate, exact=True))


HUNT = Hunt(SOURCE, checks, TOLERANCE, EQUIVALENT, least=800)
