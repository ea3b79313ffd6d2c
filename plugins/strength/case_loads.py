"""Loads on the parts of a machine by each engine on a case, and how near a resonance it is."""

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np

from quickreturn.cases.comparison.engines import REFERENCE, CaseResult
from quickreturn.cases.files.case import Case
from quickreturn.cases.motion.resonance import Resonance, in_percent, resonance
from quickreturn.cases.motion.time_scale import TURN, time_scale
from quickreturn.plugins.strength.loads import Loads, loads_of_run
from quickreturn.plugins.strength.stress import ArmStress
from quickreturn.plugins.strength.words import Load, numbers
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.mechanism import Mechanism
from quickreturn.reference_model.rigid import mean_crank_speed
from quickreturn.reports.page.content import Content

#: Harmonics on either side of one that count as its own: the first mode's frequency changes over the turn and spreads vibrations over them.
BESIDE: Final = 2
#: Share of the tip's acceleration below which harmonics hardly drive the first mode. On the curves of run 24's machine (60 to 200 rpm,
#: orders 16 to 5) and of a pusher (119 to 161 rpm, orders 38 to 29) they raise a peak where they have 24 % or more at the speed at which
#: they meet the mode, and none with 23 % or less; halfway to the next such speed they have a seventh of that, or more.
HARDLY: Final = 0.02


@dataclass(frozen=True)
class CaseLoads:
    """The loads of a case by each engine."""

    result: CaseResult
    loads: Mapping[str, Loads]  # by engine, for those with a usable cycle

    @property
    def case(self) -> Case:
        """The case."""
        return self.result.case

    @cached_property
    def lead(self) -> str:
        """The engine whose numbers sentences give: `reference`, or else the first with a stress; "" if none has one, or if it is zero."""
        stressed = [name for name, loads in self.loads.items() if loads.stress is not None and loads.stress.largest.value > 0.0]
        return REFERENCE if REFERENCE in stressed else next(iter(stressed), "")

    @property
    def stress(self) -> ArmStress:
        """Stress along the arm by the leading engine, of which there must be one."""
        stress = self.loads[self.lead].stress
        assert stress is not None
        return stress

    @cached_property
    def resonance(self) -> Resonance | None:
        """The first mode beside the crank's frequency; None where there is no such mode."""
        return resonance(self.case.mechanism, self.result.settled_speed)

    @cached_property
    def shift_of_motion(self) -> float:
        """See `shift_of_motion`."""
        return shift_of_motion(self.case.mechanism)

    @cached_property
    def share(self) -> float | None:
        """See `share_of`: for the harmonic nearest to the first mode, by the leading engine."""
        return share_of(self.resonance.harmonic, self.result.runs[self.lead].cycle) if self.resonance and self.lead else None

    @property
    def nearness(self) -> str:
        """Which harmonic of the crank's speed is nearest, its effect, or the speed at which the two meet; "" if nothing vibrates."""
        if self.resonance is None:
            return ""
        if self.share is not None and self.share < HARDLY:
            return f"{self.resonance.nearest} and hardly drives it: {share_words(self.resonance.harmonic, self.share)}"
        known = "" if self.share is None else f"; {share_words(self.resonance.harmonic, self.share)}"
        return f"{self.resonance.sentence(self.case.units)}{known}"

    def departures(self) -> dict[str, float]:
        """Engine -> its largest stress over the leading engine's, minus one; without engines whose discretization is their model."""
        same = {name: loads for name, loads in self.loads.items() if self.result.runs[name].estimate_of != "integration"}
        stress = {name: loads.stress.largest.value for name, loads in same.items() if loads.stress is not None}
        lead = stress.pop(self.lead, 0.0)
        return {name: value / lead - 1.0 for name, value in stress.items()} if lead else {}


def loads_of_case(result: CaseResult, engines: Collection[str] | None = None) -> CaseLoads:
    """The loads of a case by each engine, or by some; recorded tables are left out, because they may lack the moments."""
    runs = {name: run for name, run in result.runs.items() if engines is None or name in engines}
    return CaseLoads(result, {name: loads for name, run in runs.items() if (loads := loads_of_run(result.case.mechanism, run))})


def loads_on(content: Content) -> list[CaseLoads]:
    """Loads on the parts of the user's own machines."""
    return [loads_of_case(result) for result in content.results] if content.is_own else []


def leading_loads(result: CaseResult) -> CaseLoads:
    """The loads of a case by the leading engine alone."""
    names = sorted(result.runs, key=lambda name: name != REFERENCE)
    return next((case for name in names if (case := loads_of_case(result, [name])).lead), CaseLoads(result, {}))


def numbers_of_case(case: CaseLoads) -> Iterator[tuple[str, Load]]:
    """All numbers of a case, each with its engine, or with "" where it needs none."""
    for engine, loads in case.loads.items():
        yield from ((engine, each) for each in numbers(loads))
    if case.resonance is not None:
        yield "", Load("mean_first_frequency", case.resonance.first_mode, "Hz", case.shift_of_motion)
        yield "", Load("frequency_ratio", case.resonance.ratio, "1", case.shift_of_motion / case.resonance.crank)


def share_of(order: int, cycle: Mapping[str, Array]) -> float | None:
    """Part of the tip's varying acceleration (RMS) that the harmonics within `BESIDE` of an order have in a settled turn.

    None where the turn has no such column, or fewer than four rows in a period of these harmonics.
    """
    time, rows = cycle["time"], cycle["time"].size - 1
    if "tip_acceleration" not in cycle or rows < 4 * (order + BESIDE):
        return None
    even = np.linspace(time[0], time[-1], rows, endpoint=False)
    amplitudes = np.abs(np.fft.rfft(np.interp(even, time, cycle["tip_acceleration"])))[1:-1]
    whole = float(np.linalg.norm(amplitudes))
    return float(np.linalg.norm(amplitudes[max(0, order - BESIDE - 1) : order + BESIDE])) / whole if whole else None


def share_words(order: int, share: float) -> str:
    """What the harmonics about an order make of the tip's acceleration (a clause)."""
    return f"harmonics {max(1, order - BESIDE)} to {order + BESIDE} make {in_percent(share)} % of the tip's acceleration"


def shift_of_motion(mechanism: Mechanism) -> float:
    """Amount, Hz, by which the mean first frequency with a turning, compliant crank differs from that with the crank held.

    To first order in the coupling of the modes (`cases.motion.moving_mode`); 0 where nothing vibrates.
    """
    scale = time_scale(mechanism)
    if scale is None:
        return 0.0
    angles = TURN[:-1]
    running = scale.running_frequencies(angles, np.full(angles.size, abs(mean_crank_speed(mechanism))))[:, 0]
    return abs(float(np.mean(running - scale.frequencies(angles)[:, 0])))
