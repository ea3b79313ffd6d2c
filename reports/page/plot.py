"""A plot as data: what the script hands to the plotting library. Its numbers are those of the table whose file stands beside it."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any


@dataclass(frozen=True)
class Series:
    """Points of one source.

    Attributes:
        name: written at the line's end.
        engine: whose colour it has, and with which it is switched on and off; "" for what stays.
        x: values on the horizontal axis.
        y: values on the vertical axis, as many.
        text: what stands under the pointer beside the values, one per point, or nothing.
        hollow: whether its marks are hollow, as those of variants.
        line: whether the points are joined.
        broad: whether it is the broad band behind the others.
    """

    name: str
    engine: str
    x: Sequence[float | str]
    y: Sequence[float]
    text: Sequence[str] = ()
    hollow: bool = False
    line: bool = True
    broad: bool = False


@dataclass(frozen=True)
class Plot:
    """A plot.

    Attributes:
        file: of the table with these numbers.
        x: label of the horizontal axis, with its unit.
        y: label of the vertical axis, with its unit.
        series: what is drawn, later ones on top.
        log: which axes are logarithmic: "", "x", "y" or "xy".
        below: values on the vertical axis below this mean nothing: the range is marked.
        categories: texts of one axis, where it has no numbers: it is then drawn upright.
        legend: corner of the legend of series that are no engine's.
    """

    file: str
    x: str
    y: str
    series: Sequence[Series]
    log: str = ""
    below: float | None = None
    categories: Sequence[str] = ()
    legend: str = "top_right"

    @property
    def document(self) -> dict[str, Any]:
        """For the script."""
        return asdict(self)
