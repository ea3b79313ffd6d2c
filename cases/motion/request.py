"""The request of a run, and its result."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Final

import numpy as np

from quickreturn.cases.motion.cycle import EXTREMES, ChannelMeasures
from quickreturn.cases.motion.endings import Ending
from quickreturn.cases.motion.estimates import MeasuredNumbers
from quickreturn.cases.motion.number import Consensus, Number, or_nan
from quickreturn.cases.motion.of_turn import rms_over_time
from quickreturn.cases.motion.orbit import Orbit
from quickreturn.cases.motion.settling import Outlook
from quickreturn.cases.motion.stability import Multiplier
from quickreturn.engines.accurate import Result
from quickreturn.engines.base import AnyEngine, SteadyState
from quickreturn.engines.error_parts import ESTIMATED, TIP, ErrorPart
from quickreturn.engines.start import Start, standard_start
from quickreturn.engines.trajectory import Columns
from quickreturn.reference_model.mechanism import Mechanism

#: Largest ratio of an engine's period to that of `reference`.
LARGEST_PERIOD_RATIO: Final = 1.01

#: Number of cycles from the orbit for an engine's error estimate (see `cases.motion.estimates`).
ESTIMATED_CYCLES: Final = 2

#: A column that never exceeds this, in its SI unit, is zero except for rounding.
NOTHING: Final = 1e-12

#: Where a run began; `DIRECT`: it did not march, because the engine's own search found the steady state.
STANDARD: Final = "standard"
FROM_ORBIT: Final = "periodic orbit of reference"
DIRECT: Final = "found directly"


@dataclass(frozen=True, kw_only=True)
class RunRequest:
    """One engine on one scene, to be brought to its steady state and measured; everything in it determines the result."""

    mechanism: Mechanism
    duration: float  # s, the stretch of the error estimate from the standard start
    engine: str
    accuracy: float | None = None  # error of the tip deflection; None: the engine's default
    settings: dict[str, str] = field(default_factory=dict)
    estimated: bool = True  # whether the measures of the cycle get estimates, which takes some more runs
    turn: int | None = None  # turn to measure, counted from the standard start (1, 2, ...), within `duration`; None: the steady state
    straight: bool = False  # march from the standard start even if there is an orbit
    orbit: Orbit | None = None  # the orbit to begin in unless `straight`, as found by `carry_out`; its multiplier serves every march

    @property
    def start(self) -> Start:
        """The start of the run."""
        orbit = self._first_orbit
        return (orbit and orbit.begin) or standard_start(self.mechanism)

    def estimated_on(self, step: float) -> float:
        """The stretch on which the error is estimated, s, a multiple of `step` (s).

        From the standard start it is the duration, from an orbit a little more than `ESTIMATED_CYCLES` cycles.
        """
        orbit = self._first_orbit
        stretch = self.duration if orbit is None else ESTIMATED_CYCLES * LARGEST_PERIOD_RATIO * orbit.period
        return step * math.ceil(stretch / step - 1e-9)

    @property
    def _first_orbit(self) -> Orbit | None:
        """The orbit in which the run begins; None: it begins in the standard start."""
        return None if self.straight or self.turn is not None or self.orbit is None or self.orbit.begin is None else self.orbit


@dataclass(frozen=True)
class PeriodicOrbit:
    """A steady state that an engine found directly."""

    period: float  # s
    multipliers: tuple[tuple[float, float], ...]  # Floquet's, real and imaginary part, largest modulus first
    stable: bool  # whether a disturbance dies away
    iterations: int  # of the search
    multiplier_error: float | None = None  # of the modulus of the first multiplier; None: unknown
    multiplier_distance: float | None = None  # likewise of its real and imaginary part

    @classmethod
    def of(cls, state: SteadyState, multiplier: Multiplier | None = None) -> "PeriodicOrbit":
        """The orbit of a state as it is stored; `multiplier` takes the place of the search's largest one, and of its conjugate."""
        found = state.multipliers
        if multiplier is None:
            return cls(state.period, tuple((each.real, each.imag) for each in found), state.stable, state.iterations)
        value = multiplier.value
        first = (value, value.conjugate()) if value.imag != 0.0 else (value,)
        parts = tuple((each.real, each.imag) for each in (*first, *found[len(first) :]))
        return cls(state.period, parts, multiplier.status == Ending.SETTLED, state.iterations, multiplier.error, multiplier.distance)


@dataclass(frozen=True)
class Recording:
    """The recorded table of a run."""

    path: str
    rows: int
    declared: Mapping[str, str]  # its declarations, see `cases.files.recorded.DECLARATIONS`
    of_experiment: bool  # whether it lies in the folder of the experiment's recordings
    begins: float = 0.0  # time of its first row that counts as 0, s
    told: str = ""  # how its file was read

    @property
    def filtered(self) -> bool:
        """Whether its extremes, and the engines' beside them, are taken after the low-pass for measured signals."""
        return self.declared.get("origin", "simulated") != "simulated"


@dataclass(frozen=True, kw_only=True)
class Computation:
    """What a run was computed with: its settings, their error estimate from the run's start, and what they cost."""

    accuracy: float | None = None  # error of the tip deflection that was aimed at
    settings: dict[str, Any] | None = None
    reached: bool = False  # whether the error estimate is within the accuracy
    error_estimate: float | None = None  # of the tip deflection, relative
    error_estimates: dict[str, float | None] = field(default_factory=dict)  # of each column
    error_parts: dict[str, tuple[ErrorPart, ...]] = field(default_factory=dict)  # see `engines.accurate.Result`
    degrees_of_freedom: int | None = None
    setup_seconds: float | None = None  # this and the next three as in `engines.accurate.Result`
    compile_seconds: float | None = None
    estimate_seconds: float | None = None
    solve_seconds: float | None = None
    wall_seconds: float | None = None  # time of the whole request

    @classmethod
    def of(cls, result: Result) -> "Computation":
        """That of a result from which the settings of a run were taken: its solve time belongs to the estimate."""
        return cls(
            accuracy=result.accuracy,
            settings=result.settings,
            reached=result.reached,
            error_estimate=result.error_estimate,
            error_estimates=result.error_estimates,
            error_parts=result.error_parts,
            degrees_of_freedom=result.description.degrees_of_freedom,
            setup_seconds=result.setup_seconds,
            compile_seconds=result.compile_seconds,
            estimate_seconds=result.estimate_seconds + result.solve_seconds,
        )


@dataclass(frozen=True, kw_only=True)
class Approach:
    """How a run came to the cycle that is measured."""

    start: str | None = None  # `STANDARD`, `FROM_ORBIT` or `DIRECT`
    turn: int | None = None  # number of the measured turn if the request names one
    settled: bool = False
    cycles: int = 0  # number of simulated cycles, or the work of the direct search in cycles
    averaged_cycles: int = 1  # number of last cycles for the means of the measures; 1: the last cycle alone, which repeats
    settling_error: float | None = None  # estimated distance of the last cycle from the steady state, relative to the signals' RMS
    settling_errors: dict[str, float] | None = None  # the same of each channel, in its own unit
    settling: Outlook | None = None  # outlook of the cycles if they did not settle
    periodic_orbit: PeriodicOrbit | None = None  # where it was found directly

    def distance(self, channel: str, size: float) -> float:
        """Estimated distance of a channel, of this size in its unit, from its steady state."""
        known = (self.settling_errors or {}).get(channel)
        return (self.settling_error or 0.0) * size if known is None else known


@dataclass(frozen=True, kw_only=True)
class Run:
    """The result of a request, or of a recorded table; None for parts that were not reached."""

    engine: str
    method: str = ""
    version: str | None = None
    estimate_of: str  # what its estimates cover, see `engines.base.Engine.estimates`
    status: str = Ending.REFUSED  # the word of an `Ending`
    remark: str = ""  # a sentence if something went wrong, otherwise ""
    failure_time: float | None = None  # s, of a run that broke down; with cause and advice
    cause: str | None = None
    advice: str | None = None
    recording: Recording | None = None  # the recorded table whose run this is; None: an engine's
    computation: Computation = field(default_factory=Computation)
    approach: Approach = field(default_factory=Approach)
    measured: MeasuredNumbers = field(default_factory=MeasuredNumbers)
    #: The last cycle with every column of the trajectory, from farthest to farthest; the rows of a failed run; otherwise empty.
    cycle: Columns = field(default_factory=dict, repr=False, compare=False)

    @classmethod
    def begun(cls, request: RunRequest, engine: AnyEngine) -> "Run":
        """A run before any computation."""
        computation = Computation(accuracy=request.accuracy or engine.default_accuracy)
        return cls(engine=engine.name, method=engine.method, estimate_of=engine.estimates, computation=computation)

    def __repr__(self) -> str:
        estimates = self.computation.error_estimates
        lines = [f"{self.engine}: {self.status} after {self.approach.cycles} cycles" + (f"; {self.remark}" if self.remark else "")]
        shown = {name: estimates[name] for name in ESTIMATED if name in estimates}
        lines += [f"  error of {name}: {'unknown' if error is None else f'{error:.1e}'}" for name, error in shown.items()]
        lines += [f"  {part}" for part in self.computation.error_parts.get(TIP, ())]
        for each in self.measured.consensus:
            if each.first_mode_frequency is not None:
                lines.append(f"  first mode, {each.half}-return: {each.first_mode_frequency:.2f} Hz")
        return "\n".join(lines)

    @property
    def flat(self) -> dict[str, Any]:
        """Everything but the cycle, by the names of the fields; those of the parts stand among the others."""
        own = {name: value for name, value in vars(self).items() if name not in ("computation", "approach", "measured", "cycle")}
        return {**own, **vars(self.computation), **vars(self.approach), **vars(self.measured)}

    @property
    def usable(self) -> bool:
        """Whether there is a cycle with measures."""
        return self.ending.usable

    @property
    def ending(self) -> Ending:
        """The status of the run."""
        return Ending(self.status)

    @property
    def mean_crank_speed(self) -> float:
        """Mean speed of the crank over the cycle, rad/s; negative if it turns clockwise."""
        angle, time = self.cycle["crank_angle"], self.cycle["time"]
        return float(angle[-1] - angle[0]) / float(time[-1] - time[0])

    def measure(self, half: str, channel: str) -> ChannelMeasures | None:
        """The measure of a half and channel, or None if there is none."""
        return next((measure for measure in self.measured.measures if (measure.half, measure.channel) == (half, channel)), None)

    def number(self, quantity: str, half: str, channel: str) -> Number | None:
        """A number of `VIBRATION` or `EXTREMES` with its claims and what is left to the steady state; None if it is not resolved."""
        measure = self.measure(half, channel)
        number = None if measure is None else measure.number(quantity)
        if measure is None or number is None:
            return None
        if quantity in EXTREMES:
            return replace(number, settling=or_nan((self.approach.settling_errors or {}).get(channel)))
        if channel not in self.cycle or not self.approach.settling_error:
            return number
        left = self.approach.settling_error * rms_over_time(self.cycle["time"], self.cycle[channel])
        return replace(number, settling=measure.response(quantity) * left)

    def consensus_of(self, half: str) -> Consensus | None:
        """The consensus of a half on the first-mode frequency; None if there is none, or where it is not resolvable."""
        return next((one for one in self.measured.consensus if one.half == half and one.first_mode_frequency is not None), None)

    def consensus_frequency(self, half: str) -> float | None:
        """Consensus of the first-mode frequency in a half, Hz, or None where not resolvable."""
        consensus = self.consensus_of(half)
        return None if consensus is None else consensus.first_mode_frequency

    def peak(self, channel: str) -> float:
        """Largest modulus of a channel over the cycle."""
        return float(np.max(np.abs(self.cycle[channel])))
