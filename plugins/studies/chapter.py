"""How near is a resonance? The resonance curve around the speed of the user's own machine."""

import math
from collections.abc import Iterator, Sequence
from typing import Final, NamedTuple

from quickreturn.cases.motion.stability import UNSTABLE
from quickreturn.plugins.studies.around import Around, around_of, nearness, work
from quickreturn.reports.page.chapter import Chapter, Plot, Series
from quickreturn.reports.page.content import Content
from quickreturn.reports.page.part import Part
from quickreturn.reports.tables import CASE, Column, ColumnList, Table
from quickreturn.reports.words import number

_SPEED: Final = Column("speed", "crank speed", "rad/s", ".5g")
_HEIGHT: Final = Column("tip_acceleration", "largest tip acceleration in a turn", "m/s^2", ".4g")


def resonance(content: Content) -> Chapter | None:
    """The chapter; None for a report on the thesis' runs."""
    machines = content.of(around_of)
    if not machines:
        return None
    facts = {
        "cases": [(each, each.sentences[1], plot(each)) if each.curve else (each, "", None) for each in machines],
        "curve": resonance_curve(machines),
    }
    return Chapter("resonance", "How near is a resonance?", finding(machines), facts)


def finding(cases: Sequence[Around]) -> str:
    """The speed of the first machine, and its distance from the nearest peak and the nearest change of stability."""
    first = cases[0]
    text = f"your machine runs at {first.shown(first.own)}; {first.nearest}" if first.curve else f"no resonance curve: {first.reason}"
    return f"{first.case.name}: {text}" if len(cases) > 1 else text


def plot(around: Around) -> Plot:
    """The plot: stable parts as a line, unstable ones dashed, peaks with their orders, special points, and the machine."""
    curve, series = around.solved_curve, []
    speed_unit, height_unit = around.case.units.of("rad/s"), around.case.units.of("m/s^2")
    for name, wanted in (("stable", False), ("unstable", True)):
        points: list[tuple[float | None, float | None, str]] = []
        for part, unstable in curve.stretches():
            if unstable is wanted:
                for at in range(*part.indices(len(curve.kinds))):
                    speed, height = float(curve.values[at]), float(around.heights[at])
                    multiplier = number(math.hypot(*curve.multipliers[at]), ".3g")
                    told = _told(around, speed, height, f"multiplier {multiplier}")
                    points.append((speed / speed_unit.size, height / height_unit.size, told))
                points.append((None, None, ""))
        if points:
            x, y, text = zip(*points, strict=True)
            series.append(Series(name, name, x, y, text, marked=False))
    marks = list(_marks(around))
    for name in dict.fromkeys(mark.name for mark in marks):
        of_kind = [mark for mark in marks if mark.name == name]
        series.append(
            Series(
                name,
                name,
                [mark.speed / speed_unit.size for mark in of_kind],
                [mark.height / height_unit.size for mark in of_kind],
                [_told(around, mark.speed, mark.height, mark.about) for mark in of_kind],
                line=False,
                labels=[mark.label for mark in of_kind],
            )
        )
    here = (around.own / speed_unit.size, "your machine runs here")
    labels = f"crank speed [{speed_unit.sign}]", f"largest tip acceleration in a turn [{height_unit.sign}]"
    return Plot("resonance_curve.csv", *labels, series, "y", here=here)


def _told(around: Around, speed: float, height: float, about: str) -> str:
    unit = around.case.units.of("m/s^2")
    return f"{around.shown(speed)}, {number(height / unit.size, '.4g')} {unit.sign}; {about}"


class _Mark(NamedTuple):
    """A peak, a special point or the machine itself on the curve."""

    name: str
    speed: float  # rad/s
    height: float  # m/s^2
    about: str
    label: str = ""


def _marks(around: Around) -> Iterator[_Mark]:
    curve = around.solved_curve
    for peak in curve.peaks:
        about = f"driven by {peak.order} times the crank’s speed; {around.way(peak.value)} than your machine"
        yield _Mark("peak", peak.value, peak.height, about, f"{peak.order}×")
    for point in curve.special:
        about = "; ".join(filter(None, (f"{around.way(point.value)} than your machine", point.reason)))
        yield _Mark(point.kind, point.value, float(around.heights[point.at]), about)
    for height, kind in around.motions:
        yield _Mark("your machine", around.own, height, UNSTABLE.format(kind) if kind else "stable")


def resonance_curve(cases: Sequence[Around]) -> Table:
    """Every point of every curve."""
    speed_and_height = [column.shown_in(cases[0].case.units) for column in (_SPEED, _HEIGHT)]
    columns: ColumnList = (CASE, Column("arclength", unit="1"), *speed_and_height, Column("multiplier", unit="1"), "stability", "special")
    table = Table(
        "resonance_curve",
        """Points of the resonance curve in order of arclength. At a fold the speed turns back. Multiplier: the factor by which the slowest
        disturbance changes in a turn; beyond 1 the motion is unstable.""",
        columns,
        in_page=False,
    )
    for around in cases:
        curve = around.curve
        if curve is None:
            continue
        special = {point.at: point.kind for point in curve.special}
        for at in range(len(curve.values)):
            table.add(
                case=around.case.name,
                arclength=float(curve.arclength[at]),
                speed=float(curve.values[at]),
                tip_acceleration=float(around.heights[at]),
                multiplier=math.hypot(*curve.multipliers[at]),
                stability=str(curve.stability(at)),
                special=special.get(at, ""),
            )
    return table


PAGE = Part(chapters={resonance: 13}, templates=("quickreturn.plugins.studies",), work=work, nearness=nearness)
