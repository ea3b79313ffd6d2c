"""Terms of the equations of motion that the computer derives from the description, at states of the hand-derived model.

All access to the internals of `reference_model` is here: `terms_by_hand` reads them off a workspace.
"""

from typing import Final

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from quickreturn.derive.equations import Equations
from quickreturn.derive.system import column
from quickreturn.reference_model.mechanism import Mechanism
from quickreturn.reference_model.model import BeamModel
from quickreturn.reference_model.motion.layout import Workspace, state_size
from quickreturn.witness.description import UNITS, constants, quick_return

Array = NDArray[np.float64]
Terms = dict[str, Array]

#: Angle (rad) by which the follower of an open loop stands off the crank tip, and its rate (rad/s).
OPENED: Final = 0.004
OPENING: Final = 0.4
#: Of the joint: what its force and friction do is told by what a newton of each does.
WITHOUT_FORCE: Final = dict.fromkeys(("joint_stiffness", "joint_damping", "joint_inertia", "joint_force", "friction"), 0.0)


class DerivedTerms:
    """The description's equations for a model's shapes, by CasADi's interpreter."""

    def __init__(self, model: BeamModel) -> None:
        self.model, self.rigid = model, model.closes_loop
        tables, n = model.parameters.tables, model.shapes
        system = quick_return(tables, n, rigid=self.rigid)
        e = Equations(system)
        self.table, self.given = system.tables[0], [k for loop in system.loops for k in loop.gives]
        values = column(*(symbol for symbol, _, _ in system.parameters.values()))
        self.function = ca.Function("terms", [e.q, e.v, values, self.table.row], [e.M, e.Q, e.gap, e.G, e.bias])
        size = len(system.coordinates)
        self.free = [0, *range(3, 3 + n), *([] if self.rigid else [1])]  # in the order of the hand-derived model
        self.q, self.v = np.zeros(size), np.zeros(size)

    def at(self, q: Array, v: Array, values: dict[str, float]) -> tuple[Array, ...]:
        """Mass matrix, forces, gap, its Jacobian and bias."""
        found = self.function(q, v, [values[name] for name in UNITS], self.table.at(q[2]))
        return tuple(np.array(each) for each in found)

    def random_state(self, seed: int) -> Array:
        """Slopes up to a third, every shape moving at its own pace, the crank turning either way; an open loop stands open, and opens."""
        scene, rng, n = self.model.scene, np.random.default_rng(seed), self.model.shapes
        assert isinstance(scene, Mechanism)
        values, x = constants(scene) | WITHOUT_FORCE, np.linspace(0.0, scene.follower.length, 101)
        q, v = np.zeros_like(self.q), np.zeros_like(self.v)
        q[0] = rng.uniform(0.0, 2.0 * np.pi)
        chord = scene.crank.length * np.exp(1j * q[0]) - scene.pivot_distance
        q[1], q[2] = np.pi + np.angle(-chord), abs(chord)
        size = 0.2 / np.max(np.abs(self.model._shapes(q[2], x)[0]), axis=0) / np.arange(1, n + 1)
        q[3 : 3 + n] = rng.uniform(-1.0, 1.0, n) * size
        v[0] = rng.uniform(5.0, 20.0) * rng.choice([-1.0, 1.0])
        v[3 : 3 + n] = rng.uniform(-100.0, 100.0, n) * size * np.arange(1, n + 1)
        if not self.rigid:
            q[1] += OPENED * rng.uniform(0.5, 1.0) * rng.choice([-1.0, 1.0])
        for _ in range(30):
            _, _, gap, G, _ = self.at(q, v, values)
            q[self.given] -= np.linalg.solve(G[:, self.given], gap).ravel()
        _, _, _, G, _ = self.at(q, v, values)
        if not self.rigid:
            closing = np.linalg.lstsq(G[:, [1, 2]], -G[:, :1] * v[0], rcond=None)[0]
            v[1] = closing[0, 0] + OPENING * rng.uniform(-1.0, 1.0)
        v[self.given] = 0.0
        v[self.given] = -np.linalg.solve(G[:, self.given], G[:, :-1] @ v)
        self.q, self.v = q, v
        m, y = self.model.parameters.speeds, np.zeros(state_size(self.model.parameters))
        y[:m], y[m], y[m + 1 : 2 * m + 1] = q[self.free], q[2], v[self.free]
        return y

    def terms(self) -> Terms:
        """At the state drawn last."""
        scene = self.model.scene
        assert isinstance(scene, Mechanism)
        values, given, free = constants(scene) | WITHOUT_FORCE, self.given, self.free
        M, Q, _, G, bias = self.at(self.q, self.v, values)
        B, rest = of_free_speeds(G, bias, given, free)
        M, force = M[:-1, :-1], Q[:-1]
        first = self.model.parameters.first
        found = {
            "mass matrix": (B.T @ M @ B)[first:, first:],
            "forces": (B.T @ (force - M @ rest))[first:, 0],
            "base angle": np.exp(1j * self.q[1:2]).view(np.float64),
            "base partial rates": B[1],
            "slider partial rates": B[2],
            "base rate": self.v[1:2],
            "slider rate": self.v[2:3],
            "slider bias": rest[2],
        }
        if self.rigid:
            return found | {"base bias": rest[1]}
        of_joint, of_friction = (force - self.at(self.q, self.v, values | {name: 1.0})[1][:-1] for name in ("joint_force", "friction"))
        gap = self.q[-1:], self.v[-1:], B[-1], rest[-1]
        found |= dict(zip(("gap", "gap rate", "gap partial rates", "gap bias"), gap, strict=True))
        return found | {"spread of the force": (B.T @ of_joint)[:, 0], "spread of the friction": (B.T @ of_friction)[:, 0]}


def of_free_speeds(G: Array, bias: Array, given: list[int], free: list[int]) -> tuple[Array, Array]:
    """All speeds by the free ones, v = B u, and what is left of the accelerations, q'' = B u' + rest, where time does not occur."""
    inverse, size = np.linalg.inv(G[:, given]), G.shape[1] - 1
    B, rest = np.zeros((size, len(free))), np.zeros((size, 1))
    B[free, range(len(free))], B[given], rest[given] = 1.0, -inverse @ G[:, free], -inverse @ bias
    return B, rest


def terms_by_hand(model: BeamModel, w: Workspace) -> Terms:
    """The same of the state that filled a workspace of the hand-derived model last."""
    f, first, m = w.facts, model.parameters.first, model.parameters.speeds
    lower = w.M[first:m, first:m]
    found = {
        "mass matrix": np.tril(lower) + np.tril(lower, -1).T,
        "forces": w.Q[first:m],
        "base angle": np.array([complex(f.frame)]).view(np.float64),
        "base partial rates": w.c[:m],
        "slider partial rates": w.sigma[:m],
        "base rate": np.array([f.q2_rate]),
        "slider rate": np.array([f.s_rate]),
        "slider bias": np.array([f.s_bias]),
    }
    if model.closes_loop:
        return found | {"base bias": np.array([f.q2_bias])}
    gap = (np.array([f.gap]), np.array([f.gap_rate]), w.row_of_gap[:m], np.array([f.gap_bias]))
    found |= dict(zip(("gap", "gap rate", "gap partial rates", "gap bias"), gap, strict=True))
    return found | {"spread of the force": w.spread[:m], "spread of the friction": w.sigma[:m]}


def sizes(terms: Terms, speeds: Array) -> dict[str, float]:
    """What a term's difference is relative to; biases are sums of larger parts that cancel, centripetal ones."""
    square = float(np.max(np.abs(speeds))) ** 2
    return {name: max(float(np.max(np.abs(value))), square if "bias" in name else 0.0) for name, value in terms.items()}
