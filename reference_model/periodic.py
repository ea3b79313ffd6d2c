"""The periodic steady state without waiting for it, and its Floquet multipliers.

A steady state is a fixed point of the cycle's map (equation 10.2). Newton's method finds it where marching only creeps towards it.
What makes it cheap: few quantities are slow. The modes beyond the first ones forget a disturbance within a cycle, so that Newton's
step is needed for the crank's speed and the first modes alone, while the map itself carries the rest (Newton-Picard method: K.
Lust, D. Roose, A. Spence, A. R. Champneys, SIAM Journal on Scientific Computing 19, 1998, 1188). And the map's derivatives for
these come from the model that has these modes alone, whose cycles cost a fraction; its steady state is the guess for the whole
model.
"""

import math
from dataclasses import dataclass
from typing import Final, Self

import numpy as np
from numpy.typing import NDArray

from quickreturn.reference_model.model import BeamModel
from quickreturn.reference_model.poincare import CycleBroken, Passage, PoincareMap

Array = NDArray[np.float64]

#: Modes whose memory of a disturbance outlasts a cycle; of the others at most a twentieth is left in the thesis' runs.
SLOW_MODES: Final = 2
#: Cycles made first, and so many where a search failed: they carry a start that is far from any steady state to where Newton's method
#: converges.
MARCHED: Final = 2
PATIENT: Final = 50
#: Distance to which the model of the slow modes is solved, and tolerance of its integration: the model itself is off by as much.
GUESS: Final = 1e-3
GUESS_INTEGRATION: Final = 1e-5
#: Disturbance from which the map's derivatives are taken, relative to the states' sizes along the cycle ...
DISTURBANCE: Final = 1e-3
#: ... and at least this number of local errors of the integration.
LEAST_DISTURBANCE: Final = 1e3
#: Distance over which derivatives may be carried before they are taken anew for the multipliers and the whole model.
CARRIED: Final = 0.03
#: Largest modulus of a multiplier from which on the whole model's own derivatives must decide on stability.
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
        cycles: cycles made of the model of the slow modes, and of the whole model.
        cycles_of_work: evaluations of the equations in all of these, over those in a cycle of the whole model.
        residual: distance from the fixed point before the last Newton step, relative to the states' sizes along the cycle: more
            than what is left after it.
    """

    state: Array
    period: float
    multipliers: NDArray[np.complex128]
    stable: bool
    iterations: int
    cycles: tuple[int, int]
    cycles_of_work: float
    residual: float


def periodic_orbit(
    model: BeamModel, guess: Array, tolerance: float = 1e-6, integration: float = 1e-9, marched: int = MARCHED
) -> PeriodicOrbit:
    """The periodic steady state of a scene.

    Args:
        model: the scene, with shapes that follow the slider.
        guess: state vector (2 n + 5,) from which the search begins, anywhere in a cycle, in either direction of rotation.
        tolerance: distance from the fixed point relative to the states' sizes along the cycle. Mild motions are small beside the
            fixed sizes that the integration's tolerance refers to: to reach 1e-6 in all, that must be 1e-9.
        integration: tolerance of the integration.
        marched: cycles made first, of the slow modes alone.

    Raises:
        NoPeriodicOrbit: not converged.
    """
    try:
        return _search(PoincareMap(model, integration), guess, tolerance, marched)
    except CycleBroken as broken:
        raise NoPeriodicOrbit(str(broken)) from broken


def _search(whole: PoincareMap, guess: Array, tolerance: float, marched: int) -> PeriodicOrbit:
    slow = PoincareMap(whole.model.with_fewer_shapes(min(SLOW_MODES, whole.parameters.n)), max(whole.tolerance, GUESS_INTEGRATION))
    coarse = _newton(_marched(slow, _with_modes(guess, slow.parameters.n), marched), None, GUESS)
    jacobian = coarse.jacobian
    if coarse.carried > CARRIED:
        jacobian = _jacobian(_Cycle.of(slow, coarse.state, coarse.period))
    guessed = _with_modes(coarse.state, whole.parameters.n)
    first = _Cycle.of(whole, whole.state(whole.point(guessed), guessed), coarse.period)
    fine = _newton(first, _among_all_modes(jacobian, slow, whole), tolerance)
    multipliers = eigenvalues(fine.jacobian)[: len(jacobian)]
    if abs(multipliers[0]) > NEARLY_ONE:
        multipliers = eigenvalues(_jacobian(_Cycle.of(whole, fine.state, fine.period)))
    return PeriodicOrbit(
        state=fine.state,
        period=fine.period,
        multipliers=multipliers,
        stable=bool(np.abs(multipliers[0]) < 1.0),
        iterations=coarse.steps + fine.steps,
        cycles=(slow.cycles, whole.cycles),
        cycles_of_work=(slow.calls + whole.calls) * whole.cycles / whole.calls,
        residual=fine.distance,
    )


def floquet_multipliers(model: BeamModel, orbit: PeriodicOrbit, integration: float = 1e-9) -> NDArray[np.complex128]:
    """All 2 n + 1 multipliers (2 n with prescribed speed) of the whole model, largest modulus first; takes as many cycles more.

    Raises:
        NoPeriodicOrbit: the state is not one of a cycle.
    """
    try:
        return eigenvalues(_jacobian(_Cycle.of(PoincareMap(model, integration), orbit.state, orbit.period)))
    except CycleBroken as broken:
        raise NoPeriodicOrbit(str(broken)) from broken


def instability(multipliers: NDArray[np.complex128]) -> str:
    """How a periodic motion loses its stability, by its largest multiplier: "" while it is stable.

    A real multiplier leaves the unit circle at 1 (fold: two orbits meet) or at -1 (period doubling: the motion repeats after two turns),
    a complex pair anywhere else (torus: a second frequency appears). Y. A. Kuznetsov, Elements of Applied Bifurcation Theory, chapter 4.
    """
    largest = complex(multipliers[0])
    if abs(largest) < 1.0:
        return ""
    if largest.imag != 0.0:
        return "torus"
    return "fold" if largest.real > 0.0 else "period doubling"


@dataclass(frozen=True)
class _Cycle:
    """A cycle from a state at the farthest place; `residual` is what it changes of the free quantities."""

    map: PoincareMap
    state: Array
    passage: Passage

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
    """A fixed point: where its cycle begins, how long it lasts, the Jacobian last taken, and how far away that and the last step began."""

    state: Array
    period: float
    jacobian: Array
    carried: float
    distance: float
    steps: int


def _marched(slow: PoincareMap, guess: Array, cycles: int) -> _Cycle:
    """A cycle that is not far from the steady state."""
    speed = guess[slow.parameters.n + 2]
    if speed == 0.0:
        raise CycleBroken("the crank stands still in the given state")
    duration = slow.time_to_go(guess)
    state = guess
    for _ in range(cycles):
        passage = slow.passage(state, duration)
        state, duration = passage.state, 2.0 * math.pi / abs(float(passage.state[slow.parameters.n + 2]))
    return _Cycle.of(slow, state, duration)


def _newton(cycle: _Cycle, jacobian: Array | None, tolerance: float) -> _FixedPoint:
    """Simplified Newton steps (equation 10.4), damped where they do not help.

    P. Deuflhard, Newton Methods for Nonlinear Problems, 2004, section 3.3.

    Args:
        cycle: where to begin.
        jacobian: derivatives of the map near there; None: taken there.
        tolerance: distance at which the last step is made.
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
            return _FixedPoint(state, cycle.passage.duration, jacobian, carried, distance, steps)
        try:
            there = cycle.moved_to(cycle.point + part * step)
            left = _relative(inverse @ there.residual, cycle)
        except CycleBroken:
            left = math.inf
        if left < distance:
            cycle, part, fresh = there, min(1.0, 2.0 * part), False
            steps_to_go = math.log(max(left / tolerance, 1.0)) / math.log(distance / left)
            if steps_to_go > len(step):  # taking the derivatives anew costs as many cycles
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
    here, there = cycle.point, cycle.map.point(cycle.passage.state)
    disturbances = np.maximum(DISTURBANCE * cycle.passage.sizes, LEAST_DISTURBANCE * cycle.map.noise(cycle.state))
    columns = []
    for i, disturbance in enumerate(disturbances):
        moved = here.copy()
        moved[i] += disturbance
        columns.append((cycle.map.point(cycle.moved_to(moved).passage.state) - there) / disturbance)
    return np.column_stack(columns)


def eigenvalues(jacobian: Array) -> NDArray[np.complex128]:
    """Of the map's Jacobian, the Floquet multipliers (equation 10.7); largest modulus first."""
    found = np.linalg.eigvals(jacobian).astype(np.complex128)
    return found[np.argsort(-np.abs(found), kind="stable")]


def _relative(difference: Array, cycle: _Cycle) -> float:
    size = float(np.max(np.abs(difference) / cycle.passage.sizes))
    return size if math.isfinite(size) else math.inf


def _with_modes(state: Array, modes: int) -> Array:
    """A state of a model with another number of modes: cut, or filled with zeros."""
    n = (len(state) - 5) // 2
    kept = min(n, modes)
    other = np.zeros(2 * modes + 5)
    other[0], other[modes + 1 : modes + 3], other[-2:] = state[0], state[n + 1 : n + 3], state[-2:]
    other[1 : kept + 1], other[modes + 3 : modes + 3 + kept] = state[1 : kept + 1], state[n + 3 : n + 3 + kept]
    return other


def _among_all_modes(jacobian: Array, slow: PoincareMap, whole: PoincareMap) -> Array:
    """The slow quantities' derivatives among all: what the other modes were a cycle ago is forgotten (equation 10.6)."""
    n = whole.parameters.n
    numbered = _with_modes(np.arange(1.0, 2 * slow.parameters.n + 6), n)
    is_slow = whole.point(numbered) > 0.0
    wide = np.zeros((len(is_slow), len(is_slow)))
    wide[np.ix_(is_slow, is_slow)] = jacobian
    return wide
