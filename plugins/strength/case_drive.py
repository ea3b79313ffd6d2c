"""What motor, flywheel and bearings of the user's machine are chosen by: numbers by each engine, sentences on them, and the chapter."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Final

from quickreturn.cases.comparison.engines import REFERENCE, CaseResult
from quickreturn.cases.files.case import Case
from quickreturn.cases.files.shown import Unit, Units
from quickreturn.cases.motion.catalogue import MEASURES, numbers
from quickreturn.cases.motion.number import NO_NUMBER, Number
from quickreturn.cases.motion.request import Run
from quickreturn.plugins.strength.measures import EXPONENTS, HARMONICS
from quickreturn.reports.page.chapter import Chapter
from quickreturn.reports.page.content import Content
from quickreturn.reports.tables import CASE, Cell, Column, Table
from quickreturn.reports.words import TIED, listed, off_by, percent, quantity

#: Force -> its bearing.
BEARINGS: Final = {"pivot_force": "P", "crank_force": "O"}
#: The measures by which motor, flywheel and bearings are chosen.
CHOSEN_BY: Final = (
    *("mean.crank_torque", "rms.crank_torque", "peak.crank_torque", "mean.drive_power", "rms.drive_power", "peak.drive_power"),
    *("peak.returned_power", "turn.driven_energy", "turn.returned_energy", "variation.crank_speed", "flywheel.energy"),
    *("flywheel.inertia", "turn.pivot_angle"),
    *(f"equivalent.{force}.{kind}" for force in (*BEARINGS, "slider_force") for kind in EXPONENTS),
    *(f"torque.harmonic_{order}{end}" for order in range(1, HARMONICS + 1) for end in ("", ".phase")),
)


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
        found = numbers(self.case.mechanism, self.runs[engine], CHOSEN_BY)
        return {name: number for name, number in found.items() if not math.isnan(number.value)}

    @cached_property
    def texts(self) -> dict[str, str]:
        """The numbers of the leading engine in words."""
        return {name: text_of(name, number, self.case.units) for name, number in self.numbers(self.lead).items()}


def drive_of(result: CaseResult) -> CaseDrive:
    """A case with its usable runs that have the torque; recorded tables are left out, because they may lack the other columns."""
    return CaseDrive(result.case, {name: run for name, run in result.runs.items() if run.usable and "crank_torque" in run.cycle})


def drive_sentences(drive: CaseDrive) -> list[str]:
    """What motor, flywheel and bearings must bear, by the leading engine; nothing without one."""
    if not drive.lead:
        return []
    needed = drive.numbers(drive.lead).get("flywheel.inertia", NO_NUMBER).value
    return list(
        filter(None, (_motor(drive.case, drive.texts), _flywheel(drive.case, drive.texts, needed), _bearings(drive.case, drive.texts)))
    )


def text_of(name: str, number: Number, units: Units, *, with_error: bool = False) -> str:
    """A measure in its unit, 0 if it is zero within its error. The error is relative; in the unit if as large, or of an angle."""
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
        f"{texts[ball]} at {where} ({texts[ball.replace('ball', 'roller')]} with rollers)"
        for force, where in BEARINGS.items()
        if (ball := f"equivalent.{force}.ball") in texts
    ]
    if not loads:
        return ""
    swing = f"P turns by {texts['turn.pivot_angle']} in a turn of the crank{'' if case.mechanism.turns_fully else ', to and fro'}"
    return f"Ball bearings are chosen by an equivalent load of {listed(loads)}; {swing}."


def drive(content: Content) -> Chapter | None:
    """The chapter; None for a report on the thesis' runs, or if no engine gives the torque of the drive."""
    cases = [each for each in map(drive_of, content.results if content.is_own else ()) if each.lead]
    if not cases:
        return None
    facts = {"cases": [(each.case.title, drive_sentences(each)) for each in cases], "table": drive_table(cases)}
    return Chapter("drive", "Which motor, which bearings?", finding(cases), facts)


def finding(cases: Sequence[CaseDrive]) -> str:
    """Power of the drive, and equivalent loads of ball bearings, of the first machine."""
    case, texts = cases[0].case, cases[0].texts
    loads = [f"{texts[name]} at {bearing}" for force, bearing in BEARINGS.items() if (name := f"equivalent.{force}.ball") in texts]
    text = f"{texts['mean.drive_power']} in the mean, {texts['peak.drive_power']} at most"
    text += f"; equivalent loads {' and '.join(loads)}" if loads else ""
    return f"{case.name}: {text}" if len(cases) > 1 else text


def drive_table(cases: Sequence[CaseDrive]) -> Table:
    """All numbers of all cases, with columns for each engine; without the fluctuation that a prescribed speed does not have."""
    engines = dict.fromkeys(engine for case in cases for engine in case.runs)
    columns = [Column(f"{engine}{end}", unit="[SI]", form=".4g", in_page=not end) for engine in engines for end in ("", "_error")]
    table = Table(
        "drive",
        """What motor, flywheel and bearings must bear in a steady turn, by each engine; errors are its own estimate and that by the rows.
        Harmonic n of the torque is A cos(n q₁ − φ), with amplitude A and phase φ, over the crank angle q₁.""",
        (CASE, Column("quantity", words=lambda name: MEASURES[name].meaning), *columns, Column("unit", in_page=False)),
    )
    for case in cases:
        found = {engine: case.numbers(engine) for engine in case.runs}
        for name in CHOSEN_BY:
            cells: dict[str, Cell] = {}
            for engine, by_measure in found.items():
                if (one := by_measure.get(name)) and (one.value or one.error):
                    cells |= {
                        engine: Cell(one.value, text_of(name, one, case.case.units, with_error=True)),
                        f"{engine}_error": Cell(one.error),
                    }
            if cells:
                table.add(case=case.case.name, quantity=name, unit=MEASURES[name].unit, **cells)
    return table
