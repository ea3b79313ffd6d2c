"""Every term of the hand-derived equations of motion against the computer's derivation, at random states: every joint, every quantity.

Both read the shapes from the same tables and do the rest in different ways. Found: 1e-14 and less.
"""

import math
from collections.abc import Callable
from functools import cache
from typing import Final

import numpy as np
import pytest

pytest.importorskip("casadi")

from quickreturn.reference_model.joint import joint_force
from quickreturn.reference_model.model import BeamModel
from quickreturn.reference_model.slider_constraint import ROLLERS
from tests.quickreturn.derived_terms import DerivedTerms, sizes, terms_by_hand
from tests.reference_model.beam_states import (
    APART,
    BARE,
    BY_FORCE,
    COMPLIANT,
    DAMPED,
    EVERYTHING,
    FREE,
    HEAVY,
    ON_ELEMENTS,
    PRELOADED,
    RUBBING,
    at_constant_speed,
    elements_of,
    modes_of,
    rates,
)

#: Of a term's largest element: rounding, a hundredfold.
SAME: Final = 1e-12
#: The same behind the solution of the linear system, whose condition is up to 1e5.
SOLVED: Final = 1e-10

MODELS: Final[dict[str, Callable[[], BeamModel]]] = {
    "rigid": lambda: BeamModel.following(EVERYTHING, 2),
    "rigid, five shapes": lambda: BeamModel.following(EVERYTHING, 5),
    "rigid, bare scene": lambda: BeamModel.following(BARE, 1),
    "rigid, prescribed speed": lambda: BeamModel.following(at_constant_speed(DAMPED), 2),
    "material damping": lambda: BeamModel.following(DAMPED, 3),
    "compliant": lambda: BeamModel.following(EVERYTHING, 2, COMPLIANT),
    "compliant with inertia": lambda: BeamModel.following(at_constant_speed(EVERYTHING), 2, HEAVY),
    "rollers with clearance, rubbing": lambda: BeamModel.following(RUBBING, 2, APART),
    "rollers with preload, rubbing": lambda: BeamModel.following(at_constant_speed(RUBBING), 2, PRELOADED),
    "rollers apart": lambda: BeamModel.following(RUBBING, 1, FREE),
    "multiplier, rubbing": lambda: BeamModel.following(DAMPED, 2, BY_FORCE),
    "multiplier, rubbing, prescribed speed": lambda: BeamModel.following(at_constant_speed(RUBBING), 2, BY_FORCE),
    "shapes that stay": lambda: BeamModel.staying(EVERYTHING, modes_of(EVERYTHING, 3)),
    "shapes that stay, rollers": lambda: BeamModel.staying(RUBBING, modes_of(EVERYTHING, 2), APART),
    "one element, multiplier": lambda: BeamModel.staying(ON_ELEMENTS, elements_of(EVERYTHING, 1), BY_FORCE),
}


@cache
def derived(name: str) -> DerivedTerms:
    return DerivedTerms(MODELS[name]())


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("name", MODELS)
def test_terms_and_accelerations(name: str, seed: int) -> None:
    witness = derived(name)
    model, y = witness.model, witness.random_state(seed)
    p, f, m = model.parameters, model.workspace.facts, model.parameters.speeds
    rate = rates(model, y)
    expected, found = witness.terms(), terms_by_hand(model, model.workspace)
    assert set(found) == set(expected)
    for term, size in sizes(expected, y[m + 1 : 2 * m + 1]).items():
        np.testing.assert_allclose(found[term], expected[term], rtol=0.0, atol=SAME * size, err_msg=term)

    forces, first = expected["forces"], p.first
    if not model.closes_loop:  # with the joint's force and friction as found, the motion, and of that what the force must be
        forces = forces - (f.force * expected["spread of the force"] + f.friction * expected["spread of the friction"])[first:]
    acceleration = np.zeros(m)
    acceleration[first:] = np.linalg.solve(expected["mass matrix"], forces)
    np.testing.assert_allclose(rate[m + 1 : 2 * m + 1], acceleration, rtol=0.0, atol=SOLVED * np.max(np.abs(acceleration)))
    if model.closes_loop:
        return
    opening = float(expected["gap partial rates"] @ acceleration + expected["gap bias"][0])
    gap, gap_rate, largest = float(expected["gap"][0]), float(expected["gap rate"][0]), float(np.max(np.abs(acceleration)))
    if p.constraint == ROLLERS:
        rollers = joint_force(gap, gap_rate, p.plus, p.minus, p.plus_from, p.minus_from, p.contact_loss, p.joint_damping)
        assert f.force == pytest.approx(rollers + p.joint_inertia * opening, abs=SOLVED * max(1.0, p.joint_inertia * largest))
    else:
        assert opening == pytest.approx(-2.0 * p.stabilization * gap_rate - p.stabilization**2 * gap, abs=SOLVED * largest)
    friction = p.friction_force + p.friction * abs(f.force)
    assert f.friction == pytest.approx(friction * math.tanh(float(expected["slider rate"][0]) / p.friction_speed), rel=SOLVED)
