"""Common style of all pictures: sizes, colours and lines of the engines, axes.

A picture is 480 CSS pixels wide, 127 mm in print. Two fit side by side on a screen; on a telephone's width its letters of 12 pixels shrink
to no less than 10. Engines look as on the page.
"""

import io
import math
from collections.abc import Sequence
from typing import Any, Final

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FormatStrFormatter, LogLocator, NullFormatter

from quickreturn.reports.line_styles import Look, looks

WIDTH: Final = 5.0  # in, 480 CSS pixels
WHOLE: Final = 32  # 1/32 in is 3 CSS pixels and exact in binary: sizes in pixels are whole numbers
NOTEBOOK: Final = 110  # dots per inch in a notebook
PER_INCH: Final = 192  # dots per inch of a picture file: two to a CSS pixel, sharp on fine screens
FONT_SIZE: Final = 9.0  # pt, 12 CSS pixels
SMALL: Final = 8.0  # pt, ticks and notes
LETTERS: Final = 36  # longest line of a label beside an axis

SAMPLE: Final = 4.0  # in letter sizes, length of a legend's sample: more than a period of the dashes
POINTS_PER_INCH: Final = 72.0

QUICK: Final = "#E0A21B"  # the quick return, as on the page
GREY: Final = "#666666"
LIGHT: Final = "#EAEAEA"


#: Marks of points (`reports.line_styles.Look.marker`) as the plotting library names them.
MARKERS: Final = {
    "circle": "o", "square": "s", "diamond": "D", "triangle": "^", "triangle-down": "v", "triangle-left": "<", "triangle-right": ">",
    "pentagon": "p", "hexagon": "h", "star": "*", "plus": "P", "cross": "X",
}  # fmt: skip
#: Points (1/72 in) of a picture for a CSS pixel of a line on the page.
SCALE: Final = 0.5


def look(engine: str) -> dict[str, Any]:
    """Matplotlib's keywords for the line of one engine, as on the page."""
    return all_looks([engine])[engine]


def all_looks(engines: Sequence[str]) -> dict[str, dict[str, Any]]:
    """Name -> matplotlib's keywords for its line, as on the page, for engines and recorded tables."""
    return {name: _of_line(one) for name, one in looks(engines).items()}


def _of_line(look: Look) -> dict[str, Any]:
    width = max(0.9, SCALE * look.width)
    style = (SCALE * look.offset / width, tuple(SCALE * part / width for part in look.dash)) if look.dash else "-"
    return {"color": look.light, "linestyle": style, "linewidth": width, "zorder": 2.0 + 0.05 * (look.order - 1)}


def picture(figure: Figure, ending: str) -> bytes:
    """A figure as the content of a file with this ending, such as ".svg"."""
    file = io.BytesIO()
    figure.savefig(file, format=ending.removeprefix("."), dpi=PER_INCH)
    return file.getvalue()


class Drawing(Figure):
    """A figure that a notebook shows by itself; `savefig` writes it to a file."""

    def _repr_png_(self) -> bytes:
        file = io.BytesIO()
        self.savefig(file, format="png", dpi=NOTEBOOK)
        return file.getvalue()


def new_figure(height: float, width: float = WIDTH) -> Drawing:
    """An empty figure with constrained layout; height and width in inches, the height rounded up to whole pixels."""
    return Drawing(figsize=(width, math.ceil(WHOLE * height) / WHOLE), layout="constrained", facecolor="white")


def tidy(axes: Axes, y_label: str = "") -> None:
    """Add a label, ticks and a faint grid."""
    axes.set_ylabel(y_label, fontsize=FONT_SIZE)
    axes.tick_params(labelsize=SMALL, length=2.5, width=0.6)
    for spine in axes.spines.values():
        spine.set_linewidth(0.6)
    axes.set_axisbelow(True)
    axes.grid(color="#CFCFCF", linewidth=0.5)


def logarithmic(axes: Axes) -> None:
    """Make the ordinate logarithmic, with plain numbers at 1, 2 and 5 of each decade."""
    axes.set_yscale("log")
    axes.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axes.yaxis.set_major_formatter(FormatStrFormatter("%g"))
    axes.yaxis.set_minor_formatter(NullFormatter())


def note(axes: Axes, x: float, y: float, text: str, **keywords: Any) -> None:
    """Write a small remark inside the axes, at x and y in fractions of them, on a white ground that keeps it legible over lines."""
    chosen = {"fontsize": SMALL, "color": "#333333", "va": "top", "transform": axes.transAxes, "zorder": 5.0, **keywords}
    ground = {"facecolor": "white", "edgecolor": "none", "alpha": 0.75, "pad": 0.8}
    axes.text(x, y, text, bbox=ground, **chosen)


def legend_above(figure: Figure, handles: Sequence[Artist], most_columns: int) -> None:
    """Put a legend above all axes, where it covers nothing, in as many columns as fit."""
    fitting = [count for count in range(most_columns, 1, -1) if _legend_width(handles, count) < POINTS_PER_INCH * WIDTH]
    figure.legend(
        handles=list(handles),
        loc="outside upper center",
        ncols=fitting[0] if fitting else 1,
        fontsize=SMALL,
        frameon=False,
        handlelength=SAMPLE,
        columnspacing=1.2,
    )


def _legend_width(handles: Sequence[Artist], columns: int) -> float:
    """Estimated width in points: letters are about 0.58 of the font size wide, a sample and its gaps take a few font sizes."""
    longest = [max((len(str(handle.get_label())) for handle in column), default=0) for column in np.array_split(np.array(handles), columns)]
    return SMALL * sum(0.58 * letters + SAMPLE + 2.0 for letters in longest)
