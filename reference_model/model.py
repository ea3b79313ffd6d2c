"""The explicit model of one scene: shapes, slider constraint, equations, integration and observables under one roof."""

import math
import time
from collections.abc import Callable
from functools import partial
from typing import Final

import numpy as np
import scipy  # whose parts are imported when they are used
from numpy.typing import NDArray

from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.beam import tables as beam
from quickreturn.reference_model.columns import NUMBERS, recorded_columns
from quickreturn.reference_model.constants import characteristic_frequency, crank_speed_scale, pace
from quickreturn.reference_model.entries import KERNEL, LINEARISED, OBSERVATIONS, WEIGHED
from quickreturn.reference_model.integrate import STEP_TOO_SMALL, Equations, Integration, Linearisation, dop853, radau
from quickreturn.reference_model.joint import BASE, CLOSED, ELIMINATED, ROLLERS, SliderConstraint
from quickreturn.reference_model.mechanism import FollowerAlone, Mechanism, Scene
from quickreturn.reference_model.motion.layout import BeamParameters, ShapeRow, state_size, workspace
from quickreturn.reference_model.motion.parameters import parameters
from quickreturn.reference_model.native.memory import Placed
from quickreturn.reference_model.natural_modes import clamped_modes
from quickreturn.reference_model.rigid import deflection_scale, rigid_motion, stiffness_across
from quickreturn.reference_model.shapes import ShapeSet, decoupled, no_shapes
from quickreturn.reference_model.state import State

#: Function of the slider's place (m) and arc lengths (m), shape (k,). It returns the shapes' tangent angles and their derivatives by the
#: slider's place, each of shape (k, n).
Angles = Callable[[float, Array], tuple[Array, Array]]


class ObservationFailed(RuntimeError):
    """The observables of a state cannot be evaluated. `row` is the state's index."""

    def __init__(self, row: int) -> None:
        super().__init__(f"state {row} cannot be evaluated")
        self.row = row


#: Decoupled shapes of the last model whose shapes stay, their tables, which may take a hundred megabytes, and the wall time for both, s.
_KEPT: Final[dict[tuple[Mechanism, bytes, bytes], tuple[ShapeSet, beam.BoundedTables, float]]] = {}


def _staying(scene: Mechanism, shapes: ShapeSet) -> tuple[ShapeSet, beam.BoundedTables, float]:
    """What `_KEPT` holds, for a scene and shapes: runs that differ in their tolerance follow each other."""
    key = scene, shapes.edges.tobytes(), shapes.coefficients.tobytes()
    if (found := _KEPT.get(key)) is None:
        began = time.perf_counter()
        free, squares = decoupled(shapes, scene.follower.mass_per_length, scene.follower.bending_stiffness)
        of_elements = shapes.count > 0 and shapes.coefficients.shape[1] == 4
        tables = (beam.elements if of_elements else beam.staying)(scene, free, squares)
        found = free, tables, time.perf_counter() - began
        _KEPT.clear()
        _KEPT[key] = found
    return found  # not what is kept by now: another thread may keep its own


class BeamModel:
    """The follower as one beam, described by the angle of its tangent in given shapes, with a slider constraint.

    `following`, `staying` and `alone` build one for a scene.

    Args:
        scene: the mechanism, or the follower alone.
        constants: of the equations.
        shapes: tangent angles of the shapes, see `Angles`.
        made_before: wall time (s) that an earlier model spent on parts that this one reuses.

    Attributes:
        made_before: as given.
        implicit: whether `integrate` is implicit: for stiff models, by `implicit.radau` in place of `integrate.dop853`.
        parameters: the constants.
        workspace: intermediate results for the state evaluated last.
    """

    def __init__(self, scene: Scene, constants: BeamParameters, shapes: Angles, made_before: float = 0.0) -> None:
        self.scene = scene
        self.made_before = made_before
        self.implicit = False
        self.parameters = constants
        self.workspace = workspace(constants)
        self._shapes = shapes
        # what errors of an amplitude are relative to, kg^(1/2) m
        self._size = deflection_scale(scene) * math.sqrt((scene.follower.mass_per_length or 1.0) * scene.follower.length)
        self._at = Placed(constants), Placed(self.workspace)

    @classmethod
    def following(
        cls,
        scene: Scene,
        modes: int,
        constraint: SliderConstraint = CLOSED,
        *,
        slowed_to: int = 0,
        slowed_above: float = 0.0,
        at: float | None = None,
    ) -> "BeamModel":
        """A model whose shapes follow the slider: the first `modes` modes of the follower supported there.

        A rigid follower has no shapes, and the follower alone has clamped modes, none of them slowed. `slowed_to`, `slowed_above`: see
        `motion.parameters.added_inertia`; `at`: see `beam.tables.following`.
        """
        if scene.crank is None:
            return cls.alone(scene, modes)
        if scene.follower.is_rigid:
            return cls.staying(scene, no_shapes(scene.follower.length), constraint)
        tables, reach, family, seconds = beam.following(scene, modes, at=at)
        constants = parameters(scene, modes, tables, reach, constraint, slowed_to=slowed_to, slowed_above=slowed_above)
        return cls(scene, constants, family.angles, seconds)

    @classmethod
    def staying(cls, scene: Scene, shapes: ShapeSet, constraint: SliderConstraint = CLOSED, *, slowed_to: int = 0) -> "BeamModel":
        """A model whose shapes do not move with the slider: slopes of clamped-free modes, or of cubic elements.

        `slowed_to`: see `motion.parameters.added_inertia`; the modes are those of the clamped follower in these shapes. The follower
        alone has none of them slowed.

        Raises:
            ValueError: a slider with rotary inertia on shapes whose curvature jumps.
        """
        if scene.crank is None:
            return cls.alone(scene, shapes)
        if scene.slider.inertia > 0.0 and not shapes.has_continuous_curvature:
            raise ValueError("a slider with rotary inertia needs shapes with continuous curvature: clamped-free modes or one element")
        began = time.perf_counter()
        free, (tables, reach), seconds = _staying(scene, shapes)
        before = max(0.0, seconds - (time.perf_counter() - began))
        constants = parameters(scene, free.count, tables, reach, constraint, slowed_to=slowed_to)
        return cls(scene, constants, partial(_unmoved, partial(free.evaluate, derivative=1)), before)

    @classmethod
    def alone(cls, scene: FollowerAlone, shapes: int | ShapeSet) -> "BeamModel":
        """A model of the follower alone, in its first `shapes` clamped modes (at least 1) or in given shapes."""
        if isinstance(shapes, int):
            clamped = clamped_modes(scene, shapes)
            squares, nodes = (2.0 * np.pi * clamped.frequencies) ** 2, None

            def angles(x: Array) -> Array:
                return clamped.deflection(x, 1).T
        else:
            free, squares = decoupled(shapes, scene.follower.mass_per_length, scene.follower.bending_stiffness)
            angles, nodes = partial(free.evaluate, derivative=1), free.edges if free.coefficients.shape[1] == 4 else None
        tables = beam.clamped(scene, angles, squares, nodes)
        constants = parameters(scene, len(squares), tables, scene.follower.length)
        return cls(scene, constants, partial(_unmoved, angles))

    def with_fewer_shapes(self, count: int) -> "BeamModel":
        """The model in the first `count` shapes, with the same Gauss points: a selection of columns of its tables."""
        p, t = self.parameters, self.parameters.tables
        tables = t._replace(coefficients=beam.padded_to_lines(ShapeRow.of(t.coefficients, p.n, t).first(count).joined))
        fewer = p._replace(n=count, speeds=p.speeds - p.n + count, added_inertia=p.added_inertia[:count], tables=tables)

        def shapes(s: float, x: Array) -> tuple[Array, Array]:
            psi, psi_s = self._shapes(s, x)
            return psi[:, :count], psi_s[:, :count]

        model = BeamModel(self.scene, fewer, shapes)
        model.implicit = self.implicit
        return model

    @property
    def shapes(self) -> int:
        """Number of shapes."""
        return self.parameters.n

    @property
    def closes_loop(self) -> bool:
        """Whether the follower's angle is no coordinate: the slider is on the centre line by construction."""
        return self.parameters.constraint == ELIMINATED

    @property
    def degrees_of_freedom(self) -> int:
        """Number of free speeds: amplitudes, with an open loop the follower's angle, and the crank unless its speed is prescribed."""
        return self.parameters.speeds - self.parameters.first

    def straight_state(self, crank_angle: float, crank_speed: float) -> Array:
        """State vector with the follower straight and moving as the rigid mechanism does."""
        assert self.scene.crank is not None
        motion = rigid_motion(self.scene, np.array(crank_angle), crank_speed)
        y = np.zeros(state_size(self.parameters))
        state = State.of(y)
        state.q[0], state.s[0], state.u[0] = crank_angle, motion.slider_position, crank_speed
        if not self.closes_loop:
            state.q[-1], state.u[-1] = motion.follower_angle, motion.follower_speed
        return y

    def state_at_rest(self) -> Array:
        """State vector of the follower alone at time 0, straight and still."""
        y = np.zeros(state_size(self.parameters))
        State.of(y).s[0], State.of(y).u[0] = self.parameters.tables.low, 1.0
        return y

    def bent_state(
        self, crank_angle: float, crank_speed: float, slider: tuple[float, float], x: Array, angle: Array, angle_rate: Array
    ) -> Array:
        """State vector closest to a given shape, without gap or gap rate; it cannot move if no place of the slider closes the loop.

        Args:
            crank_angle: rad.
            crank_speed: rad/s.
            slider: arc length (m) and its rate (m/s) that close the loop for the given shape.
            x: arc lengths, m, shape (k,).
            angle: tangent angle relative to the base there, rad, shape (k,).
            angle_rate: its rate at fixed arc length, rad/s, shape (k,).
        """
        p, f = self.parameters, self.workspace.facts
        y = self.straight_state(crank_angle, crank_speed)
        state, (s, s_rate) = State.of(y), slider
        psi, psi_s = self._shapes(s, x)
        state.eta[:] = np.linalg.lstsq(psi, angle, rcond=None)[0]
        state.eta_rate[:] = np.linalg.lstsq(psi, angle_rate - psi_s @ state.eta * s_rate, rcond=None)[0]
        v1, v2 = p.LA * math.cos(crank_angle) - p.d, p.LA * math.sin(crank_angle)

        def excess(place: float) -> float:
            """How far the loop is open (m) with the slider at a place: the projected shape closes it a little off the given place."""
            state.s[0] = place
            self.can_move(y)
            return abs(f.foot) - math.hypot(v1, v2)

        low, high = p.tables.low, p.tables.high
        state.s[0] = scipy.optimize.brentq(excess, low, high, xtol=1e-15 * p.L) if excess(low) <= 0.0 <= excess(high) else math.nan
        if not self.closes_loop:
            self.can_move(y)
            state.q[-1], state.u[-1] = state.q[-1] - math.atan2(f.foot.imag, f.foot.real), 0.0
            self.can_move(y)
            state.u[-1] = -f.gap_rate / self.workspace.row_of_gap[-1]
        return y

    def can_move(self, y: Array) -> bool:
        """Whether the loop closes and the accelerations exist in the state `y`."""
        p, w = self._at
        y, rate = np.ascontiguousarray(y, dtype=float), np.empty(len(y))
        return KERNEL(p.address, w.address, y.ctypes.data, rate.ctypes.data) == 1

    @property
    def equations(self) -> Equations:
        """The equations of motion as the integrator takes them."""
        p, w = self._at
        return Equations(KERNEL.address, p.address, w.address, self.workspace.watched)

    def error_scales(self, crank_speed: float) -> Array:
        """Size of each controlled state, to which the relative tolerance refers: fixed, so that none vanishes (equation 5.10).

        An amplitude has the scene's deflection, the follower's angle 0.01 rad, the crank 0.1 rad, the slider 1 % of the follower's length.
        The rate of an amplitude or of the follower's angle has that size times a characteristic frequency, the crank's speed a tenth.
        """
        p, frequency = self.parameters, characteristic_frequency(self.scene, self.parameters.n)
        base = [] if self.closes_loop or p.constraint == BASE else [0.01]
        # with a rigid follower the crank's angle gives the slider's place, so that this state needs no tight control
        at_rest = [0.1, *[self._size] * p.n, *base, 0.01 * p.L if p.n or base else p.L]
        rates = [crank_speed_scale(self.scene, crank_speed), *[self._size * frequency] * p.n, *[0.01 * frequency] * len(base)]
        return np.array(at_rest + rates)

    @property
    def linearisation(self) -> Linearisation:
        """The linearised equations as the implicit integrator takes them."""
        p = self.parameters
        return Linearisation(LINEARISED.address, WEIGHED.address, p.speeds, p.speeds + 1, p.unknowns)

    def integrate(self, y: Array, output_step: float, intervals: int, tolerance: float, first_step: float = 0.0) -> Integration:
        """States on a uniform grid from the state `y`; see `reference_model.integrate.dop853` and `radau`.

        Where the loop of a far bent follower loses its determinant (equation 3.4) and gets it back, the motion is smooth and the mass
        matrix is not. There Radau's steps shrink without end; DOP853's pass, and complete the integration (RADAU.md, section 7).
        """
        scales = self.error_scales(float(State.of(y).u[0])) * tolerance
        p = self.parameters
        how = output_step, intervals, scales, p.reach, pace(self.scene, p.n), first_step
        if not self.implicit:
            return dop853(self.equations, y, *how)
        found = radau(self.equations, self.linearisation, y, *how)
        if found.status != STEP_TOO_SMALL:
            return found
        rows = len(found.states) - 1
        rest = dop853(self.equations, found.states[-1], output_step, intervals - rows, *how[2:5])
        states, ended = np.concatenate([found.states[:-1], rest.states]), rows * output_step + rest.end_time
        return Integration(states, rest.status, ended, found.calls + rest.calls, rest.next_step)

    def observe(self, states: Array) -> dict[str, Array]:
        """Observables of states (k, size), each of shape (k,), by the names in `reference_model.columns`; see `recorded_columns`.

        Raises:
            ObservationFailed: the loop does not close in a state.
        """
        states, table = np.ascontiguousarray(states, dtype=float), np.empty((NUMBERS, len(states)))
        scratch = np.empty(states.shape[1] + NUMBERS)
        arrays = states.ctypes.data, *states.shape, scratch.ctypes.data, table.ctypes.data
        filled = OBSERVATIONS(KERNEL.address, self._at[0].address, self._at[1].address, *arrays)
        if filled < len(states):
            raise ObservationFailed(filled)
        alone = self.parameters.constraint == BASE
        joint, spring = not (alone or self.closes_loop), self.scene.acting_spring is not None
        return recorded_columns(table, alone=alone, joint=joint, spring=spring)

    def deflection(self, y: Array) -> "tuple[scipy.interpolate.CubicHermiteSpline, scipy.interpolate.CubicHermiteSpline]":
        """Deflection W(x) (m) and its rate (m/s) in the state `y`, as functions of arc length with derivatives."""
        state, L = State.of(y), self.parameters.L
        s = state.s[0]
        x = np.unique(np.concatenate([np.linspace(0.0, s, 121), np.linspace(s, L, 121)]))
        self.can_move(y)
        psi, psi_s = self._shapes(s, x)
        angle = psi @ state.eta
        rate = psi @ state.eta_rate + psi_s @ state.eta * self.workspace.facts.s_rate
        slope, slope_rate = np.sin(angle), np.cos(angle) * rate
        # cubic through the slopes, integrated: exact to the fourth power of the spacing
        place = scipy.interpolate.CubicHermiteSpline(x, slope, np.gradient(slope, x)).antiderivative()(x)
        speed = scipy.interpolate.CubicHermiteSpline(x, slope_rate, np.gradient(slope_rate, x)).antiderivative()(x)
        return scipy.interpolate.CubicHermiteSpline(x, place, slope), scipy.interpolate.CubicHermiteSpline(x, speed, slope_rate)

    def natural_frequencies(self, crank_angle: float, count: int) -> Array:
        """Lowest natural frequencies (Hz) with the crank held, the follower straight, at rest and undamped (open loop: equation 7.1).

        A constraint that does work makes the equations unsymmetric: of complex roots these are the moduli.
        """
        squares = np.sort(np.abs(self._frozen_squares(crank_angle)))
        return np.asarray(np.sqrt(squares[:count]) / (2.0 * np.pi), dtype=np.float64)

    def mass_matrix(self) -> Array:
        """Mass matrix of the state evaluated last, shape (free speeds, free speeds)."""
        lower = self.workspace.M[self.parameters.first :, self.parameters.first :]
        return np.tril(lower) + np.tril(lower, -1).T

    def _frozen_squares(self, crank_angle: float) -> NDArray[np.complex128]:
        """Squares of the angular frequencies with the crank held, rad^2/s^2."""
        p, w = self.parameters, self.workspace
        # the mass matrix, the gap's row and the force's spread are computed before the force can fail
        self.can_move(self.straight_state(crank_angle, 0.0))
        mass = self.mass_matrix()[1 - p.first :, 1 - p.first :]
        stiffness = np.zeros_like(mass)
        stiffness[: p.n, : p.n] = np.diag(w.squares)
        if p.is_held:
            points = p.tables.points
            across = w.V[1:, points : 2 * points] @ w.at_spring
            assert self.scene.crank is not None
            stiffness += stiffness_across(self.scene, crank_angle) * np.outer(across, across)
        if not self.closes_loop:
            row, spread = w.row_of_gap[1:], w.spread[1:]
            if p.constraint == ROLLERS:
                closed = p.plus + p.minus if p.plus_from < 0.0 else p.plus  # as `Slider.closed_stiffness` has it
                stiffness += closed * np.outer(row, row)
            else:
                free, test = scipy.linalg.null_space(row[None, :]), scipy.linalg.null_space(spread[None, :])
                mass, stiffness = test.T @ mass @ free, test.T @ stiffness @ free
        # M v = v / omega^2 K v, not the other way round: round-off is relative to the largest eigenvalue
        return np.asarray(1.0 / scipy.linalg.eig(mass, stiffness, right=False), dtype=np.complex128)


def _unmoved(angles: Callable[[Array], Array], s: float, x: Array) -> tuple[Array, Array]:
    """`Angles` of shapes that do not move with the slider."""
    psi = angles(x)
    return psi, np.zeros_like(psi)
