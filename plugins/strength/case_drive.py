"""What motor, flywheel and bearings of the user's machine are chosen by: numbers by each engine, sentences on them, and the chapter."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from quickreturn.cases.comparison.engines import REFERENCE, CaseResult
from quickreturn.cases.files.case import Case
from quickreturn.cases.files.shown import Unit, Units
from quickreturn.cases.motion.catalogue import MEASURES, numbers
from quickreturn.cases.motion.number import NO_NUMBER, Number
from quickreturn.cases.motion.request import Run
from quickreturn.plugins.strength.measures import EXPONENTS, HARMONICS
from quickreturn.reports.page.chapter import Chapter, Plot, Series
from quickreturn.reports.page.content import Content
from quickreturn.reports.tables import CASE, Cell, Column, Table
from quickreturn.reports.words import TIED, degrees, listed, off_by, percent, quantity

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
#: Number of steps of a closed curve of a bearing's force, and of crank angles that are written at it.
POINTS: Final = 180
MARKED: Final = 4
#: Force -> its bearing.
BEARINGS: Final = {"pivot_force": "P", "crank_force": "O"}


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


def drive(content: Content) -> Chapter | None:
    """The chapter; None for a report on the thesis' runs, or if no engine gives the torque of the drive."""
    cases = [each for each in map(drive_of, content.results if content.is_own else ()) if each.lead]
    if not cases:
        return None
    sections = [
        {
            "title": each.case.title,
            "flywheel": "" if each.case.mechanism.crank_is_free else drive_sentences(each)[1],
            "harmonics": harmonics_plot(each),
            "forces": {bearing: plot for force, bearing in BEARINGS.items() if (plot := force_plot(each, force))},
        }
        for each in cases
    ]
    facts = {"sections": sections, "table": drive_table(cases), "forces": forces_table(cases)}
    return Chapter("drive", "Which motor, which bearings?", finding(cases), facts)


def finding(cases: Sequence[CaseDrive]) -> str:
    """Power of the drive, and equivalent loads of ball bearings, of the first machine."""
    case = cases[0]
    found = case.numbers(case.lead)
    mean, most = (text_of(name, found[name], case.case.units) for name in ("mean.drive_power", "peak.drive_power"))
    loads = {f"equivalent.{force}.ball": bearing for force, bearing in BEARINGS.items()}
    texts = [f"{text_of(name, found[name], case.case.units)} at {bearing}" for name, bearing in loads.items() if name in found]
    text = f"{mean} in the mean, {most} at most"
    text += f"; equivalent loads {' and '.join(texts)}" if texts else ""
    return f"{case.case.name}: {text}" if len(cases) > 1 else text


def drive_table(cases: Sequence[CaseDrive]) -> Table:
    """All numbers of all cases, with columns for each engine; without the fluctuation that a prescribed speed does not have."""
    engines = dict.fromkeys(engine for case in cases for engine in case.runs)
    columns = [Column(f"{engine}{end}", unit="[SI]", form=".4g", in_page=not end) for engine in engines for end in ("", "_error")]
    table = Table(
        "drive",
        """What motor, flywheel and bearings must bear in a steady turn, by each engine; errors are its own estimate and that by the rows.
        Harmonic n of the torque is A cos(n q₁ − φ), with amplitude A and phase φ, over the crank angle q₁.""",
        (CASE, Column("quantity", words=NAMES.__getitem__), *columns, Column("unit", in_page=False)),
    )
    for case in cases:
        found = {engine: case.numbers(engine) for engine in case.runs}
        for name in NAMES:
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


def harmonics_plot(case: CaseDrive) -> Plot | None:
    """Bars of the amplitudes; None where the torque is constant."""
    series, unit = [], case.case.units.of("N*m")
    for engine in case.runs:
        found = case.numbers(engine)
        amplitudes = {order: one for order in range(1, HARMONICS + 1) if (one := found.get(f"torque.harmonic_{order}"))}
        texts = [f"harmonic {order}, {quantity(one.value, unit)}" for order, one in amplitudes.items()]
        sizes = [one.value / unit.size for one in amplitudes.values()]
        series += [Series(engine, engine, [*amplitudes], sizes, texts, line=False, marked=False, columns=True)] if sizes else []
    return Plot("drive.csv", "harmonic of the crank’s turn", f"amplitude [{unit.sign}]", series) if series else None


def force_plot(case: CaseDrive, force: str) -> Plot | None:
    """The end of the force's arrow over a turn, by each engine; crank angles are written at the leading engine's. None without forces."""
    series, unit = [], case.case.units.of("N")
    for engine, run in case.runs.items():
        if found := _force(run, force, POINTS + 1):
            texts = [f"crank at {degrees(a)}, {quantity(math.hypot(x, y), unit)}" for a, x, y in zip(*found, strict=True)]
            x, y = ((part / unit.size).tolist() for part in found[1:])
            series.append(Series(engine, engine, x, y, texts, marked=False))
    if found := _force(case.runs[case.lead], force, MARKED + 1):
        angles = [degrees(angle) for angle in found[0][1:]]
        x, y = ((part[1:] / unit.size).tolist() for part in found[1:])
        series.append(Series("crank angle", case.lead, x, y, angles, line=False, labels=angles))
    return Plot("bearing_forces.csv", f"along n₁ [{unit.sign}]", f"along n₂ [{unit.sign}]", series, alike=True) if series else None


def _force(run: Run, force: str, points: int) -> Sequence[np.ndarray]:
    """Crank angle and both parts of a bearing's force at even angles of the turn, both ends among them; empty without the force."""
    cycle, names = run.cycle, (f"{force}_x", f"{force}_y")
    if not {*names} <= cycle.keys():
        return ()
    angle = cycle["crank_angle"]
    even = np.linspace(angle[0], angle[-1], points)
    turning = np.sign(even[-1] - even[0])
    return even, *(np.interp(turning * even, turning * angle, cycle[name]) for name in names)


def forces_table(cases: Sequence[CaseDrive]) -> Table:
    """The forces in the plots."""
    table = Table(
        "bearing_forces",
        "Forces of the ground in the bearings: on the arm at P, and on the crank at O, along n₁ (from O to P) and n₂.",
        (
            CASE,
            "engine",
            "bearing",
            Column("crank_angle", unit="°", form=".0f"),
            Column("along_n1", unit="N", form=".4g"),
            Column("along_n2", unit="N", form=".4g"),
        ),
        in_page=False,
    )
    for case in cases:
        for engine, run in case.runs.items():
            for force, bearing in BEARINGS.items():
                for angle, x, y in zip(*_force(run, force, POINTS + 1), strict=True):
                    where = {"case": case.case.name, "engine": engine, "bearing": bearing}
                    table.add(where | {"crank_angle": float(angle), "along_n1": float(x), "along_n2": float(y)})
    return table
