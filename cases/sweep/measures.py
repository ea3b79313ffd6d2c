"""Measures of a settled motion: names, units, meanings, and the error of each number."""

import difflib
import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property, partial
from types import MappingProxyType
from typing import Final

import numpy as np

from quickreturn.cases.errors import Argument, CaseError, as_written
from quickreturn.cases.loads import Claimed
from quickreturn.cases.loads.peak import Peak, of_column, of_vector
from quickreturn.cases.loads.stress import arm_stress
from quickreturn.cases.measures.cycle import AMPLITUDE, FREQUENCY, HALVES
from quickreturn.cases.measures.extremes import extremes
from quickreturn.cases.measures.time_scale import CHANNELS
from quickreturn.cases.runs.estimates import TIME, or_nan, rms_over_time
from quickreturn.cases.runs.request import PeriodicOrbit, Run
from quickreturn.engines.accurate import Assessment
from quickreturn.reference_model.columns import COLUMNS
from quickreturn.reference_model.mechanism import Mechanism
from quickreturn.reference_model.witnesses import Witness

#: Value and its error, in the measure's unit; nan where unavailable.
Measured = tuple[float, float]
NOTHING: Final[Measured] = (math.nan, math.nan)

ARGUMENT: Final = Argument("measures", "--measure")

_TESTS: Final = "tests/verification/test_witnesses.py::test_"
_NUMPY: Final = partial(
    Witness, "plain numpy on rows of 0.1 ms of `mujoco`", test=f"{_TESTS}plain_numpy_on_a_link_chain_confirms_the_measures_of_a_turn"
)
_GAUGES: Final = partial(
    Witness, "strain gauges of `mujoco` at the place", test=f"{_TESTS}gauges_of_a_link_chain_confirm_the_stress_along_the_arm"
)
_MARCHES: Final = partial(
    Witness, "the decay of disturbances in `mujoco`", test=f"{_TESTS}disturbed_marches_of_a_link_chain_confirm_the_largest_multiplier"
)

#: Meaning of the measure `multiplier`.
MULTIPLIER: Final = "largest modulus of the Floquet multipliers of crank speed and the two lowest modes (higher modes may ring longer)"
#: Part of a fit's uncertainty that counts as error, besides the difference from the fit to the finer run's motion. Fits to nearly equal
#: motions share nearly all of it: with this part 698 frequencies and amplitudes of 40 machines were off by at most 0.8 of the claim.
FITTED: Final = 0.1
#: Relative round-off of the instants at which a turn begins and ends.
ROUND_OFF: Final = 1e-12
#: Error of a size over the size above which it says nothing.
SAYS_NOTHING: Final = 0.5
#: Part of the last step of the search for a periodic motion that is left as its error, see `ORBIT_TOLERANCE` of `reference`.
LEFT_BY_SEARCH: Final = 0.1


@dataclass(frozen=True)
class SettledMotion:
    """A settled motion: a machine, and the run that shows it."""

    mechanism: Mechanism
    run: Run

    @cached_property
    def claim(self) -> Claimed:
        """Error of a column at a crank angle, by the engine's own estimate."""
        return Claimed(self.run)


@dataclass(frozen=True)
class Measure:
    """A number that a study may ask for."""

    name: str  # as asked for
    unit: str  # SI
    meaning: str  # in words
    of: Callable[[SettledMotion], Measured]  # computes it
    witness: Witness  # confirms it
    columns: tuple[str, ...] = ()  # columns of the cycle that it needs
    vibration: bool = False  # whether the first mode must be fitted for it, which takes longest
    multipliers: bool = False  # whether it needs the multiplier of the whole model, which takes some more turns
    size: bool = False  # whether it is a size: an error as large as `SAYS_NOTHING` of it leaves nothing of the number

    def says_nothing(self, value: float, error: float) -> str:
        """Why a number with its error says nothing (a clause); "" if it says something, or if the error is unknown."""
        if not self.size or not error > SAYS_NOTHING * abs(value) > 0.0:
            return ""
        return f"{self.name} is {value:.3g} +- {error:.2g} {self.unit}".removesuffix(" 1") + ", which says nothing"


def measure(name: str) -> Measure:
    """The measure of a name. CaseError: it is unknown; the nearest are named."""
    if name in MEASURES:
        return MEASURES[name]
    near = difflib.get_close_matches(name, MEASURES, 3, 0.4)
    accepted = f"the nearest are {', '.join(near)}" if near else "`quickreturn sweep --help` lists them"
    raise CaseError(ARGUMENT, None, as_written(name), "is unknown", accepted)


def of_columns(name: str, unit: str) -> Iterator[Measure]:
    """The measures of a column of the trajectory."""
    kinds: tuple[tuple[str, str, Callable[[str, SettledMotion], Measured]], ...] = (
        ("peak", f"largest magnitude of {name} in a turn", _peak),
        ("min", f"least value of {name} in a turn", partial(_extreme, 0)),
        ("max", f"greatest value of {name} in a turn", partial(_extreme, 1)),
        ("rms", f"root mean square of {name} over a turn", _rms),
    )
    # run 24's tip body is light: the moment at the tip is 3e-4 of that in the arm, and differs more in its own size
    witness = _NUMPY(3e-3 if name == "moment_tip" else 5e-4)
    for kind, meaning, of in kinds:
        yield Measure(f"{kind}.{name}", unit, meaning, partial(_where_given, name, of), witness, (name,), size=kind in ("peak", "rms"))


def _where_given(column: str, of: Callable[[str, SettledMotion], Measured], motion: SettledMotion) -> Measured:
    """A measure of a column; `NOTHING` if the engine does not deliver it."""
    return of(column, motion) if column in motion.run.cycle else NOTHING


def _of_peak(peak: Peak | None) -> Measured:
    return NOTHING if peak is None else (peak.value, or_nan(peak.error))


def _peak(name: str, motion: SettledMotion) -> Measured:
    return _of_peak(of_column(name, motion.run.cycle, motion.claim))


def _bearing(name: str, motion: SettledMotion) -> Measured:
    return _of_peak(of_vector(name, motion.run.cycle, motion.claim))


def _stress(what: str, motion: SettledMotion) -> Measured:
    stress = arm_stress(motion.mechanism, motion.run.cycle, motion.claim)
    return _of_peak(None if stress is None else getattr(stress, what))


def _extreme(which: int, column: str, motion: SettledMotion) -> Measured:
    """The least (0) or greatest (1) value."""
    cycle = motion.run.cycle
    extreme = extremes(cycle["time"], cycle[column], cycle["time"][0], cycle["time"][-1])[which]
    crank_angle = float(np.interp(extreme.time, cycle["time"], cycle["crank_angle"]))
    return extreme.value, or_nan(motion.claim(column, crank_angle)) + extreme.uncertainty


def _rms(column: str, motion: SettledMotion) -> Measured:
    value = rms_over_time(motion.run.cycle["time"], motion.run.cycle[column])
    return value, _of_turn(motion, column, "rms") + _left(motion) * value


def _per_turn(column: str, motion: SettledMotion) -> Measured:
    """Change of a column in a turn."""
    values = motion.run.cycle[column]
    return float(values[-1] - values[0]), _of_turn(motion, column, "change") + _left(motion) * float(np.ptp(values))


def _of_turn(motion: SettledMotion, column: str, what: str) -> float:
    """The engine's estimate of the error of a column's root mean square or change in a turn; nan if it has none."""
    return motion.run.turn_estimates.get(column, {}).get(what, math.nan)


def _left(motion: SettledMotion) -> float:
    """Relative distance from the steady state."""
    part = 1.0 if motion.run.periodic_orbit is None else LEFT_BY_SEARCH
    return part * (motion.run.settling_error or 0.0)


def _consensus(half: str, motion: SettledMotion) -> Measured:
    consensus = motion.run.consensus_of(half)
    if consensus is None or consensus.first_mode_frequency is None:
        return NOTHING
    return consensus.first_mode_frequency, or_nan(consensus.first_mode_frequency_estimate) + FITTED * or_nan(consensus.uncertainty)


def _vibration(half: str, channel: str, quantity: str, motion: SettledMotion) -> Measured:
    measure = motion.run.measure(half, channel)
    if measure is None or (value := measure.number(quantity)) is None:
        return NOTHING
    return value, or_nan(measure.estimate(quantity)) + FITTED * or_nan(measure.number(f"{quantity}_uncertainty"))


def _multiplier(number: Callable[[PeriodicOrbit], tuple[float, float | None]], motion: SettledMotion) -> Measured:
    orbit = motion.run.periodic_orbit
    if orbit is None:
        return NOTHING
    value, error = number(orbit)
    return value, or_nan(error)


def _period(motion: SettledMotion) -> Measured:
    time = motion.run.cycle["time"]
    value = float(time[-1] - time[0])
    left = _left(motion) if motion.mechanism.crank_is_free else ROUND_OFF
    return value, _of_turn(motion, TIME, "change") + left * value


def _solve_seconds(motion: SettledMotion) -> Measured:
    return motion.run.solve_seconds or math.nan, math.nan


def _declared() -> Iterator[Measure]:
    for name, column in COLUMNS.items():
        if name != "time":
            yield from of_columns(name, column.unit)
    for name, where in (("pivot_force", "P"), ("crank_force", "O")):
        yield Measure(
            f"peak.{name}",
            "N",
            f"largest force of the bearing {where}",
            partial(_bearing, name),
            _NUMPY(5e-4),
            (f"{name}_x", f"{name}_y"),
            size=True,
        )
    for name, what, meaning in (
        ("peak", "largest", "largest bending stress along the arm"),
        ("amplitude", "amplitude", "half the range of the stress in a turn, where that is largest"),
    ):
        yield Measure(f"{name}.stress", "Pa", meaning, partial(_stress, what), _GAUGES(5e-4), tuple(COLUMNS), size=True)
    for half in HALVES:
        meaning = f"frequency of the first mode, {half}-return, over all channels"
        yield Measure(f"{half}.frequency", "Hz", meaning, partial(_consensus, half), FREQUENCY, CHANNELS, True)
        for channel in CHANNELS:
            for what, unit, words, witness in (
                ("frequency", "Hz", "frequency", FREQUENCY),
                ("amplitude", COLUMNS[channel].unit, "RMS of the envelope", AMPLITUDE),
            ):
                meaning = f"{words} of the first mode, {half}-return, in {channel}"
                of = partial(_vibration, half, channel, f"first_mode_{what}")
                yield Measure(f"{half}.{what}.{channel}", unit, meaning, of, witness, CHANNELS, True)
    for name, meaning, number in (
        ("multiplier", MULTIPLIER, lambda orbit: (math.hypot(*orbit.multipliers[0]), orbit.multiplier_error)),
        ("multiplier.real", "real part of that multiplier", lambda orbit: (orbit.multipliers[0][0], orbit.multiplier_distance)),
        ("multiplier.imag", "imaginary part of that multiplier", lambda orbit: (orbit.multipliers[0][1], orbit.multiplier_distance)),
    ):
        yield Measure(name, "1", meaning, partial(_multiplier, number), _MARCHES(5e-5), multipliers=True)
    yield Measure("period", "s", "time of a turn", _period, _NUMPY(2e-5))
    for name, meaning in (
        ("drive_work", "work of the drive, and of a force on the tip, in a turn"),
        ("dissipated_energy", "energy dissipated in a turn"),
    ):
        yield Measure(f"turn.{name}", "J", meaning, partial(_where_given, name, _per_turn), _NUMPY(2e-5), (name,))
    yield Measure(
        "solve_seconds",
        "s",
        "wall time of the solve",
        _solve_seconds,
        Assessment.witnesses["solve_seconds"],
    )


#: Name -> measure, in the order in which they are listed.
MEASURES: Final[Mapping[str, Measure]] = MappingProxyType({each.name: each for each in _declared()})


def listed() -> list[Measure]:
    """The measures for a list: those that every column of a trajectory has stand there once, for COLUMN."""
    single = MEASURES.keys() - {each.name for name in COLUMNS for each in of_columns(name, "")}
    return [*of_columns("COLUMN", "the column's unit"), *(each for name, each in MEASURES.items() if name in single)]
