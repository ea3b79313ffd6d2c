"""The start of marching: the periodic steady state that `reference` finds directly, once for each scene.

The other engines' steady states differ from it by about their own errors, so they need 4 to 9 cycles from there in the thesis' runs, but 20
to 29 from the standard start. It also shows beforehand whether marching can settle at all: the largest Floquet multiplier is the part of a
disturbance that remains after a cycle.
"""

import contextlib
import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final, cast

import numpy as np
from scipy.interpolate import PPoly

from quickreturn.cases.motion.endings import Ending
from quickreturn.cases.motion.marching import output_step
from quickreturn.cases.motion.settling import GREATEST_NUMBER, TOLERANCE
from quickreturn.cases.motion.stability import Multiplier, multiplier_of, nearly_one
from quickreturn.cases.running.job import Job
from quickreturn.cases.running.workshop import Workshop
from quickreturn.engines import progress
from quickreturn.engines.base import AnyEngine, Comparison, EngineFailure, NoSteadyState, Refusal, SteadyState
from quickreturn.engines.error_parts import Compared, compared
from quickreturn.engines.one_run import Remembered
from quickreturn.engines.own.reference import ReferenceEngine, ReferenceSettings
from quickreturn.engines.settings import Settings
from quickreturn.engines.start import Start, standard_start
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.mechanism import Mechanism

if TYPE_CHECKING:
    from quickreturn.engines.own.simulation import FoundOrbit

#: Relative error of an engine in a few cycles that is assumed if it has no estimate.
UNKNOWN_ERROR: Final = 1e-2


@dataclass(frozen=True, eq=False)
class Curve:
    """A piecewise polynomial of arc length; unlike scipy's it is compared by its content, to the last bit."""

    x: Array  # ends of the pieces, m, shape (n + 1,)
    c: Array  # coefficients of each piece, highest power first, shape (4, n)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Curve) and self._bytes == other._bytes

    def __hash__(self) -> int:
        return hash(self._bytes)

    @property
    def _bytes(self) -> tuple[bytes, bytes]:
        return self.x.tobytes(), self.c.tobytes()

    def __call__(self, x: Array, nu: int = 0, /) -> Array:
        """Values of the `nu`-th derivative at `x` (m)."""
        return np.asarray(PPoly(self.c, self.x)(x, nu))


@dataclass(frozen=True)
class PeriodicStart(Start):
    """A start that can be stored and is compared by its content."""

    deflection: Curve
    deflection_rate: Curve

    @classmethod
    def of(cls, start: Start) -> "PeriodicStart":
        """The same start; its fields are piecewise polynomials."""
        curves = []
        for field in (start.deflection, start.deflection_rate):
            assert isinstance(field, (PPoly, Curve))
            curves.append(Curve(field.x, field.c))
        return cls(start.crank_angle, start.crank_speed, *curves)


@dataclass(frozen=True)
class Orbit:
    """The result of the search for the periodic steady state of a scene by `reference`."""

    begin: PeriodicStart | None  # the periodic steady state at the slider's farthest place; None if there is none to begin in
    multiplier: float | None  # largest modulus of its Floquet multipliers; None if no periodic state was found
    reason: str = ""  # why there is none to begin in (a clause), "" if there is
    neutral: bool = False  # whether that multiplier is 1 within its error
    period: float = 0.0  # s; 0 if there is none to begin in

    def hopeless(self, error: float) -> str:
        """Why an engine that marches from here cannot settle (a sentence); "" if it can.

        Args:
            error: the engine's estimated error in a few cycles, relative to the signals. Each cycle adds it and the error of `reference` to
                the distance of the two steady states, and the part `multiplier` of it remains: error / (1 - multiplier) in all.
        """
        error += ReferenceEngine.default_accuracy
        if self.multiplier is None:
            return ""
        if self.neutral:
            why = "no number of cycles suffices, because a disturbance neither grows nor dies away"
        elif self.multiplier >= 1.0:
            why = f"no number of cycles suffices, because a disturbance grows {self.multiplier:.3f}-fold in a cycle"
        elif cycles_needed(self.multiplier, error) > GREATEST_NUMBER:
            why = f"{GREATEST_NUMBER} cycles do not suffice, because {self.multiplier:.3f} of a disturbance remains after a cycle"
        else:
            return ""
        instead = "another speed" if self.multiplier >= 1.0 and not self.neutral else "the engine `reference`, which need not march"
        source = "(largest Floquet multiplier of the periodic state that `reference` found)"
        return f"not marched: {why} {source}; try more damping, or {instead}"


def cycles_needed(multiplier: float, error: float) -> float:
    """Cycles after which an engine that errs by `error` in a few cycles has settled, beginning in another's periodic state."""
    distance = error / (1.0 - multiplier)
    if distance <= TOLERANCE:
        return 0.0
    return math.log(distance / TOLERANCE) / -math.log(multiplier) if multiplier > 0.0 else 1.0


def begins_in_orbit(engine: AnyEngine) -> bool:
    """Whether an engine shall begin in the orbit of `reference`; not if it cannot, or solves other equations, which have another orbit."""
    return engine.begins_bent and engine.estimates != "integration"


def find_orbit(mechanism: Mechanism) -> Orbit:
    """Search the periodic state from the standard start, with the settings of `reference` for its default accuracy."""
    reference, start = ReferenceEngine(), standard_start(mechanism)
    progress.tell(engine=reference.name, phase="searching the periodic state")
    try:
        reference.check(mechanism)
        settings = reference.settings_for(reference.default_accuracy, mechanism)
        state = reference.steady_state(mechanism, start, settings)
        multiplier = None if state is None else stability_of(mechanism, state, settings)
    except (Refusal, NoSteadyState, EngineFailure) as reason:
        return Orbit(None, None, str(reason))
    if state is None or multiplier is None:
        return Orbit(None, None, "the search excludes a rigid follower, and a joint that is compliant or rubs")
    return orbit_of(state, multiplier)


def orbit_of(state: "FoundOrbit", multiplier: Multiplier) -> Orbit:
    """The orbit of a periodic state that was found; there is none to begin in if disturbances do not die away."""
    size, status = abs(multiplier.value), multiplier.status
    if status != Ending.SETTLED:
        why = f"the periodic state is {'neutral' if status == Ending.NEUTRAL else 'not stable'}"
        return Orbit(None, size, why, neutral=status == Ending.NEUTRAL)
    return Orbit(PeriodicStart.of(state.start), size, period=state.period)


def stability_of(mechanism: Mechanism, state: "FoundOrbit", settings: ReferenceSettings) -> Multiplier:
    """The largest multiplier of a periodic state, with its error where the stability depends on that. Raises NoSteadyState."""
    if not nearly_one(state):
        return multiplier_of(state)
    return multiplier_of(state, compared_orbits(mechanism, state, settings))


def compared_orbits(
    mechanism: Mechanism, state: "FoundOrbit", settings: ReferenceSettings, found: Callable[[Settings], SteadyState | None] | None = None
) -> "list[Compared[FoundOrbit]]":
    """A periodic state beside those of the models with which `reference` compares it for its error estimate.

    Args:
        mechanism: the scene.
        state: its periodic state with `settings`.
        settings: settings of `reference`.
        found: finds the periodic state with other settings; None: it is searched from `state`.

    Raises:
        NoSteadyState: with other settings there is no periodic state.
    """

    def of(other: Settings) -> "FoundOrbit":
        assert isinstance(other, ReferenceSettings)
        there = periodic_state(mechanism, other, state) if found is None else found(other)
        return cast("FoundOrbit", there)

    known = Remembered(of, {settings: state})
    pairs = settled_pairs(ReferenceEngine(), settings, mechanism)
    return [compared(pair, settings, known) for pair in pairs if pair.run != pair.other]


def settled_pairs(engine: AnyEngine, settings: Settings, mechanism: Mechanism) -> tuple[Comparison, ...]:
    """The runs with which an engine compares a settled cycle.

    A run with still more modes only shows whether their error falls after an impact: a settled cycle does not follow one.
    """
    pairs = engine.comparisons(settings, mechanism, output_step(mechanism))
    return tuple(replace(pair, before=None) if pair.of == "modes" else pair for pair in pairs)


def periodic_state(scene: Mechanism, settings: ReferenceSettings, near: "FoundOrbit | None") -> "FoundOrbit | None":
    """The periodic state that `reference` finds from a neighbour's, or from the standard start; None if it does not search.

    Raises:
        NoSteadyState: it found none.
    """
    reference, start = ReferenceEngine(), standard_start(scene)
    if near is not None:
        with contextlib.suppress(NoSteadyState):
            return reference.steady_state(scene, start, settings, near)
    return reference.steady_state(scene, start, settings)


def orbits(mechanisms: Iterable[Mechanism], workshop: Workshop) -> list[Orbit]:
    """The orbits of several scenes, taken from the store or searched in a process of its own each.

    Raises:
        KeyboardInterrupt: Ctrl-C; what was computed is stored.
    """
    jobs = [Job("periodic state", find_orbit, (scene,), kind="periodic state") for scene in mechanisms]
    outcomes = workshop.outcomes(jobs, "periodic states") if jobs else []
    return [outcome.value or Orbit(None, None, f"the search {outcome.explanation}") for outcome in outcomes]
