"""Which motor, which bearings? Torque and power of the drive, the flywheel, and the bearings' forces of the user's own machine."""

import math
from collections.abc import Sequence
from typing import Final

import numpy as np

from quickreturn.cases.motion.catalogue import MEASURES
from quickreturn.cases.motion.request import Run
from quickreturn.plugins.strength.case_drive import NAMES, CaseDrive, drive_of, drive_sentences, text_of
from quickreturn.plugins.strength.drive import HARMONICS
from quickreturn.reports.page.chapter import Chapter
from quickreturn.reports.page.content import Content
from quickreturn.reports.page.plot import Plot, Series
from quickreturn.reports.tables.cells import CASE
from quickreturn.reports.tables.table import Cell, Column, Table
from quickreturn.reports.words import degrees, quantity

#: Number of steps of a closed curve of a bearing's force, and of crank angles that are written at it.
POINTS: Final = 180
MARKED: Final = 4
#: Force -> its bearing.
BEARINGS: Final = {"pivot_force": "P", "crank_force": "O"}


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
            for engine, numbers in found.items():
                if (one := numbers.get(name)) and (one.value or one.error):
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
