"""Draws the errors of `errors.csv` over the pieces: `python picture.py FILE.svg`."""

import csv
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, NullLocator

TABLE: Final = Path(__file__).parent / "errors.csv"
#: Program -> words, colour and mark.
PROGRAMS: Final[Mapping[str, tuple[str, str, str]]] = {
    "pyelastica_rod": ("PyElastica, first element fixed", "#D55E00", "^"),
    "mujoco_hinges": ("MuJoCo, hinges", "#0072B2", "o"),
    "newton_hinges": ("Newton, hinges", "#56B4E9", "x"),
    "mujoco_bend": ("MuJoCo 3, bend", "#009E73", "s"),
    "exudyn_cable": ("Exudyn, ANCF cable", "#7A4FA3", "D"),
}
PANELS: Final = {"sag": "sag under its weight", "f1": "first frequency"}
#: Errors that fall with the number of pieces and with its square: percent at three pieces.
GUIDES: Final = {1: (120.0, "as 1/N"), 2: (1.2, "as 1/N²")}


def rows_of(table: Path = TABLE) -> list[dict[str, str]]:
    """The recorded errors, relative, in the order of the file."""
    with table.open(encoding="utf-8") as file:
        return list(csv.DictReader(file))


def drawn(rows: list[dict[str, str]]) -> Figure:
    """Error of the sag and of the first frequency, a line for each program."""
    figure = Figure(figsize=(6.6, 3.4), layout="constrained", facecolor="white")
    both = figure.subplots(1, 2, sharex=True, sharey=True)
    for axes, (column, words) in zip(both, PANELS.items(), strict=True):
        for program, (name, colour, mark) in PROGRAMS.items():
            of = [row for row in rows if row["program"] == program]
            pieces = [int(row["pieces"]) for row in of]
            errors = [100.0 * abs(float(row[column])) for row in of]
            style: dict[str, Any] = {"color": colour, "marker": mark, "markersize": 4.5}
            axes.loglog(pieces, errors, linewidth=1.1, label=name, **style)
        ends = min(int(row["pieces"]) for row in rows), max(int(row["pieces"]) for row in rows)
        framed(axes, words, ends)
    both[0].set_ylabel("error, % of the closed form", fontsize=9)
    lines = both[0].get_legend_handles_labels()
    figure.legend(*lines, loc="outside upper center", ncols=3, fontsize=8, frameon=False)
    return figure


def framed(axes: Axes, words: str, ends: tuple[int, int]) -> None:
    """Ticks, labels, and slopes to compare with."""
    for power, (begin, name) in GUIDES.items():
        end = begin * (ends[0] / ends[1]) ** power
        axes.plot(ends, (begin, end), color="#999999", linestyle=":", linewidth=0.9, zorder=1.0)
        place = (ends[0], begin), (2, 2 if power == 1 else -12)
        axes.annotate(name, *place, textcoords="offset points", fontsize=8, color="#555555")
    axes.set_title(words, fontsize=9)
    axes.set_xlabel("number of pieces N", fontsize=9)
    axes.set_ylim(5e-4, 300.0)
    axes.set_xticks([3, 5, 10, 20])
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axis.set_minor_locator(NullLocator())
    axes.tick_params(labelsize=8)
    axes.grid(color="#D6D6D6", linewidth=0.5)


if __name__ == "__main__":
    # letters as text, not as outlines, and no date: a small file that changes with the table
    with rc_context({"svg.fonttype": "none", "svg.hashsalt": "rods"}):
        drawn(rows_of()).savefig(sys.argv[1], metadata={"Date": None})
