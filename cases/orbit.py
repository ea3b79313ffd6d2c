"""Where marching begins: the periodic steady state that `reference` finds directly, once for each scene.

The other engines' steady states lie about their own errors beside it, so that they need 4 to 9 cycles from there in the thesis' runs
where the standard start needs 20 to 29. It also says beforehand whether marching can settle at all: what is left of a disturbance
after a cycle is the largest Floquet multiplier.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PPoly

from cases.fingerprint import SIMULATION, code_fingerprint
from cases.measures.steady_state import GREATEST_NUMBER, TOLERANCE
from cases.store import Entry, Store, key_of
from cases.stored_jobs import stored
from cases.workers import Job, Limits
from engines.base import Engine, EngineFailure, NoSteadyState, Refusal
from engines.own.reference import ReferenceEngine
from engines.own.simulation import OwnSimulation
from engines.start import Start, standard_start
from reference_model.mechanism import Mechanism

Array = NDArray[np.float64]

#: What an engine errs by in a few cycles where it has no estimate.
UNKNOWN_ERROR: Final = 1e-2


@dataclass(frozen=True)
class Curve:
    """A piecewise polynomial of arc length; unlike scipy's it is told apart from others by its content.

    Attributes:
        x: ends of the pieces, m, shape (n + 1,).
        c: coefficients of each piece, highest power first, shape (4, n).
    """

    x: Array
    c: Array

    def __call__(self, x: Array, nu: int = 0, /) -> Array:
        """Values of the `nu`-th derivative at `x` (m)."""
        return np.asarray(PPoly(self.c, self.x)(x, nu))


@dataclass(frozen=True)
class Orbit:
    """What the search found.

    Attributes:
        start: the periodic steady state at the slider's farthest place; None where there is none to begin in.
        multiplier: largest modulus of its Floquet multipliers; None where no periodic state was found.
        reason: why there is none to begin in (a clause), "" if there is.
        period: s; 0 where there is none to begin in.
    """

    start: Start | None
    multiplier: float | None
    reason: str = ""
    period: float = 0.0

    def hopeless(self, error: float) -> str:
        """Why marching from here cannot settle (a sentence); "" if it can.

        Args:
            error: what the engine errs by in a few cycles, relative to the signals, by its estimate. With that
                of the reference it is what a cycle adds to the distance of the two steady states, and what earlier cycles added is
                carried on: error / (1 - multiplier) in all. In run 24 with less and less damping (multipliers 0.82, 0.86, 0.89) this
                tells 19, 29 and 38 cycles of mujoco, which took 15, 22 and 33.
        """
        error += ReferenceEngine.default_accuracy
        if self.multiplier is None:
            return ""
        if self.multiplier >= 1.0:
            return (
                f"not marched: no number of cycles will do, for a disturbance grows {self.multiplier:.3f}-fold in a cycle (largest Floquet"
                " multiplier of the periodic state that `reference` found); try more damping, or another speed"
            )
        if cycles_needed(self.multiplier, error) <= GREATEST_NUMBER:
            return ""
        return (
            f"not marched: {GREATEST_NUMBER} cycles will not do, for a disturbance keeps {self.multiplier:.3f} of itself in a cycle"
            " (largest Floquet multiplier of the periodic state that `reference` found); try more damping, or the engine `reference`, which"
            " need not march"
        )


def cycles_needed(multiplier: float, error: float) -> float:
    """Cycles after which an engine that errs by `error` in a few cycles has settled, beginning in another's periodic state."""
    distance = error / (1.0 - multiplier)
    if distance <= TOLERANCE:
        return 0.0
    return math.log(distance / TOLERANCE) / -math.log(multiplier) if multiplier > 0.0 else 1.0


def begins_in_orbit(engine: Engine) -> bool:
    """Whether an engine shall begin in the orbit of `reference`; not if it solves other equations, whose orbit is another one."""
    return engine.estimates != "integration"


def find_orbit(mechanism: Mechanism) -> tuple[dict[str, Any], dict[str, Array]]:
    """Search from the standard start with the settings of `reference` for its default accuracy; what a store keeps of it."""
    reference, start = ReferenceEngine(), standard_start(mechanism)
    try:
        reference.check(mechanism)
        found = reference.steady_state(mechanism, start, reference.settings_for(reference.default_accuracy, mechanism))
    except (Refusal, NoSteadyState, EngineFailure) as reason:
        return {"multiplier": None, "reason": str(reason)}, {}
    if found is None:
        return {"multiplier": None, "reason": "none is looked for with a rigid follower or a soft joint"}, {}
    multiplier = abs(found.multipliers[0])
    if not found.stable:
        return {"multiplier": multiplier, "reason": "the periodic state is not stable"}, {}
    assert isinstance(found.simulation, OwnSimulation)
    begin = found.simulation.present_start()
    arrays: dict[str, Array] = {}
    for name, field in (("deflection", begin.deflection), ("rate", begin.deflection_rate)):
        assert isinstance(field, PPoly)
        arrays |= {f"{name}_x": field.x, f"{name}_c": field.c}
    about = {"crank_angle": begin.crank_angle, "crank_speed": begin.crank_speed, "period": found.period}
    return {"multiplier": multiplier, "reason": "", **about}, arrays


def orbits(mechanisms: Iterable[Mechanism], store: Store, jobs: int | None = None, limits: Limits | None = None) -> dict[str, Orbit]:
    """The orbits of several scenes by `orbit_key`, taken from the store or searched in a process of its own each.

    Raises:
        KeyboardInterrupt: Ctrl-C; what was computed is stored.
    """
    work = [Job(key, find_orbit, (mechanism,)) for key, mechanism in {orbit_key(m): m for m in mechanisms}.items()]
    if not work:
        return {}
    entries, others = stored(work, store, "periodic states", at_once=jobs, limits=limits)
    found = {key: _orbit(entry) for key, entry in entries.items()}
    return found | {key: Orbit(None, None, f"the search {outcome.explanation}") for key, outcome in others.items()}


def orbit_key(mechanism: Mechanism) -> str:
    """Key under which the orbit of a scene is stored."""
    return key_of({"kind": "periodic state", "scene": mechanism, "code": code_fingerprint((*SIMULATION, "cases.orbit"))})


def _orbit(entry: Entry) -> Orbit:
    document, arrays = entry.document, entry.arrays
    if document["reason"]:
        return Orbit(None, document["multiplier"], document["reason"])
    curves = [Curve(arrays[f"{name}_x"], arrays[f"{name}_c"]) for name in ("deflection", "rate")]
    start = Start(document["crank_angle"], document["crank_speed"], *curves)
    return Orbit(start, document["multiplier"], period=document["period"])
