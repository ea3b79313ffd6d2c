"""Facts of the chapter on the resonance curve around the speed of the user's own machine."""

import math
from typing import Any, Final

from quickreturn.cases.resonance_curve import NEAR
from quickreturn.reports.findings.resonance import Around
from quickreturn.reports.page.content import Content
from quickreturn.reports.page.plot import Plot, Series
from quickreturn.reports.tables.resonance import OWN, PEAK, remarkable, resonance_curve, resonances
from quickreturn.reports.words import number, per_unit, size

_RPM: Final = per_unit("rpm")


def resonance(content: Content) -> dict[str, Any] | None:
    """The facts for `chapters/resonance.html`; None for a report on the thesis' runs."""
    if not content.around:
        return None
    return {
        "cases": [(around, plot(around) if around.curve else None) for around in content.around],
        "rpm": _RPM,
        "near": NEAR,
        "table": resonances(content.around),
        "curve": resonance_curve(content.around),
    }


def plot(around: Around) -> Plot:
    """The plot: stable parts as a line, unstable ones dashed, peaks and folds with their orders, and the machine's speed."""
    curve, series = around.solved_curve, []
    for name, wanted in (("stable", False), ("unstable", True)):
        points: list[tuple[float | None, float | None, str]] = []
        for part, unstable in curve.stretches():
            if unstable is wanted:
                for at in range(*part.indices(len(curve.kinds))):
                    speed, height = _RPM * float(curve.values[at]), float(around.heights[at])
                    multiplier = number(math.hypot(*curve.multipliers[at]), ".3g")
                    points.append((speed, height, _told(speed, height, f"multiplier {multiplier}")))
                points.append((None, None, ""))
        if points:
            x, y, text = zip(*points, strict=True)
            series.append(Series(name, name, x, y, text, marked=False))
    rows = list(remarkable(around))
    for name in dict.fromkeys(row["point"] for row in sorted(rows, key=lambda row: (row["point"] == OWN, row["point"] != PEAK))):
        mine = [row for row in rows if row["point"] == name]
        series.append(
            Series(
                name,
                name,
                [_RPM * row["speed"] for row in mine],
                [row["tip_acceleration"] for row in mine],
                [_told(_RPM * row["speed"], row["tip_acceleration"], _about(around, row)) for row in mine],
                line=False,
                labels=[f"{row['order']}×" if row["order"] else "" for row in mine],
            )
        )
    here = (_RPM * around.pace, "your machine runs here")
    return Plot("resonance_curve.csv", "crank speed [rpm]", "largest tip acceleration in a turn [m/s²]", series, "y", here=here)


def _told(speed: float, height: float, about: str) -> str:
    return f"{number(speed, '.5g')} rpm, {number(height, '.4g')} m/s²; {about}"


def _about(around: Around, row: dict[str, Any]) -> str:
    if row["point"] == OWN:
        return str(row["stability"])
    way = "faster" if row["distance"] > 0.0 else "slower"
    driven = f"driven by {row['order']} times the crank’s speed; " if row["order"] else ""
    return f"{driven}{size(row['distance'])} {way} than your machine" + (f"; {row['reason']}" if row["reason"] else "")
