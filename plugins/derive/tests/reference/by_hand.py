"""What the hand-derived beam says of a state, by the names of `DerivedBeam.expected`, and what differences are relative to."""

from collections.abc import Mapping
from typing import Any, Final

import numpy as np

from quickreturn.plugins.derive.tests.reference.derived_beam import State
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.columns import AXIAL, BEARINGS, BENDING, SHAPE
from quickreturn.reference_model.model import BeamModel
from quickreturn.reference_model.motion.layout import BeamWorkspace

Values = dict[str, Any]

PLACES: Final = ("follower_angle", "slider_position", "tip_x", "tip_y", "tip_deflection", *SHAPE)


def by_hand(model: BeamModel, w: BeamWorkspace, rate: Array, shown: Mapping[str, Any]) -> Values:
    """What the hand-derived model says of the state that filled a workspace last, by the names of `DerivedBeam.expected`.

    Args:
        model: by hand.
        w: its workspace.
        rate: dy/dt.
        shown: observables by name.
    """
    f, first, m = w.facts, model.parameters.first, model.parameters.speeds
    lower = w.M[first:m, first:m]
    found: Values = {
        "mass matrix": np.tril(lower) + np.tril(lower, -1).T, "forces": w.Q[first:m], "accelerations": rate[m + 1 : 2 * m + 1],
        "base angle": np.array([complex(f.frame)]).view(np.float64), "base rate": np.array([f.q2_rate]), "base partial rates": w.c[:m],
        "base bias": np.array([f.q2_bias]), "slider rate": rate[m : m + 1], "slider partial rates": w.sigma[:m],
        "slider bias": np.array([f.s_bias]), "gap": np.array([f.gap]), "gap rate": np.array([f.gap_rate]),
        "gap partial rates": w.row_of_gap[:m], "gap bias": np.array([f.gap_bias]), "spread of the force": w.spread[:m],
        "spread of the friction": w.sigma[:m], "joint force": f.force, "joint friction": f.friction,
        "powers": rate[2 * m + 1 :], "frequency": w.watched[1],
    }  # fmt: skip
    return found | dict(shown)


def sizes(state: State) -> dict[str, float]:
    """What a difference is relative to.

    Rates are sums over the free speeds, and biases of centripetal parts, which cancel; so do normal forces, of what the pivot bears. Places
    are measured by the follower's length, moments and strains by the largest ones, small powers and forces by a thousandth of a watt and
    newton.
    """
    expected, scene, speeds = state.expected, state.witness.scene, np.abs(state.v[state.witness.free])
    square = float(np.max(np.abs(state.v))) ** 2
    largest = {name: float(np.max(np.abs(value))) for name, value in expected.items()}
    strains = [f"strain_{k}" for k in (1, 2, 3)]
    groups = BENDING, BEARINGS[:2], BEARINGS[2:], (*AXIAL, *BEARINGS[:2]), strains
    for names in ([name for name in group if name in expected] for group in groups):
        largest |= dict.fromkeys(names, max((largest[name] for name in names), default=0.0))
    of_rates = [name for name in ("base", "slider", "gap") if f"{name} rate" in expected]
    largest |= {f"{name} rate": float(np.abs(expected[f"{name} partial rates"]) @ speeds) for name in of_rates}
    largest |= {name: scene.follower.length for name in PLACES if name in expected}
    largest["constraint_gap"] = scene.follower.length
    return {name: max(size, square if "bias" in name else 1e-9 if name in strains else 1e-3) for name, size in largest.items()}
