"""Finds the periodic steady state without simulating its approach, and the Floquet multipliers.

A steady state is a fixed point of the cycle's map (equation 10.2). Newton's method finds it where a simulation approaches it slowly. It is
cheap because few quantities are slow: the crank's speed and the first modes. The other modes forget a disturbance within a cycle, so that
the map itself corrects them, and Newton's step is needed for the slow quantities alone (Newton-Picard method: K. Lust, D. Roose, A. Spence,
A. R. Champneys, SIAM Journal on Scientific Computing 19, 1998, 1188). The derivatives of the map by the slow quantities come from a model
with the slow modes alone, whose cycles cost a fraction; its steady state is the guess for the whole model.
"""

import math
from dataclasses import dataclass
from typing import Final, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.cycles.poincare import CycleBroken, Passage, PoincareMap
from quickreturn.reference_model.model import BeamModel
from quickreturn.reference_model.state import State

#: Number of slow modes. A disturbance of any other mode shrinks to a twentieth or less within a cycle of the thesis' runs.
SLOW_MODES: Final = 2
#: Cycles simulated before the search, which bring a start far from any steady state near enough for Newton's method; and their number where
#: that was too few.
MARCHED: Final = 2
PATIENT: Final = 50
#: Accuracy to which the model of the slow modes is solved. At 60 speeds of run 24's machine the whole model then takes 2.4 cycles to 1e-3;
#: 2.3 if the slow one is solved to 1e-3, too.
GUESS: Final = 1e-2
#: Tolerance of its integration.
GUESS_INTEGRATION: Final = 1e-5
#: Disturbance from which the map's derivatives are taken, relative to the states' sizes along the cycle ...
DISTURBANCE: Final = 1e-3
#: ... and at least this many times the local error of the integration.
LEAST_DISTURBANCE: Final = 1e3
#: Distance of the fixed point from where the derivatives were taken above which the multipliers and the whole model need new ones.
CARRIED: Final = 0.03
#: Largest modulus of a multiplier above which the whole model's own derivatives must decide on stability.
NEARLY_ONE: Final = 0.95
SMALLEST_PART: Final = 1.0 / 16.0  # of a Newton step that is tried
MOST_STEPS: Final = 25
MOST_JACOBIANS: Final = 6


class NoPeriodicOrbit(Exception):
    """The search did not converge; the text is a clause that says why."""


@dataclass(frozen=True)
class PeriodicOrbit:
    """A periodic steady state.

    Attributes:
        state: state vector at the slider's farthest place, shape (2 n + 5,), energies zero.
        period: s, of the last cycle made: off by less than the residual.
        multipliers: eigenvalues of the map's Jacobian, largest modulus first: of crank speed and slow modes; of all quantities of
            the whole model where one of them comes close to the unit circle.
        stable: whether all of them lie within the unit circle.
        iterations: Newton steps, of both models.
        cycles: numbers of cycles simulated with the model of the slow modes, and with the whole model.
        cycles_of_work: evaluations of the equations in all these cycles, over those in one cycle of the whole model.
        residual: distance from the fixed point before the last Newton step, relative to the states' sizes along the cycle: an upper
            bound of the remaining error.
        slow_jacobian: derivatives of the map by crank speed and slow modes, of the model with these modes alone.
    """

    state: Array
    period: float
    multipliers: NDArray[np.complex128]
    stable: bool
    iterations: int
    cycles: tuple[int, int]
    cycles_of_work: float
    residual: float
    slow_jacobian: Array


def periodic_orbit(model: BeamModel, guess: Array | PeriodicOrbit, tolerance: float = 1e-6, integration: float = 1e-9) -> PeriodicOrbit:
    """The periodic steady state of a scene.

    Args:
        model: the scene, with shapes that follow the slider.
        guess: where the search begins: a state vector (2 n + 5,), anywhere in a cycle, in either direction of rotation; or the orbit of the
            same scene by another model, so that the slow modes' own model is not needed.
        tolerance: distance from the fixed point relative to the states' sizes along the cycle. Mild motions are small beside the
            fixed sizes that the integration's tolerance refers to: to reach 1e-6 in all, that must be 1e-9.
        integration: tolerance of the integration.

    Raises:
        NoPeriodicOrbit: not converged.
    """
    try:
        return _search(PoincareMap(model, integration), guess, tolerance)
    except CycleBroken as broken:
        raise NoPeriodicOrbit(str(broken)) from broken


def _search(whole: PoincareMap, guess: Array | PeriodicOrbit, tolerance: float) -> PeriodicOrbit:
    """As `periodic_orbit`, from the map of the whole model. Raises CycleBroken, NoPeriodicOrbit."""
    is_slow = whole.belongs_to(min(SLOW_MODES, whole.parameters.n))
    if isinstance(guess, PeriodicOrbit) and len(guess.slow_jacobian) == is_slow.sum():
        begin = _Begin(guess.state, guess.period, guess.slow_jacobian)
    else:
        begin = _by_slow_modes(whole, guess.state if isinstance(guess, PeriodicOrbit) else guess)
    jacobian = np.zeros((len(is_slow), len(is_slow)))  # the other modes forget their state within a cycle (equation 10.6)
    jacobian[np.ix_(is_slow, is_slow)] = begin.jacobian
    guessed = _with_modes(begin.state, whole.parameters.n)
    fine = _newton(_Cycle.of(whole, whole.state(whole.point(guessed), guessed), begin.period), jacobian, tolerance)
    multipliers = eigenvalues(fine.jacobian)[: len(begin.jacobian)]
    if abs(multipliers[0]) > NEARLY_ONE:
        multipliers = eigenvalues(_central_jacobian(fine.cycle))
    return PeriodicOrbit(
        state=fine.state,
        period=fine.cycle.passage.duration,
        multipliers=multipliers,
        stable=bool(np.abs(multipliers[0]) < 1.0),
        iterations=begin.steps + fine.steps,
        cycles=(begin.cycles, whole.cycles),
        cycles_of_work=(begin.calls + whole.calls) * whole.cycles / whole.calls,
        residual=fine.distance,
        slow_jacobian=begin.jacobian,
    )


class _Begin(NamedTuple):
    """Where the search with the whole model begins."""

    state: Array  # with any number of modes
    period: float  # s
    jacobian: Array  # by the slow quantities
    steps: int = 0  # Newton steps that led there
    cycles: int = 0  # cycles that these took
    calls: int = 0  # right-hand sides evaluated in them


def _by_slow_modes(whole: PoincareMap, guess: Array) -> _Begin:
    """The fixed point of the slow modes' model. Raises CycleBroken, NoPeriodicOrbit."""
    slow = PoincareMap(whole.model.with_fewer_shapes(min(SLOW_MODES, whole.parameters.n)), max(whole.tolerance, GUESS_INTEGRATION))
    state = _with_modes(guess, slow.parameters.n)
    try:
        found = _newton(_marched(slow, state, MARCHED), None, GUESS)
    except (CycleBroken, NoPeriodicOrbit) as failure:
        try:
            found = _newton(_marched(slow, state, PATIENT), None, GUESS)
        except (CycleBroken, NoPeriodicOrbit):
            raise failure from None
    jacobian = _jacobian(found.cycle) if found.carried > CARRIED else found.jacobian
    return _Begin(found.state, found.cycle.passage.duration, jacobian, found.steps, slow.cycles, slow.calls)


def largest_multiplier(model: BeamModel, orbit: PeriodicOrbit, integration: float = 1e-9) -> complex:
    """The largest multiplier of the slow quantities, by derivatives of the whole model along their eigenvector (equation 10.14).

    The derivatives are central differences, so that the eigenvector's arbitrary sign does not matter. They take two cycles, or four if the
    multiplier is not real, besides the cycle from which the disturbance is sized.

    Raises:
        NoPeriodicOrbit: the state is not one of a cycle.
    """
    whole = PoincareMap(model, integration)
    is_slow = whole.belongs_to(min(SLOW_MODES, whole.parameters.n))
    multipliers, vectors = np.linalg.eig(orbit.slow_jacobian)
    largest = int(np.argmax(np.abs(multipliers)))
    right, left = vectors[:, largest], np.linalg.inv(vectors)[largest]
    try:
        cycle = _Cycle.of(whole, orbit.state, orbit.period)
        moved = np.zeros(len(right), dtype=np.complex128)
        for unit, part in ((1.0, right.real), (1.0j, right.imag)):
            if part.any():
                direction = np.zeros(len(is_slow))
                direction[is_slow] = part
                disturbance = 1.0 / float(np.max(np.abs(direction) / _disturbances(cycle)))
                moved += unit * _central_derivative(cycle, direction, disturbance)[is_slow]
    except CycleBroken as broken:
        raise NoPeriodicOrbit(str(broken)) from broken
    multiplier = complex(left @ moved)
    return multiplier if multipliers[largest].imag != 0.0 else complex(multiplier.real)


def instability(multipliers: NDArray[np.complex128]) -> str:
    """How a periodic motion loses its stability, by its largest multiplier: "" while it is stable.

    A real multiplier leaves the unit circle at 1 (fold: two orbits meet) or at -1 (period doubling: the motion repeats after two turns),
    a complex pair anywhere else (torus: a second frequency appears). Y. A. Kuznetsov, Elements of Applied Bifurcation Theory, chapter 4.
    """
    largest = complex(multipliers[0])
    return "" if abs(largest) < 1.0 else instability_of(largest)


def instability_of(multiplier: complex) -> str:
    """How a motion loses its stability where this multiplier leaves the unit circle."""
    if multiplier.imag != 0.0:
        return "torus"
    return "fold" if multiplier.real > 0.0 else "period doubling"


@dataclass(frozen=True)
class _Cycle:
    """A cycle with the slider at its farthest place at begin and end; `residual` is the change of the free quantities over it."""

    map: PoincareMap
    state: Array  # at the begin
    passage: Passage  # its end

    @classmethod
    def of(cls, cycle_map: PoincareMap, state: Array, duration: float, step: float = 0.0) -> Self:
        """Make the cycle; it takes about `duration` (s)."""
        return cls(cycle_map, state, cycle_map.passage(state, duration, step))

    @property
    def point(self) -> Array:
        return self.map.point(self.state)

    @property
    def residual(self) -> Array:
        return self.map.point(self.passage.state) - self.point

    def moved_to(self, point: Array) -> Self:
        """The cycle from other free quantities."""
        return self.of(self.map, self.map.state(point, self.state), self.passage.duration, self.passage.step)


@dataclass(frozen=True)
class _FixedPoint:
    """A fixed point."""

    state: Array  # state vector with the slider at its farthest place
    cycle: _Cycle  # the last one made: a step away
    jacobian: Array  # of the map, as taken last
    carried: float  # distance of the state where the Jacobian was taken; nan for a Jacobian that was given
    distance: float  # length of the last step, relative to the states' sizes along the cycle
    steps: int  # number of steps


def _marched(slow: PoincareMap, guess: Array, cycles: int) -> _Cycle:
    """The cycle that follows `cycles` cycles from a state anywhere in a turn. Raises CycleBroken."""
    if State.of(guess).u[0] == 0.0:
        raise CycleBroken("the crank stands still in the given state")
    duration = slow.time_to_go(guess)
    state = guess
    for _ in range(cycles):
        passage = slow.passage(state, duration)
        state, duration = passage.state, 2.0 * math.pi / abs(float(State.of(passage.state).u[0]))
    return _Cycle.of(slow, state, duration)


def _newton(cycle: _Cycle, jacobian: Array | None, tolerance: float) -> _FixedPoint:
    """The fixed point by simplified Newton steps (equation 10.4), shortened where a full step does not help. Raises NoPeriodicOrbit.

    P. Deuflhard, Newton Methods for Nonlinear Problems, 2004, section 3.3.

    Args:
        cycle: where to begin.
        jacobian: derivatives of the map near there; None takes them there.
        tolerance: the last step is shorter than this.
    """
    taken, part, fresh, distance, carried = 0, 1.0, False, math.inf, math.nan
    for steps in range(1, MOST_STEPS + 1):
        if jacobian is None:
            if taken == MOST_JACOBIANS:
                break
            jacobian, fresh, taken = _jacobian(cycle), True, taken + 1
        inverse = np.linalg.inv(np.eye(len(jacobian)) - jacobian)
        step = inverse @ cycle.residual
        distance = _relative(step, cycle)
        carried = distance if fresh else carried
        if distance < tolerance:
            state = cycle.map.state(cycle.point + step, cycle.state)
            return _FixedPoint(state, cycle, jacobian, carried, distance, steps)
        try:
            there = cycle.moved_to(cycle.point + part * step)
            left = _relative(inverse @ there.residual, cycle)
        except CycleBroken:
            left = math.inf
        if left < distance:
            cycle, part, fresh = there, min(1.0, 2.0 * part), False
            steps_to_go = math.log(max(left / tolerance, 1.0)) / math.log(distance / left)
            if steps_to_go > len(step):  # new derivatives cost len(step) cycles
                jacobian = None
        elif not fresh:
            jacobian = None
        else:
            part *= 0.5
            if part < SMALLEST_PART:
                break
    raise NoPeriodicOrbit(f"the search for it ended at a distance of {distance:.2g} of the motion's size")


def _jacobian(cycle: _Cycle) -> Array:
    """Derivatives of the map by the free quantities, by finite differences from a cycle (equation 10.5)."""
    units = np.eye(len(cycle.point))
    return np.column_stack([_derivative(cycle, unit, size) for unit, size in zip(units, _disturbances(cycle), strict=True)])


def _central_jacobian(cycle: _Cycle) -> Array:
    """The same by central differences, whose error is of second order in the disturbance; they take twice as many cycles."""
    units = np.eye(len(cycle.point))
    return np.column_stack([_central_derivative(cycle, unit, size) for unit, size in zip(units, _disturbances(cycle), strict=True)])


def _central_derivative(cycle: _Cycle, direction: Array, disturbance: float) -> Array:
    """Derivative of the map along a direction, from cycles that begin `disturbance` times the direction away on either side."""
    return (_derivative(cycle, direction, disturbance) + _derivative(cycle, direction, -disturbance)) / 2.0


def _derivative(cycle: _Cycle, direction: Array, disturbance: float) -> Array:
    """Derivative of the map along a direction, from the cycle and one that begins `disturbance` times the direction away."""
    moved = cycle.moved_to(cycle.point + disturbance * direction)
    return (cycle.map.point(moved.passage.state) - cycle.map.point(cycle.passage.state)) / disturbance


def _disturbances(cycle: _Cycle) -> Array:
    """Disturbance of each free quantity for its difference quotient."""
    return np.maximum(DISTURBANCE * cycle.passage.sizes, LEAST_DISTURBANCE * cycle.map.noise(cycle.state))


def eigenvalues(jacobian: Array) -> NDArray[np.complex128]:
    """Eigenvalues of the map's Jacobian, the Floquet multipliers (equation 10.7); largest modulus first."""
    multipliers = np.linalg.eigvals(jacobian).astype(np.complex128)
    return multipliers[np.argsort(-np.abs(multipliers), kind="stable")]


def _relative(difference: Array, cycle: _Cycle) -> float:
    """Largest of the free quantities' differences, each relative to its size along the cycle; infinite where one is not a number."""
    size = float(np.max(np.abs(difference) / cycle.passage.sizes))
    return size if math.isfinite(size) else math.inf


def _with_modes(state: Array, modes: int) -> Array:
    """A state of a model with another number of modes: cut, or filled with zeros."""
    other = np.zeros(len(state) + 2 * (modes - len(State.of(state).eta)))
    for part, given in zip(State.of(other), State.of(state), strict=True):
        kept = min(len(part), len(given))
        part[:kept] = given[:kept]
    return other
