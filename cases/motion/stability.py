"""The largest Floquet multiplier of a periodic motion with its error, and what it says of the motion's stability.

The multiplier is that of the crank's speed and of the two lowest modes, which the motion excites; higher modes may ring longer. It is taken
from the whole model (equation 10.14), so that it does not depend on where the search began. `run`, `sweep` and the search for the start of
marching share this file.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from quickreturn.cases.motion.endings import Ending
from quickreturn.engines.error_parts import Compared

if TYPE_CHECKING:
    from quickreturn.engines.own.simulation import FoundOrbit

#: Statuses of motions that are not settled: how they lose their stability (fold, period doubling or torus), or that it is not known.
UNSTABLE: Final = "unstable: {}"
NOT_CONVERGED: Final = "not converged"
#: Least error of a multiplier: what is left of the search for the motion moves it by up to 3.8e-5 in the thesis' runs, ...
SEARCH_ERROR: Final = 5e-5
#: ... and the integration by this many times its tolerance: 1.5e-4 was measured with 1e-5.
ERROR_OVER_TOLERANCE: Final = 10.0
#: Part of the distance between the slow model's multiplier and the whole model's that counts as error: that distance is of first order in
#: the slow model's faults, the error of second order; it was up to 0.34 of the distance in the thesis' runs where one finer model showed
#: less.
SECOND_ORDER_PART: Final = 0.5
#: Least error of the modulus over that in the complex plane: models differ in the angle much more than in the modulus, up to 60-fold in the
#: thesis' runs.
MODULUS_PART: Final = 0.05
#: Assumed error of a multiplier of the slow model alone, without a second model: it was up to 3e-3 in the thesis' runs.
UNCOMPARED_ERROR: Final = 3e-3
#: Largest error of a multiplier with which a motion whose multiplier is 1 within it counts as neutral; with a larger one nothing is known.
NEUTRAL_WITHIN: Final = 0.05


@dataclass(frozen=True)
class Multiplier:
    """The largest Floquet multiplier of a motion."""

    value: complex
    error: float | None = None  # of its modulus, by comparison with finer models; None without a comparison
    distance: float | None = None  # the same in the complex plane, for its real and imaginary part

    @property
    def status(self) -> str:
        """`settled`, `neutral`, unstable, or `not converged`: whether a disturbance dies away."""
        size, error = abs(self.value), UNCOMPARED_ERROR if self.error is None else self.error
        if size + error < 1.0:
            return Ending.SETTLED
        if size - error > 1.0:
            return UNSTABLE.format(self._instability)
        return Ending.NEUTRAL if error <= NEUTRAL_WITHIN else NOT_CONVERGED

    @property
    def sentence(self) -> str:
        """Why the motion is not settled; "" if it is."""
        size, error = abs(self.value), UNCOMPARED_ERROR if self.error is None else self.error
        number = f"largest Floquet multiplier {size:.7g} +- {error:.1e}"
        if self.status == Ending.SETTLED:
            return ""
        if self.status == Ending.NEUTRAL:
            return f"a disturbance neither grows nor dies away within the error ({number})"
        if self.status == NOT_CONVERGED:
            return f"whether a disturbance dies away is not known ({number}); ask for a smaller accuracy"
        return f"a disturbance grows {size:.7g}-fold in a turn ({self._instability}; {number})"

    @property
    def _instability(self) -> str:
        from quickreturn.reference_model.cycles.periodic import instability_of

        return instability_of(self.value)


def nearly_one(state: "FoundOrbit") -> bool:
    """Whether the stability of a motion needs its multiplier's error."""
    from quickreturn.reference_model.cycles.periodic import NEARLY_ONE

    return abs(state.multipliers[0]) > NEARLY_ONE


def multiplier_of(state: "FoundOrbit", compared: "Sequence[Compared[FoundOrbit]]" = ()) -> Multiplier:
    """The largest multiplier of a motion, with its error if there are motions of finer models to compare with.

    The difference to one finer model may vanish by accident, hence the floors `SECOND_ORDER_PART` and `SEARCH_ERROR`.

    Raises:
        NoSteadyState: a cycle of the whole model is broken.
    """
    whole = _Whole()
    value = whole(state).largest
    if not compared:
        return Multiplier(value)
    wholes = [runs.mapped(whole) for runs in compared]
    floor = max(SECOND_ORDER_PART * whole(state).corrected, SEARCH_ERROR + ERROR_OVER_TOLERANCE * state.simulation.tolerance)
    distance = max(sum(runs.part(lambda one, other: other.apart(one.largest)).error for runs in wholes), floor)
    modulus = sum(runs.part(lambda one, other: abs(abs(one.largest) - abs(other.largest))).error for runs in wholes)
    return Multiplier(value, max(modulus, floor, MODULUS_PART * distance), distance)


@dataclass(frozen=True)
class _Largest:
    """The largest multiplier of a whole model.

    Several multipliers may be equally large: without damping all of them lie on the unit circle, and the last digits decide which one is
    the largest. Each is therefore compared with its own counterpart, the nearest one, in the slow model as in a finer whole model.
    """

    largest: complex
    corrected: float  # distance in the complex plane to the slow model's same multiplier; 0 where the whole Jacobian is known
    others: tuple[complex, ...] = ()  # all multipliers of the whole model, where one comes close to the unit circle

    def apart(self, value: complex) -> float:
        """Distance in the complex plane of another model's multiplier to its counterpart here."""
        return min(_apart(value, each) for each in (self.largest, *self.others))


class _Whole:
    """The multipliers of whole models, each computed once."""

    def __init__(self) -> None:
        self._known: dict[int, _Largest] = {}

    def __call__(self, state: "FoundOrbit") -> _Largest:
        if id(state) not in self._known:
            self._known[id(state)] = self._of(state)
        return self._known[id(state)]

    @staticmethod
    def _of(state: "FoundOrbit") -> _Largest:
        if nearly_one(state):  # the search has the whole Jacobian
            return _Largest(complex(state.multipliers[0]), 0.0, tuple(map(complex, state.multipliers)))
        value = state.whole_multiplier()
        return _Largest(value, min(_apart(value, complex(each)) for each in state.multipliers))


def _apart(one: complex, other: complex) -> float:
    """Distance of two multipliers in the complex plane; either of a conjugate pair may be given."""
    return min(abs(one - other), abs(one - other.conjugate()))
