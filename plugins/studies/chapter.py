"""How near is a resonance? The resonance curve around the speed of the user's own machine."""

import math
from collections.abc import Iterator, Sequence
from typing import Any, Final

from quickreturn.plugins.studies.around import Around, around_of, nearness, work
from quickreturn.reports.page.chapter import Chapter, Plot, Series
from quickreturn.reports.page.content import Content
from quickreturn.reports.page.part import Part
from quickreturn.reports.tables import CASE, Column, ColumnList, Table
from quickreturn.reports.words import number, size

_SPEED: Final = Column("speed", "crank speed", "rad/s", ".5g")
_HEIGHT: Final = Column("tip_acceleration", "largest tip acceleration in a turn", "m/s^2", ".4g")
#: The page's name for the machine on its curve.
OWN: Final = "your machine"
PEAK: Final = "peak"


def resonance(content: Content) -> Chapter | None:
    """The chapter; None for a report on the thesis' runs."""
    machines = content.of(around_of)
    if not machines:
        return None
    facts = {
        "cases": [(each, each.sentences[1], plot(each)) if each.curve else (each, "", None) for each in machines],
        "table": resonances(machines),
        "curve": resonance_curve(machines),
    }
    return Chapter("resonance", "How near is a resonance?", finding(machines), facts)


def finding(cases: Sequence[Around]) -> str:
    """The speed of the first machine, and its distance from the nearest peak and the nearest change of stability."""
    first = cases[0]
    text = f"your machine runs at {first.shown(first.own)}; {first.nearest}" if first.curve else f"no resonance curve: {first.reason}"
    return f"{first.case.name}: {text}" if len(cases) > 1 else text


def plot(around: Around) -> Plot:
    """The plot: stable parts as a line, unstable ones dashed, peaks and folds with their orders, and the machine's speed."""
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
    rows = list(remarkable(around))
    for name in dict.fromkeys(row["point"] for row in sorted(rows, key=lambda row: (row["point"] == OWN, row["point"] != PEAK))):
        of_kind = [row for row in rows if row["point"] == name]
        series.append(
            Series(
                name,
                name,
                [row["speed"] / speed_unit.size for row in of_kind],
                [row["tip_acceleration"] / height_unit.size for row in of_kind],
                [_told(around, row["speed"], row["tip_acceleration"], _about(around, row)) for row in of_kind],
                line=False,
                labels=[f"{row['order']}×" if row["order"] else "" for row in of_kind],
            )
        )
    here = (around.own / speed_unit.size, "your machine runs here")
    labels = f"crank speed [{speed_unit.sign}]", f"largest tip acceleration in a turn [{height_unit.sign}]"
    return Plot("resonance_curve.csv", *labels, series, "y", here=here)


def _told(around: Around, speed: float, height: float, about: str) -> str:
    unit = around.case.units.of("m/s^2")
    return f"{around.shown(speed)}, {number(height / unit.size, '.4g')} {unit.sign}; {about}"


def _about(around: Around, row: dict[str, Any]) -> str:
    if row["point"] == OWN:
        return str(row["stability"])
    way = "faster" if row["distance"] > 0.0 else "slower"
    driven = f"driven by {row['order']} times the crank’s speed; " if row["order"] else ""
    return f"{driven}{size(row['distance'])} {way} than your machine" + (f"; {row['reason']}" if row["reason"] else "")


def resonances(cases: Sequence[Around]) -> Table:
    """The machine, peaks and special points, from the slowest to the fastest."""
    rows = [{"case": around.case.name, **row} for around in cases if around.curve for row in remarkable(around)]
    units = cases[0].case.units
    distance, reason = Column("distance", "from your speed", "%", "+.2f"), Column("reason", "the curve ends because")
    ends = [reason] if any(row["reason"] for row in rows) else []
    table = Table(
        "resonances",
        """The machine on its resonance curve, and the peaks and special points within 15 % of its speed. Order: the multiple of the crank's
        speed that lies nearest to the first mode at this point.""",
        (CASE, "point", "stability", Column("order", form="d"), _SPEED.shown_in(units), distance, _HEIGHT.shown_in(units), *ends),
    )
    for row in rows:
        table.add(row)
    return table


def remarkable(around: Around) -> Iterator[dict[str, Any]]:
    """The machine, peaks and special points of one curve, as rows of `resonances` from the slowest to the fastest."""
    curve = around.solved_curve
    rows = [_row(around, OWN, around.own, height, kind) for height, kind in around.motions]
    rows += [_row(around, PEAK, point.value, point.height, curve.kinds[point.at], point.order) for point in curve.peaks]
    for point in curve.special:
        order = around.order_at(point.value) if point.kind == "fold" else None
        rows.append(_row(around, point.kind, point.value, float(around.heights[point.at]), None, order, point.reason))
    yield from sorted(rows, key=lambda row: abs(row["speed"]))


def _row(
    around: Around, point: str, speed: float, height: float, kind: str | None, order: int | None = None, reason: str = ""
) -> dict[str, Any]:
    stability = "" if kind is None else f"unstable: {kind}" if kind else "stable"
    row = {"point": point, "stability": stability, "order": order, "speed": speed}
    return row | {"distance": around.faster(speed), "tip_acceleration": height, "reason": reason}


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
