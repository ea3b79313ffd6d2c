"""What happens in a turn: sentences with their numbers, each read off one engine's settled motion of a machine.

Each function of `SENTENCES` says something, or nothing: for want of a column, or where the claim of its number is as large as the number.
"""

import math
import os
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Final

import numpy as np

from quickreturn.arguments import AnyCase, one_case
from quickreturn.cases.files.case import Case
from quickreturn.cases.files.shown import Cell, Printable
from quickreturn.cases.motion.catalogue import MEASURES
from quickreturn.cases.motion.cycle import HALVES
from quickreturn.cases.motion.endings import Ending
from quickreturn.cases.motion.measure import SettledMotion
from quickreturn.cases.motion.number import Number
from quickreturn.cases.motion.request import Run
from quickreturn.cases.motion.resonance import Resonance, resonance
from quickreturn.cases.motion.time_scale import quasi_static_strain
from quickreturn.cross_validation import run as settled_runs
from quickreturn.engines.trajectory import rms
from quickreturn.plugins.strength.case_loads import HARDLY, share_of, share_words, shift_of_motion
from quickreturn.plugins.strength.loads import loads_in
from quickreturn.plugins.strength.words import from_p, tension_or_compression
from quickreturn.reports.words import TIED, counted, degrees, in_words, listed, number, off_by, percent, quantity, size

#: Relative difference of the strokes' durations below which they count as alike.
ALIKE: Final = 0.01
#: Largest number of angles that are listed.
MOST_ANGLES: Final = 6
#: Part of the strain that may be none of the rigid motion's where the stress is taken to grow as the square of the speed.
STILL: Final = 0.1
#: Half of a turn -> when that is.
WHEN: Final = {"pre": "before", "post": "after"}
#: What is left of a disturbance that counts as gone.
GONE: Final = 0.01

#: A sentence, and the numbers in it by name, SI; the claimed error of NAME is NAME_error.
Said = tuple[str, dict[str, float]]


@dataclass(frozen=True)
class Statement:
    """A sentence on a turn."""

    topic: str  # key of `SENTENCES`
    sentence: str
    numbers: Mapping[str, float]  # in it, SI


@dataclass(frozen=True)
class Turn:
    """A settled turn of a machine by one engine."""

    case: Case
    run: Run

    @cached_property
    def motion(self) -> SettledMotion:
        """The motion that the catalogue's measures take."""
        return SettledMotion(self.case.mechanism, self.run)

    @cached_property
    def resonance(self) -> Resonance | None:
        """The first mode beside the crank's frequency in this turn."""
        return resonance(self.case.mechanism, self.run.mean_crank_speed)

    def of(self, measure: str) -> Number | None:
        """A measure of the catalogue; None if there is none, or if its claim leaves nothing of it."""
        found = MEASURES[measure].of(self.motion)
        return found if math.isfinite(found.value) and not found.error >= abs(found.value) else None

    def told(self, found: Number, si: str) -> str:
        """A number with its error."""
        error = "error unknown" if math.isnan(found.error) else off_by(found.error, found.value)
        return f"{self.shown(found.value, si)} ({error})"

    def shown(self, value: float, si: str) -> str:
        """A number in the case's units."""
        return quantity(value, self.case.units.of(si))


def _numbers(name: str, found: Number) -> dict[str, float]:
    """A measure with its error, and the crank angle at which it is reached, if it has one."""
    at = {} if found.crank_angle is None else {"crank_angle": found.crank_angle}
    return {name: found.value, f"{name}_error": found.error} | at


def _as_much(turn: Turn, column: str, found: Number) -> str:
    """A clause on the place where a column is as large the other way, within the errors; "" if there is none."""
    other = min(turn.motion.extremes(column), key=lambda each: abs(each.value))
    alike = abs(found.value) - abs(other.value) <= found.error + other.error
    return f"; as large the other way, within the error, at {degrees(other.crank_angle)}" if alike and other.crank_angle is not None else ""


def whip(turn: Turn) -> Said | None:
    """When the tip is accelerated most, relative to the quick return."""
    found, angle = turn.of("peak.tip_acceleration"), turn.run.cycle["crank_angle"]
    if found is None or found.crank_angle is None:
        return None
    off = math.copysign(math.remainder(found.crank_angle, 2.0 * math.pi), 1.0)
    late = (math.remainder(found.crank_angle, 2.0 * math.pi) > 0.0) == (angle[-1] > angle[0])
    beyond = off - turn.case.mechanism.half_return
    where = f"in the quick return, {degrees(off)} {'after' if late else 'before'} its middle"
    if beyond > 0.0:
        where = f"{degrees(beyond)} {'after the quick return has ended' if late else 'before the quick return begins'}"
    sentence = f"The tip is accelerated most with the crank at {degrees(found.crank_angle)}, {where}: {turn.told(found, 'm/s^2')}"
    sentence = f"{sentence}{_as_much(turn, 'tip_acceleration', found)}."
    return sentence, _numbers("tip_acceleration", found) | {"from_middle_of_return": off if late else -off}


def strokes(turn: Turn) -> Said | None:
    """How long the two strokes take."""
    period, cycle = turn.of("period"), turn.run.cycle
    if period is None:
        return None
    mechanism, turned = turn.case.mechanism, np.abs(cycle["crank_angle"] - cycle["crank_angle"][0])
    ends = math.pi - mechanism.half_return, math.pi + mechanism.half_return
    back = float(np.diff(np.interp(ends, turned, cycle["time"]))[0])
    work = period.value - back
    lengths, numbers = f"{turn.shown(work, 's')} and {turn.shown(back, 's')}", {"working_time": work, "return_time": back}
    if abs(work / back - 1.0) < ALIKE:
        return f"The working stroke and the return take the same time to {percent(ALIKE, '.0f')}: {lengths}.", numbers
    longer = f"takes {number(work / back, '.2f')} times as long as"
    if mechanism.turns_fully:
        return f"The arm turns fully, and the slow half of its turn {longer} the fast one, the return: {lengths}.", numbers
    return f"The working stroke {longer} the return: {lengths}.", numbers


def sides(turn: Turn) -> Said | None:
    """Where the slider changes from one side of the arm to the other, as far as the force exceeds its claim."""
    if "slider_force" not in turn.run.cycle:
        return None
    force, angle = (turn.run.cycle[name][:-1] for name in ("slider_force", "crank_angle"))
    claims = [turn.motion.claim("slider_force", float(each)) for each in angle[[0, -1]]]
    claim = max((each for each in claims if each is not None), default=0.0)
    sure = np.flatnonzero(np.abs(force) > claim)
    if not sure.size:
        return None
    before, whole = np.roll(sure, 1), math.copysign(2.0 * math.pi, angle[-1] - angle[0])
    angles = []
    for one, other in zip(before, sure, strict=True):
        if force[one] * force[other] < 0.0:
            step = angle[other] - angle[one] + (whole if other <= one else 0.0)
            angles.append(float(angle[one] + step * abs(force[one]) / (abs(force[one]) + abs(force[other]))) % (2.0 * math.pi))
    numbers = {"changes": float(len(angles)), "slider_force_error": claim} | {f"at_{k}": each for k, each in enumerate(sorted(angles), 1)}
    if not angles:
        least = float(np.min(np.abs(force)))
        by = f", with {turn.shown(least, 'N')} or more" if least > 2.0 * claim else ""
        return f"The slider presses on the same side of the arm throughout the turn{by}.", numbers
    often = {1: "once", 2: "twice"}.get(len(angles), f"{in_words(len(angles))} times")
    first = "first " if len(angles) > MOST_ANGLES else ""
    places = listed([degrees(each) for each in sorted(angles)[:MOST_ANGLES]])
    return f"The slider's force changes sign {often}, {first}with the crank at {places}: there a slider with clearance knocks.", numbers


def stress(turn: Turn) -> Said | None:
    """Where and when bending stresses the arm most."""
    found = turn.of("peak.stress")
    if found is None or found.place is None or found.crank_angle is None:
        return None
    where = f"{from_p(found, turn.case.units)}, at {percent(found.place / turn.case.mechanism.follower.length, '.0f')} of its length"
    motion = turn.motion.of(loads_in).stress
    ends = [abs(float(np.interp(found.place, motion.places, end))) for end in (motion.lowest, motion.highest)] if motion else []
    either = " (bent the other way as much, within the error)" if ends and max(ends) - min(ends) <= 2.0 * found.error else ""
    axial = motion.axial if motion and not either else None
    kind = "" if axial is None else f" in {tension_or_compression(axial)}"
    sentence = f"The arm is stressed most {where}, with the crank at {degrees(found.crank_angle)}{either}{kind}: {turn.told(found, 'Pa')}."
    return sentence, _numbers("stress", found) | {"place": found.place}


def ringing(turn: Turn) -> Said | None:
    """How much the first mode rings, and which multiple of the crank's speed is nearest to it."""
    first = turn.resonance
    if first is None:
        return ("Nothing rings: the arm is rigid.", {}) if turn.case.mechanism.follower.is_rigid else None
    numbers = {"first_mode": first.first_mode, "harmonic": float(first.harmonic), "detuning": first.detuning}
    mean, away = turn.shown(first.first_mode, "Hz"), size(first.detuning)
    near = f"{first.harmonic} times the crank's speed is nearest to its mean frequency, {mean} with the crank held: {away} off"
    share = share_of(first.harmonic, turn.run.cycle)
    if share is not None:
        hardly = ", which is next to nothing" if share < HARDLY else ""
        near, numbers["share"] = f"{near}; {share_words(first.harmonic, share)}{hardly}", share
    amplitudes = {half: turn.of(f"{half}.amplitude.tip_acceleration") for half in HALVES}
    known = {half: found for half, found in amplitudes.items() if found is not None}
    if not known:
        return f"The size of the first mode's ringing cannot be fitted, which is neither good nor bad; {near}.", numbers
    half = max(known, key=lambda each: known[each].value)
    loudest = f"The first mode rings most {WHEN[half]} the return, with {turn.told(known[half], 'm/s^2')} at the tip (RMS of the envelope)"
    return f"{loudest}; {near}.", numbers | _numbers("amplitude", known[half])


def drive(turn: Turn) -> Said | None:
    """What the drive must give, and what it takes back."""
    found, given, back = (turn.of(name) for name in ("peak.crank_torque", "turn.driven_energy", "turn.returned_energy"))
    if found is None or found.crank_angle is None:
        return None
    least, most = (turn.of(f"{end}.crank_torque") for end in ("min", "max"))
    if turn.case.mechanism.crank_is_free and least and most:
        mean, power = (turn.of(name) for name in ("mean.crank_torque", "mean.drive_power"))
        means = listed([turn.told(each, si) for each, si in ((mean, "N*m"), (power, "W")) if each])
        span = f"goes from {turn.told(least, 'N*m')} to {turn.told(most, 'N*m')}"
        how = f"is constant, {turn.shown(found.value, 'N*m')}" if least.value == most.value else span
        return f"The torque of the drive at the crank's shaft {how}; in the mean it gives {means}.", _numbers("torque", found)
    numbers, energy = _numbers("torque", found), ""
    if given is not None:
        numbers |= _numbers("energy_given", given) | (_numbers("energy_back", back) if back else {})
        returned = f"{turn.told(back, 'J')} of it comes back" if back else "none of it comes back"
        energy = f"; it gives {turn.told(given, 'J')} in a turn, {returned}"
    largest = f"{turn.told(found, 'N*m')}{_as_much(turn, 'crank_torque', found)}"
    return f"The torque of the drive is largest with the crank at {degrees(found.crank_angle)}: {largest}{energy}.", numbers


def bearings(turn: Turn) -> Said | None:
    """The largest forces of the two bearings."""
    found = {"P of the arm": turn.of("peak.pivot_force"), "O of the crank": turn.of("peak.crank_force")}
    known = {name: each for name, each in found.items() if each is not None}
    texts = [f"{name} {turn.told(each, 'N')}" for name, each in known.items()]
    numbers = {f"{name[0]}_{key}": value for name, each in known.items() for key, value in _numbers("force", each).items()}
    return (f"The bearings must bear up to: {listed(texts)}.", numbers) if known else None


def decay(turn: Turn) -> Said | None:
    """How fast a disturbance dies away."""
    found = MEASURES["multiplier"].of(turn.motion)
    if not math.isfinite(found.value + found.error):
        return None
    numbers, high = _numbers("multiplier", found), found.value + found.error
    if found.value - found.error > 1.0:
        return f"A disturbance grows {number(found.value, '.3g')}-fold in a turn: the machine leaves this motion.", numbers
    if high >= 1.0:
        return "A disturbance neither grows nor dies away within the error.", numbers
    if found.error >= found.value:
        return f"A disturbance dies away within a turn, to less than {percent(math.ceil(1e4 * high) / 1e4, 'g')}.", numbers
    turns = counted(max(1, math.ceil(math.log(GONE) / math.log(high))), "turn")
    of = "of the crank's speed or of the two lowest modes" if turn.case.mechanism.crank_is_free else "of the two lowest modes"
    left = f"{percent(found.value, '.2g')} of a disturbance {of} is left after a turn"
    return f"{left} ({off_by(found.error, found.value)}), less than {percent(GONE, 'g')} after {turns}.", numbers


def limit(turn: Turn) -> Said | None:
    """The next resonance at a higher speed, and whether the stress grows as the square of the speed until there."""
    mechanism, first = turn.case.mechanism, turn.resonance
    if first is None:
        return None
    claim = shift_of_motion(mechanism) / first.crank
    order = math.ceil(first.ratio - claim) - 1
    if order < 1:
        return "At higher speeds no multiple of the crank's speed meets the first mode.", {"ratio": first.ratio, "ratio_error": claim}
    speed, faster = 2.0 * math.pi * first.first_mode / order, first.ratio / order - 1.0
    numbers = {"resonant_speed": speed, "faster": faster, "faster_error": claim / order, "order": float(order)}
    meets = f"at {turn.shown(speed, 'rad/s')}, {size(faster)} faster, {order} times the crank's speed meets the first mode's frequency"
    share, growth = share_of(order, turn.run.cycle), _growth(turn, numbers)
    if share is None:
        return f"The next resonance upwards: {meets} with the crank held (the higher that number, the weaker); {growth}.", numbers
    numbers["share"] = share
    if share < HARDLY:
        return f"No resonance is near at higher speeds: {meets}, but hardly drives it: {share_words(order, share)}; {growth}.", numbers
    return f"The next resonance upwards: {meets} with the crank held; here {share_words(order, share)}; {growth}.", numbers


def _growth(turn: Turn, numbers: dict[str, float]) -> str:
    """Whether the stress grows as the square of the speed (a clause), by the strain at mid-arm beside that of the rigid motion."""
    mechanism, cycle = turn.case.mechanism, turn.run.cycle
    if any(mechanism.gravity) or mechanism.tip_body.is_forced or mechanism.tip_body.friction_force:
        return "the stress does not grow as the square of the speed, for gravity or the force on the tip bends the arm at any speed"
    rigid = quasi_static_strain(mechanism, mechanism.follower.strain_gauges[1], cycle["crank_angle"]) * cycle["crank_speed"] ** 2
    numbers["vibration"] = share = rms(cycle["strain_2"] - rigid) / rms(rigid)
    verb = "grows about" if share < STILL else "does not simply grow"
    basis = f"the strain at mid-arm differs by {size(share)} from that of the rigid motion's inertia"
    return f"between resonances the stress {verb} as the square of the speed, for {basis}"


def trust(turn: Turn) -> Said:
    """How far all of this is to be trusted."""
    run, error = turn.run, turn.run.computation.error_estimate
    what = "place" if turn.case.mechanism.follower.is_rigid else "deflection"
    estimate = "does not know its error" if error is None else f"estimates its error at {size(error)} of the tip's {what}"
    of = " by its integration alone, not its model" if run.estimate_of == "integration" else ""
    missed = ", which misses the accuracy asked" if run.status == Ending.INACCURATE else ""
    basis = "they are as good as the damping, the joint and the drive of the case file, and as a plane, slender arm"
    return f"The numbers are those of {run.engine}, which {estimate}{of}{missed}; {basis}.", {} if error is None else {"error": error}


#: Topic -> what is said of it.
SENTENCES: Final[Mapping[str, Callable[[Turn], Said | None]]] = {
    each.__name__: each for each in (whip, strokes, sides, stress, ringing, drive, bearings, decay, limit, trust)
}


def statements(case: Case, run: Run) -> list[Statement]:
    """What happens in a turn of a case by the run of an engine; nothing where it has no settled turn."""
    turn = Turn(case, run)
    said = {topic: say(turn) for topic, say in SENTENCES.items()} if run.usable else {}
    return [Statement(topic, each[0].replace(TIED, " "), each[1]) for topic, each in said.items() if each]


@dataclass(frozen=True, repr=False)
class Explanation(Printable):
    """What happens in a turn of a machine in its steady state.

    Attributes:
        case: name of the machine.
        title: its title.
        run: the run of the engine from which the sentences are read.
        statements: sentences with topic and numbers (SI); none if the run has no settled turn.
    """

    case: str
    title: str
    run: Run
    statements: tuple[Statement, ...]

    def _parts(self) -> Iterator[Cell]:
        yield f"{self.case}: {self.title}"
        yield from (f"- {each.sentence}" for each in self.statements)


def explain(
    case: AnyCase,
    engine: str | os.PathLike[str] = "reference",
    *,
    accuracy: float | None = None,
    settings: Mapping[str, Any] | None = None,
    quiet: bool = False,
) -> Explanation:
    """Say what happens in a turn of a machine in its steady state; the run is that of `qr.run`, from the store if it is there.

    Args:
        case: a name, a path or a `Case`.
        engine: name, or path of a file that declares one.
        accuracy: relative error of the tip deflection asked for; None: the engine's default.
        settings: settings of the engine, by name.
        quiet: whether progress on standard error is left out.

    Raises:
        CaseError, UnknownEngine, Refusal, SettingError, StoreError, KeyboardInterrupt: as `run`.
    """
    chosen, name = one_case(case), os.fspath(engine)
    found = settled_runs([chosen], [name], accuracy=accuracy, settings={name: settings or {}}, quiet=quiet)[chosen.name, name]
    return Explanation(chosen.name, chosen.title, found, tuple(statements(chosen, found)))
