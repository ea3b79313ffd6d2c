"""The one beam a second time, by the computer: every term of its equations and every output, at random states, with every joint.

The description is the engine's (`quickreturn.plugins.derive.witness`), here with every line that a slider rides on, and of a follower
alone. CasADi differentiates it; accelerations, the joint's force and friction follow from its terms by numpy, and what is read off the
motion is recovered as the engine does. Nothing of `reference_model.motion` is used but the tables of the shapes.

All access to the internals of `reference_model` is here and in `by_hand`, which reads them off a workspace.
"""

import math
from dataclasses import dataclass, replace
from typing import Any, Final

import casadi as ca
import numpy as np

from quickreturn.derive import System, turned, vector
from quickreturn.plugins.derive.equations import Equations
from quickreturn.plugins.derive.system import column
from quickreturn.plugins.derive.witness.description import UNITS, Follower, constants, follower, quick_return
from quickreturn.plugins.derive.witness.recovery import columns
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.columns import COLUMNS
from quickreturn.reference_model.joint import CHORDS, CLOSED, LEVER, ROLLERS, SliderConstraint
from quickreturn.reference_model.mechanism import FollowerAlone, Mechanism
from quickreturn.reference_model.model import BeamModel
from quickreturn.reference_model.motion.layout import BeamTables, state_size
from quickreturn.reference_model.shapes import ShapeSet
from quickreturn.reference_model.spring import spring_stiffness
from tests.engines.scenes import run_24
from tests.reference_model.motion.roller_law import force_of_rollers, sliding_share


def follower_alone(scene: FollowerAlone, tables: BeamTables, shapes: int) -> tuple[System, Follower]:
    """The follower alone: its base turns as prescribed (DERIVATION.md, equation 11.1), and the points stay where they are."""
    system = System("follower alone")
    p = system.constants(**{name: (1.0, unit) for name, unit in UNITS.items()})
    system.gravity = vector(p.gravity_1, p.gravity_2)
    q2, s = system.coordinate("follower_angle", "rad", rate="follower_rate"), system.coordinate("slider_position", "m")
    arm = follower(system, p, q2, s, tables, shapes)
    speed, time, t = scene.spin_up.speed, scene.spin_up.time, system.time
    starting = speed / time * (t**2 / 2.0 + (time / (2.0 * math.pi)) ** 2 * (ca.cos(2.0 * math.pi * t / time) - 1.0))
    system.loop("base", q2 - ca.if_else(t < time, starting, speed * (t - time / 2.0)), "rad", gives=[q2])
    system.loop("place", s - tables.low, gives=[s])
    system.output("strain_energy", arm.strain, "J")
    absent = ("crank_angle", "crank_speed", "slider_force", "slider_moment", "crank_torque")
    vectors = ("slider_on_follower", "tool", "slide", "foot", "crank_force")
    for name in (*absent, *(f"{name}_{k}" for name in vectors for k in (0, 1))):
        system.output(name, 0.0, "1")
    return system, arm


def nodes(system: System, arm: Follower) -> tuple[ca.SX, ca.SX, ca.SX]:
    """Places of the nodes of the slider's element, and the slider's share of its length."""
    beam, cell, s = arm.beam, arm.slider_cell, system.coordinates[2].q
    left = beam.end(cell - 1) if cell else ca.SX(beam.origin)
    advance = s - system.freeze(s)
    return left, beam.end(cell + 1), (beam.lengths[cell] + advance) / (beam.lengths[cell] + beam.lengths[cell + 1])


def chord_line(system: System, arm: Follower) -> tuple[ca.SX, ca.SX, ca.SX]:
    """The line from node to node."""
    left, right, share = nodes(system, arm)
    chord = right - left
    return left + share * chord, ca.atan2(chord[1], chord[0]), ca.SX(0)


def lever(system: System, arm: Follower, q: ca.SX) -> ca.SX:
    """What a unit of force along the normal does, sign reversed, if the nodes carry it by the lever rule; shares and normal held."""
    left, right, share = nodes(system, arm)
    crank_tip = turned(system.coordinates[0].q, system.parameters["crank_length"][0])
    way = ca.jacobian(crank_tip, q) - (1 - share) * ca.jacobian(left, q) - share * ca.jacobian(right, q)
    return turned(arm.angle, 0, 1).T @ way


Values = dict[str, Any]

#: Angle (rad) by which the follower of an open loop stands off the crank tip, and its rate (rad/s).
OPENED: Final = 0.004
OPENING: Final = 0.4
#: The joint's force and friction are given as numbers.
WITHOUT_FORCE: Final = dict.fromkeys(("joint_stiffness", "joint_damping", "joint_inertia", "joint_force", "friction"), 0.0)
#: Of the equations of motion, which need no solution of a linear system.
TERMS: Final = (
    "mass matrix", "forces", "base angle", "base rate", "base partial rates", "base bias", "slider rate", "slider partial rates",
    "slider bias", "gap", "gap rate", "gap partial rates", "gap bias", "spread of the force", "spread of the friction",
)  # fmt: skip


@dataclass(frozen=True)
class State:
    """A state of a model, as its vector and in the coordinates of the description, and everything that the computer says about it."""

    witness: "DerivedBeam"
    y: Array
    q: Array
    v: Array
    time: float
    expected: Values

    @property
    def model(self) -> BeamModel:
        """By hand."""
        return self.witness.model


class DerivedBeam:
    """The description's equations for a model's shapes, by CasADi's interpreter.

    Args:
        model: derived by hand.
        constraint: that it was made with.
    """

    def __init__(self, model: BeamModel, constraint: SliderConstraint) -> None:
        self.model, self.constraint, p, scene = model, constraint, model.parameters, model.scene
        self.rigid, tables = model.closes_loop, p.tables
        self.scene = scene if isinstance(scene, Mechanism) else _carrier(scene)
        self.alone = isinstance(scene, FollowerAlone)
        # of elements the slider stays on one
        self.cell = _cell_at(tables, self.scene.pivot_distance)
        tables = tables._replace(slider_cell=np.array([float(self.cell)]))
        arms: list[Follower] = []

        def line(system: System, arm: Follower) -> tuple[ca.SX, ca.SX, ca.SX]:
            arms.append(arm)
            return chord_line(system, arm) if p.constraint == CHORDS else (arm.place, arm.angle, arm.curvature)

        if isinstance(scene, FollowerAlone):
            system, arm = follower_alone(scene, tables, p.n)
        else:
            spring = scene.acting_spring is not None
            system = quick_return(tables, p.n, rigid=self.rigid, prescribed=not scene.crank_is_free, spring=spring, line=line)
            (arm,) = arms
        names = [each.name for each in system.coordinates]
        self.q2, self.s = names.index("follower_angle"), names.index("slider_position")
        etas = [names.index(f"eta_{k}") for k in range(1, p.n + 1)]
        for k, added in zip(etas, p.added_inertia, strict=True):
            system.body(f"slows {names[k]}", inertia=added, angle=system.coordinates[k].q)
        e, self.system, self.table = Equations(system), system, system.tables[0]
        # in the order of the hand-derived model, in which time takes the place of the crank of a follower alone
        self.free = [*([] if self.alone else [0]), *etas, *([] if self.rigid or self.alone else [self.q2])]
        self.etas, self.first = etas, 0 if self.alone else p.first
        loops = [loop for loop in system.loops if loop.name != "drive"]
        self.given = [k for loop in loops for k in loop.gives]
        rows = range(e.gap.numel() - len(self.given), e.gap.numel())
        values = column(*(symbol for symbol, _, _ in system.parameters.values()))
        state = [e.q, e.v, system.time, values, self.table.row]
        self.equations = ca.Function("terms", state, [e.M, e.Q, e.gap[rows], e.G[rows, :], e.bias[rows]])
        self.sums = ca.Function("sums", state, [e.outputs["kinetic_energy"][0], e.outputs["potential_energy"][0], e.rates[-2]])
        results = {name: value for name, (value, _) in system.outputs.items()}
        results |= {f"tip_rate_{k}": system.rate(results[f"tip_{k}"]) for k in (0, 1)}
        if p.knows_frequency:
            stiffness = ca.diag(ca.hessian(arm.strain, e.q)[0])[etas]
            results["highest square"] = ca.mmax(stiffness / (1.0 + ca.DM(p.added_inertia)))
        if p.knows_frequency and self.scene.acting_spring is not None:
            row = ca.jacobian(results["spring_length"], e.q)
            results |= {f"spring_row_{k}": each for k, each in enumerate(ca.horzsplit(row))}
        if p.constraint == CHORDS:  # moments are those of a force on the follower itself, wherever the slider rides
            results |= {f"foot_{k}": each for k, each in enumerate(ca.vertsplit(arm.place - arm.beam.origin))}
        if p.constraint == LEVER:
            results |= {f"lever_{k}": each for k, each in enumerate(ca.horzsplit(lever(system, arm, e.q)))}
        self.names, present = list(results), column(*(e.q[k] for k in system.frozen))
        shown = ca.substitute(list(results.values()), [column(*system.frozen.values())], [present])
        forces = column(*(loop.force for loop in loops))
        self.results = ca.Function("results", [*state, e.a, forces], shown)

    @classmethod
    def following(cls, mechanism: Mechanism, modes: int, constraint: SliderConstraint = CLOSED, slowed_to: int = 0) -> "DerivedBeam":
        """With natural modes that follow the slider."""
        return cls(BeamModel.following(mechanism, modes, constraint, slowed_to=slowed_to), constraint)

    @classmethod
    def staying(cls, mechanism: Mechanism, shapes: ShapeSet, constraint: SliderConstraint = CLOSED) -> "DerivedBeam":
        """With shapes that stay where they are."""
        return cls(BeamModel.staying(mechanism, shapes, constraint), constraint)

    @classmethod
    def of_follower_alone(cls, scene: FollowerAlone, shapes: int | ShapeSet) -> "DerivedBeam":
        """The follower alone, half-way through its spin-up."""
        return cls(BeamModel.alone(scene, shapes), CLOSED)

    def values(self, q: Array, v: Array) -> dict[str, float]:
        """The scene's, without a force of the joint; a prescribed crank is where it is."""
        scene, p = self.scene, self.model.parameters
        found = constants(scene) | WITHOUT_FORCE
        found["damping_moment"] = scene.follower.bending_stiffness * p.bending_damping if p.bending_damping else 0.0
        if self.alone:
            found["pivot_distance"] = 0.0
        elif not scene.crank_is_free:
            found |= {"start_angle": q[0], "speed": v[0]}
        return found

    def at(self, q: Array, v: Array, time: float, values: dict[str, float]) -> tuple[Array, ...]:
        """Mass matrix, forces, and of the loops but the drive's gap, its Jacobian and bias."""
        return tuple(np.array(each) for each in self.equations(*self._state(q, v, time, values)))

    def _state(self, q: Array, v: Array, time: float, values: dict[str, float]) -> list[Any]:
        return [q, v, time, [values[name] for name in UNITS], self.table.at(q[self.s])]

    def random_state(self, seed: int) -> State:
        """Slopes up to a third, every shape moving at its own pace, the crank turning either way; an open loop stands open, and opens."""
        scene, rng, p, n = self.scene, np.random.default_rng(seed), self.model.parameters, self.model.parameters.n
        x, time = np.linspace(0.0, scene.follower.length, 101), 0.0
        q, v = np.zeros((2, len(self.system.coordinates)))
        if self.alone:
            q[self.s], time = p.tables.low, float(rng.uniform(0.5, 1.0))
        while not self.alone:
            q[0] = rng.uniform(0.0, 2.0 * np.pi)
            chord = scene.crank.length * np.exp(1j * q[0]) - scene.pivot_distance
            q[self.q2], q[self.s] = np.pi + np.angle(-chord), abs(chord)
            if _cell_at(p.tables, q[self.s]) == self.cell:
                break
        size = 0.2 / np.max(np.abs(self.model._shapes(q[self.s], x)[0]), axis=0) / np.arange(1, n + 1)
        q[self.etas] = rng.uniform(-1.0, 1.0, n) * size
        v[self.etas] = rng.uniform(-100.0, 100.0, n) * size * np.arange(1, n + 1)
        if not self.alone:
            v[0] = rng.uniform(5.0, 20.0) * rng.choice([-1.0, 1.0])
        values, opened = self.values(q, v), not (self.rigid or self.alone)
        if opened:
            self._close(q, v, time, values, [self.q2, self.s])
            q[self.q2] += OPENED * rng.uniform(0.5, 1.0) * rng.choice([-1.0, 1.0])
        self._close(q, v, time, values, self.given)
        _, _, _, G, _ = self.at(q, v, time, values)
        if opened:
            closing = np.linalg.lstsq(G[:, [self.q2, self.s]], -G[:, :1] * v[0], rcond=None)[0]
            v[self.q2] = closing[0, 0] + OPENING * rng.uniform(-1.0, 1.0)
        v[self.given] = 0.0
        v[self.given] = -np.linalg.solve(G[:, self.given], G @ np.append(v, 1.0))
        m, y = p.speeds, np.zeros(state_size(p))
        y[m - len(self.free) : m], y[m], y[2 * m + 1 - len(self.free) : 2 * m + 1] = q[self.free], q[self.s], v[self.free]
        if self.alone:
            y[0], y[m + 1] = time, 1.0
        return State(self, y, q, v, time, self.expected(q, v, time))

    def _close(self, q: Array, v: Array, time: float, values: dict[str, float], given: list[int]) -> None:
        for _ in range(30):
            _, _, gap, G, _ = self.at(q, v, time, values)
            q[given] -= np.linalg.solve(G[:, given], gap).ravel()

    def expected(self, q: Array, v: Array, time: float) -> Values:
        """Terms of the equations, what follows from them, and everything that is read off the motion."""
        p, given, values = self.model.parameters, self.given, self.values(q, v)
        M, Q, _, G, bias = self.at(q, v, time, values)
        B, rest = of_free_speeds(G, bias, given, self.free)
        M, force = M[:-1, :-1], Q[:-1]
        mass, loads = (B.T @ M @ B)[self.first :, self.first :], (B.T @ (force - M @ rest))[self.first :, 0]
        found: Values = {"mass matrix": mass, "forces": loads}
        contact = rubbing = 0.0
        acceleration = np.zeros(len(self.free))
        if self.rigid or self.alone:
            acceleration[self.first :] = np.linalg.solve(mass, loads)
        else:
            unit = [(force - self.at(q, v, time, values | {name: 1.0})[1][:-1]) for name in ("joint_force", "friction")]
            spread, of_friction = ((B.T @ each)[:, 0] for each in unit)
            if p.constraint == LEVER:
                shown = self._shown(q, v, np.zeros_like(q), np.zeros(len(given)), time, values)
                spread = np.array([shown[f"lever_{k}"] for k in range(len(q))]) @ B
            gap = {"gap": q[-1:], "gap rate": v[-1:], "gap partial rates": B[-1], "gap bias": rest[-1]}
            found |= gap | {"spread of the force": spread, "spread of the friction": of_friction}
            contact, rubbing = self._joint(found, v[self.s])
            found |= {"joint force": contact, "joint friction": rubbing}
            push = contact * spread + rubbing * of_friction
            acceleration[self.first :] = np.linalg.solve(mass, loads - push[self.first :])
        if not self.alone:
            found |= {
                "base angle": np.exp(1j * q[[self.q2]]).view(np.float64), "base rate": v[[self.q2]], "base partial rates": B[self.q2],
                "slider rate": v[[self.s]], "slider partial rates": B[self.s], "slider bias": rest[self.s],
            } | ({"base bias": rest[self.q2]} if self.rigid else {})  # fmt: skip
        every = B @ acceleration + rest[:, 0]
        held = np.linalg.solve(G[:, given].T, (M @ every - force[:, 0])[given])
        values |= {"joint_force": contact, "friction": rubbing}
        shown = self._shown(q, v, every, held, time, values)
        found["accelerations"] = np.append([0.0] if self.alone else [], acceleration)
        if p.knows_frequency:
            square = shown["highest square"]
            if (spring := self.scene.acting_spring) is not None:
                row = (np.array([shown[f"spring_row_{k}"] for k in range(len(q))]) @ B)[-p.n :]
                square += spring_stiffness(shown["spring_length"], spring.law) * float(np.sum(row**2 / np.diag(mass)[-p.n :]))
            found["frequency"] = math.sqrt(square * self._coupling(mass))
        return found | self._powers(shown, q, v, time, found, held) | self._observed(shown, q, v, time, held)

    def missed(self, state: State, off: float) -> float:
        """How far (m) a slider is from where it belongs that is `off` its place, along the line or in the length of the chord."""
        q = state.q.copy()
        q[self.s] += off
        values = self.values(q, state.v)
        if self.rigid:
            shown = self._shown(q, state.v, np.zeros_like(q), np.zeros(len(self.given)), state.time, values)
            chord = self.scene.crank.length * np.exp(1j * q[0]) - self.scene.pivot_distance
            return float(abs(chord) - abs(complex(shown["foot_0"], shown["foot_1"])))
        _, _, gap, G, _ = self.at(q, state.v, state.time, values)
        n1, n2 = G[:, -2]  # the normal, by which the gap's coordinate moves the slider
        return float(-gap[:, 0] @ [n2, -n1])

    def _coupling(self, mass: Array) -> float:
        """Factor on a shape's stiffness by which a free crank lifts the bound of the square of the frequency."""
        if self.model.parameters.first:
            return 1.0
        return float(1.0 / (1.0 - np.sum(mass[0, 1:] ** 2 / np.diag(mass)[1:]) / mass[0, 0]))

    def _joint(self, terms: Values, slides: float) -> tuple[float, float]:
        """Force and friction of the joint: of both signs of the force the one that the solution has."""
        p, slider, first = self.model.parameters, self.scene.slider, self.first
        gap, rate, row, rest = (terms[name] for name in ("gap", "gap rate", "gap partial rates", "gap bias"))
        sliding = sliding_share(slides, slider.friction_speed)
        if p.constraint == ROLLERS:
            in_line, of_force, wanted = self.constraint.inertia, -1.0, -force_of_rollers(self.constraint.rollers, gap[0], rate[0])[0]
        else:
            r = self.constraint.stabilization
            in_line, of_force, wanted = 1.0, 0.0, -2.0 * r * rate[0] - r**2 * gap[0]
        agreeing, size = [], len(terms["mass matrix"])
        for sign in (1.0, -1.0):
            rubs = slider.friction * sign * sliding
            A = np.zeros((size + 1, size + 1))
            A[:size, :size], A[size, size] = terms["mass matrix"], of_force
            A[:size, size] = (terms["spread of the force"] + rubs * terms["spread of the friction"])[first:]
            A[size, :size] = in_line * row[first:]
            loads = terms["forces"] - slider.friction_force * sliding * terms["spread of the friction"][first:]
            contact = float(np.linalg.solve(A, np.append(loads, wanted - in_line * rest[0]))[size])
            if contact * sign >= 0.0:
                agreeing.append((contact, (slider.friction_force + slider.friction * abs(contact)) * sliding))
        (found,) = agreeing
        return found

    def _shown(self, q: Array, v: Array, a: Array, held: Array, time: float, values: dict[str, float]) -> dict[str, float]:
        found = self.results(*self._state(q, v, time, values), a, held)
        each = self.system.coordinates
        of_coordinates = {c.name: q[k] for k, c in enumerate(each)} | {c.rate_name: v[k] for k, c in enumerate(each)}
        return dict(zip(self.names, map(float, found), strict=True)) | of_coordinates

    def _powers(self, shown: dict[str, float], q: Array, v: Array, time: float, found: Values, held: Array) -> Values:
        """Power lost, of the drive and the tool, and of an open joint, W; and energies, J."""
        p, rollers, values = self.model.parameters, self.constraint.rollers, self.values(q, v)
        kinetic, potential, lost = (float(each) for each in self.sums(*self._state(q, v, time, values)))
        strain = shown["strain_energy"]
        energies = {"kinetic_energy": kinetic, "strain_energy": strain, "gravity_energy": potential - strain}
        if self.alone:
            return energies | {"powers": np.array([lost, held[0] * v[self.q2]])}
        tool = sum(shown[f"tool_{k}"] * shown[f"tip_rate_{k}"] for k in (0, 1))
        powers = [lost, shown["crank_torque"] * v[0] + tool]
        if not self.rigid:
            gap, rate = q[-1], v[-1]
            _, stored, heat = force_of_rollers(rollers, gap, rate) if p.constraint == ROLLERS else (0.0, 0.0, 0.0)
            powers[0] += heat + found["joint friction"] * v[self.s]
            joint = -found["joint force"] * float(found["spread of the force"] @ v[self.free])
            powers.append(joint)
            energies["kinetic_energy"] += 0.5 * self.constraint.inertia * rate**2
            energies["strain_energy"] += stored
            energies |= {"gap_rate": rate, "joint_power": joint}
        return energies | {"powers": np.array(powers)}

    def _observed(self, shown: dict[str, float], q: Array, v: Array, time: float, held: Array) -> Values:
        """Columns of a trajectory but energies, which the joint adds to."""
        p, angle = self.model.parameters, q[self.q2]
        energies = dict.fromkeys(("kinetic_energy", "potential_energy", "dissipated_energy", "work"), 0.0)
        rows = {name: np.array([value]) for name, value in (shown | energies).items()}
        found = {name: float(value[0]) for name, value in columns(self.scene, rows, p.bending_damping).items()}
        if self.alone:
            tip = complex(found["tip_x"] - self.scene.pivot_distance, found["tip_y"]) * np.exp(1j * (angle - found["follower_angle"]))
            found |= {"tip_x": tip.real, "tip_y": tip.imag, "follower_angle": angle, "crank_torque": held[0]}
            found = {name: value for name, value in found.items() if name == "crank_torque" or not COLUMNS[name].of_slider}
        ours = ("dissipated_energy", "drive_work", "kinetic_energy", "strain_energy", "gravity_energy")
        return {name: value for name, value in found.items() if name not in ours}


def _carrier(scene: FollowerAlone) -> Mechanism:
    """A mechanism whose follower, base and tip are those of a follower alone."""
    return replace(run_24(), base=scene.base, follower=scene.follower, tip=scene.tip, gravity=scene.gravity)


def _cell_at(tables: BeamTables, s: float) -> int:
    interval = min(max(int((s - tables.low) / tables.step), 0), len(tables.slider_cell) - 1)
    return int(tables.slider_cell[interval])


def of_free_speeds(G: Array, bias: Array, given: list[int], free: list[int]) -> tuple[Array, Array]:
    """All speeds by the free ones, v = B u + c, and what is left of the accelerations, q'' = B u' + rest."""
    inverse, size = np.linalg.inv(G[:, given]), G.shape[1] - 1
    B, rest = np.zeros((size, len(free))), np.zeros((size, 1))
    B[free, range(len(free))], B[given], rest[given] = 1.0, -inverse @ G[:, free], -inverse @ bias
    return B, rest
