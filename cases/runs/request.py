"""The request of a run, and its result."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np

from quickreturn.cases.measures.steady_state import Outlook
from quickreturn.cases.runs.endings import Ending
from quickreturn.cases.runs.estimates import EstimatedConsensus, EstimatedMeasure
from quickreturn.cases.runs.orbit import Orbit
from quickreturn.engines.base import AnyEngine
from quickreturn.engines.error_parts import ESTIMATED
from quickreturn.engines.start import Start, standard_start
from quickreturn.engines.trajectory import Columns
from quickreturn.reference_model.mechanism import Mechanism

#: Code on which a run depends besides the simulation.
CODE: Final = ("quickreturn.cases.measures", "quickreturn.cases.runs")

#: Allowed relative difference of an engine's period from that of `reference`.
LONGER: Final = 1.01

#: Number of cycles from the orbit for an engine's error estimate (see `cases.runs.estimates`).
ESTIMATED_CYCLES: Final = 2

#: A column that never exceeds this, in its SI unit, is zero except for rounding.
NOTHING: Final = 1e-12

STANDARD: Final = "standard"  # where a run began
FROM_ORBIT: Final = "periodic orbit of reference"
DIRECT: Final = "found directly"  # no march: the engine's own search


@dataclass(frozen=True, kw_only=True)
class RunRequest:
    """One engine on one scene, to be brought to its steady state and measured; everything in it determines the result."""

    mechanism: Mechanism
    duration: float  # s, the stretch of the error estimate from the standard start
    engine: str
    accuracy: float | None = None  # error of the tip deflection; None: the engine's default
    settings: dict[str, str] = field(default_factory=dict)
    estimated: bool = True  # whether the measures of the cycle get estimates, which takes some more runs
    turn: int | None = None  # measure this one, counted from the standard start (1, 2, ...), which `duration` covers; None: settle
    straight: bool = False  # march from the standard start even if there is an orbit
    orbit: Orbit | None = None  # the orbit to begin in, as found by `carry_out`; None: the standard start

    @property
    def start(self) -> Start:
        """The start of the run."""
        found = self._begun_from
        return (found and found.begin) or standard_start(self.mechanism)

    def estimated_on(self, step: float) -> float:
        """The stretch on which the error is estimated, s: from the periodic state a little more than so many cycles."""
        found = self._begun_from
        stretch = self.duration if found is None else ESTIMATED_CYCLES * LONGER * found.period
        return step * math.ceil(stretch / step - 1e-9)

    @property
    def _begun_from(self) -> Orbit | None:
        """The orbit that the run begins in; None: the standard start."""
        return None if self.straight or self.turn is not None or self.orbit is None or self.orbit.begin is None else self.orbit


@dataclass(frozen=True)
class PeriodicOrbit:
    """A steady state that an engine found directly."""

    period: float  # s
    multipliers: tuple[tuple[float, float], ...]  # Floquet's, real and imaginary part, largest modulus first
    stable: bool  # whether a disturbance dies away
    iterations: int  # of the search


@dataclass(frozen=True)
class Recording:
    """The recorded table of a run."""

    path: str
    rows: int
    declared: Mapping[str, str]  # its declarations, see `cases.recorded.DECLARATIONS`
    of_experiment: bool  # whether it lies in the folder of the experiment's recordings

    @property
    def filtered(self) -> bool:
        """Whether its extremes, and the engines' beside them, are taken after the low-pass for measured signals."""
        return self.declared.get("origin", "simulated") != "simulated"


@dataclass(frozen=True, kw_only=True)
class Run:
    """The result of a request, or of a recorded table; None for parts that were not reached."""

    engine: str
    method: str = ""
    version: str | None = None
    estimate_of: str  # what its estimates cover, see `engines.base.Engine.estimates`
    accuracy: float | None = None  # error of the tip deflection that was aimed at
    status: str = Ending.REFUSED  # the word of an `Ending`
    remark: str = ""  # a sentence if something went wrong, otherwise ""
    start: str | None = None  # one of those above
    settled: bool = False
    cycles: int = 0  # number of simulated cycles, or the work of the direct search in cycles
    averaged_cycles: int = 1  # number of last cycles for the means of the measures; 1: the last cycle alone, which repeats
    settling_error: float | None = None  # estimated distance of the last cycle from the steady state, relative to the signals' RMS
    settling_errors: dict[str, float] | None = None  # the same of each channel, in its own unit
    settling: Outlook | None = None  # outlook of the cycles if they did not settle
    periodic_orbit: PeriodicOrbit | None = None  # where it was found directly
    settings: dict[str, Any] | None = None
    reached: bool = False  # whether the error estimate is within the accuracy
    error_estimate: float | None = None  # of the tip deflection, relative
    error_estimates: dict[str, float | None] = field(default_factory=dict)  # of each column
    degrees_of_freedom: int | None = None
    setup_seconds: float | None = None  # these as in `engines.accurate.Result`
    compile_seconds: float | None = None
    estimate_seconds: float | None = None
    solve_seconds: float | None = None
    wall_seconds: float | None = None  # in all
    simulated_seconds: float | None = None  # simulated time in the solve time
    failure_time: float | None = None  # s, of a run that broke down; with cause and advice
    cause: str | None = None
    advice: str | None = None
    turn: int | None = None  # that was measured, where it was asked for
    recording: Recording | None = None  # of a recorded table
    measures: tuple[EstimatedMeasure, ...] = ()
    consensus: tuple[EstimatedConsensus, ...] = ()
    unestimated: str = "there is no settled cycle"  # why there are no estimates of the measures (a clause), "" if there are
    extreme_estimates: dict[str, dict[str, float]] = field(default_factory=dict)  # column -> half -> of its extremes, where there are any
    #: The last cycle with every column of the trajectory, from farthest to farthest; the rows of a failed run; otherwise empty.
    cycle: Columns = field(default_factory=dict, repr=False, compare=False)

    @classmethod
    def begun(cls, request: RunRequest, engine: AnyEngine) -> "Run":
        """A run before any computation."""
        accuracy = request.accuracy or engine.default_accuracy
        return cls(engine=engine.name, method=engine.method, estimate_of=engine.estimates, accuracy=accuracy)

    def __repr__(self) -> str:
        lines = [f"{self.engine}: {self.status} after {self.cycles} cycles" + (f"; {self.remark}" if self.remark else "")]
        shown = {name: self.error_estimates[name] for name in ESTIMATED if name in self.error_estimates}
        lines += [f"  error of {name}: {'unknown' if error is None else f'{error:.1e}'}" for name, error in shown.items()]
        for each in self.consensus:
            if each.first_mode_frequency is not None:
                lines.append(f"  first mode, {each.half}-return: {each.first_mode_frequency:.2f} Hz")
        return "\n".join(lines)

    @property
    def usable(self) -> bool:
        """Whether there is a cycle with measures."""
        return self.ending.usable

    @property
    def ending(self) -> Ending:
        """The status of the run."""
        return Ending(self.status)

    def measure(self, half: str, channel: str) -> EstimatedMeasure | None:
        """The measure of a half and channel, or None if there is none."""
        return next((found for found in self.measures if (found.half, found.channel) == (half, channel)), None)

    def consensus_of(self, half: str) -> EstimatedConsensus | None:
        """The consensus of a half on the first-mode frequency; None if there is none, or where it is not resolvable."""
        return next((found for found in self.consensus if found.half == half and found.first_mode_frequency is not None), None)

    def consensus_frequency(self, half: str) -> float | None:
        """Consensus of the first-mode frequency in a half, Hz, or None where not resolvable."""
        found = self.consensus_of(half)
        return None if found is None else found.first_mode_frequency

    def peak(self, channel: str) -> float:
        """Largest modulus of a channel over the cycle."""
        return float(np.max(np.abs(self.cycle[channel])))
