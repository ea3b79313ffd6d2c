"""Tables of the resonance curves around the speeds of the user's own machines: their points, peaks and special points."""

import math
from collections.abc import Iterator, Sequence
from typing import Any, Final

from quickreturn.reports.findings.resonance import Around
from quickreturn.reports.tables.table import CASE, Column, Table

_SPEED: Final = Column("speed", "crank speed", "rpm", ".5g")
_HEIGHT: Final = Column("tip_acceleration", "largest tip acceleration in a turn", "m/s²", ".4g")
#: The page's name for the machine on its curve.
OWN: Final = "your machine"
PEAK: Final = "peak"


def resonances(cases: Sequence[Around]) -> Table:
    """The machine, peaks and special points, from the slowest to the fastest."""
    rows = [{"case": around.case.name, **row} for around in cases if around.curve for row in remarkable(around)]
    distance, reason = Column("distance", "from your speed", "%", "+.2f"), Column("reason", "the curve ends because")
    ends = [reason] if any(row["reason"] for row in rows) else []
    table = Table("resonances", (CASE, "point", "stability", Column("order", form="d"), _SPEED, distance, _HEIGHT, *ends))
    for row in rows:
        table.add(row)
    return table


def remarkable(around: Around) -> Iterator[dict[str, Any]]:
    """The machine, peaks and special points of one curve, as rows of `resonances` from the slowest to the fastest."""
    curve = around.solved_curve
    rows = [_row(around, OWN, around.pace, height, kind) for height, kind in around.motions]
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
    columns = (CASE, Column("arclength", unit="1"), _SPEED, _HEIGHT, Column("multiplier", unit="1"), "stability", "special")
    table = Table("resonance_curve", columns, in_page=False)
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
