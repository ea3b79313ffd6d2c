"""What motor, flywheel and bearings of a machine are chosen by: numbers by each engine, and sentences on those of the leading one."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from quickreturn.cases.comparison.engines import REFERENCE, CaseResult
from quickreturn.cases.files.case import Case
from quickreturn.cases.files.shown import Unit, Units
from quickreturn.cases.motion.catalogue import MEASURES, numbers
from quickreturn.cases.motion.number import NO_NUMBER, Number
from quickreturn.cases.motion.request import Run
from quickreturn.plugins.strength.drive import EXPONENTS, HARMONICS
from quickreturn.reports.words import TIED, listed, off_by, percent, quantity

#: Measure -> its name in the page.
NAMES: Final = {
    "mean.crank_torque": "mean torque of the drive",
    "rms.crank_torque": "RMS of the torque",
    "peak.crank_torque": "largest torque",
    "mean.drive_power": "mean power of the drive",
    "rms.drive_power": "RMS of the power",
    "peak.drive_power": "largest power to the machine",
    "peak.returned_power": "largest power that comes back",
    "turn.driven_energy": "energy to the machine in a turn",
    "turn.returned_energy": "energy that comes back in a turn",
    "variation.crank_speed": "fluctuation of the crank’s speed",
    "flywheel.energy": "energy fluctuation of the torque",
    "flywheel.inertia": "inertia of crank and flywheel for the wanted fluctuation",
    "turn.pivot_angle": "angle that the bearing P turns in a turn of the crank",
    **{
        f"equivalent.{force}.{kind}": f"equivalent load of {where}, {kind} bearing"
        for force, where in (("pivot_force", "P"), ("crank_force", "O"), ("slider_force", "the slider’s pin"))
        for kind in EXPONENTS
    },
    **{
        f"torque.harmonic_{order}{end}": f"{part} of harmonic {order} of the torque"
        for order in range(1, HARMONICS + 1)
        for end, part in (("", "amplitude"), (".phase", "phase"))
    },
}


@dataclass(frozen=True)
class CaseDrive:
    """The numbers of a case by each engine that gives the torque of the drive."""

    case: Case
    runs: Mapping[str, Run]  # by engine

    @property
    def lead(self) -> str:
        """The engine whose numbers the sentences give: `reference`, or else the first; "" if there is none."""
        return REFERENCE if REFERENCE in self.runs else next(iter(self.runs), "")

    def numbers(self, engine: str) -> dict[str, Number]:
        """Numbers of an engine by measure; those that the motion has."""
        found = numbers(self.case.mechanism, self.runs[engine], NAMES)
        return {name: number for name, number in found.items() if not math.isnan(number.value)}


def drive_of(result: CaseResult) -> CaseDrive:
    """A case with its usable runs that have the torque; recorded tables are left out, because they may lack the other columns."""
    return CaseDrive(result.case, {name: run for name, run in result.runs.items() if run.usable and "crank_torque" in run.cycle})


def drive_sentences(drive: CaseDrive) -> list[str]:
    """What motor, flywheel and bearings must bear, by the leading engine; nothing without one."""
    if not drive.lead:
        return []
    found = drive.numbers(drive.lead)
    texts = {name: text_of(name, number, drive.case.units) for name, number in found.items()}
    needed = found.get("flywheel.inertia", NO_NUMBER).value
    return list(filter(None, (_motor(drive.case, texts), _flywheel(drive.case, texts, needed), _bearings(drive.case, texts))))


def text_of(name: str, number: Number, units: Units, *, with_error: bool = False) -> str:
    """A number of `NAMES` in its unit, 0 if it is zero within its error. The error is relative; in the unit if as large, or of an angle."""
    si, lost = MEASURES[name].unit, abs(number.value) <= number.error
    unit = Unit("%", 0.01) if si == "1" else units.of(si)
    text = f"0{TIED}{unit.sign}" if lost else quantity(number.value, unit)
    if with_error:
        in_unit = lost or (si == "rad" and not math.isnan(number.error))
        error = f"±{TIED}{quantity(number.error, unit)}" if in_unit else off_by(number.error, number.value)
        text += f" ({'error unknown' if math.isnan(number.error) else error})"
    return text.replace(f"{TIED}deg", "°")


def _motor(case: Case, texts: Mapping[str, str]) -> str:
    power = f"{texts['mean.drive_power']} in the mean and {texts['peak.drive_power']} at most"
    if case.mechanism.crank_is_free:
        less = "the constant torque less crank.damping times the speed"
        return f"At the shaft the drive gives {texts['mean.crank_torque']} in the mean, {less}; its power is {power}."
    return (
        f"The torque of the drive is {texts['mean.crank_torque']} in the mean, {texts['rms.crank_torque']} RMS and"
        f" {texts['peak.crank_torque']} at most; its power is {power}. In a turn {texts['turn.driven_energy']} go to the machine and"
        f" {texts['turn.returned_energy']} come back, at {texts['peak.returned_power']} at most."
    )


def _flywheel(case: Case, texts: Mapping[str, str], needed: float) -> str:
    crank = case.mechanism.crank
    if case.mechanism.crank_is_free:
        return f"The speed of the crank fluctuates by {texts['variation.crank_speed']} of its mean, from the least to the largest."
    energy = f"With a motor of constant torque, crank and flywheel store and release {texts['flywheel.energy']} in a turn"
    if crank.wanted_fluctuation is None:
        return f"{energy}; with crank.wanted_fluctuation in the case file, this says what inertia they need."
    wanted, has = percent(crank.wanted_fluctuation, ".3g"), quantity(case.mechanism.crank_inertia, case.units.of("kg*m^2"))
    alone = ", which is enough" if case.mechanism.crank_inertia >= needed else ""
    return (
        f"{energy}. For a speed whose range is {wanted} of its mean they need an inertia of {texts['flywheel.inertia']} about O together;"
        f" the crank has {has}{alone}."
    )


def _bearings(case: Case, texts: Mapping[str, str]) -> str:
    loads = [
        f"{texts[ball]} {where} ({texts[ball.replace('ball', 'roller')]} with rollers)"
        for ball, where in (("equivalent.pivot_force.ball", "at P"), ("equivalent.crank_force.ball", "at O"))
        if ball in texts
    ]
    if not loads:
        return ""
    swing = f"P turns by {texts['turn.pivot_angle']} in a turn of the crank{'' if case.mechanism.turns_fully else ', to and fro'}"
    return f"Ball bearings are chosen by an equivalent load of {listed(loads)}; {swing}."
