"""Draws the frequency response of a linear model: amplitude and phase over frequency."""

import math
from collections.abc import Mapping
from typing import Final

import numpy as np
from matplotlib.ticker import LogLocator, MultipleLocator, NullFormatter
from numpy.typing import NDArray

from quickreturn.cases.files.shown import Units
from quickreturn.reference_model.arrays import Array
from quickreturn.reports.drawing.curves import PANEL, WIDE
from quickreturn.reports.drawing.style import FONT_SIZE, SAMPLE, SMALL, Drawing, new_figure, tidy

#: Line of each input.
LINES: Final = (("#1062c8", "-"), ("#d95f02", "--"), ("#111111", ":"))


def bode(
    frequencies: Array, response: NDArray[np.complex128], inputs: Mapping[str, str], outputs: Mapping[str, str], units: Units, title: str
) -> Drawing:
    """A panel for the amplitude and one for the phase of each output, a line for each input.

    Args:
        frequencies: Hz, shape (n,).
        response: output over input, SI, shape (n, outputs, inputs).
        inputs: name -> SI unit.
        outputs: likewise.
        units: units of the picture.
        title: above the panels.
    """
    count = len(outputs)
    figure = new_figure(0.9 + 1.75 * PANEL * count, WIDE)
    panels = figure.subplots(2 * count, 1, sharex=True, squeeze=False, height_ratios=[3.0, 2.0] * count)[:, 0]
    for row, (output, unit) in enumerate(outputs.items()):
        amplitude, phase, shown = panels[2 * row], panels[2 * row + 1], units.column(unit)
        for column, (name, of_input) in enumerate(inputs.items()):
            given, values, (color, style) = units.of(of_input), response[:, row, column], LINES[column % len(LINES)]
            label, looks = f"per {given.sign} of {name.replace('_', ' ')}", {"color": color, "linestyle": style, "linewidth": 1.3}
            amplitude.loglog(frequencies, np.abs(values) * given.size / shown.size, label=label, **looks)
            degrees = np.degrees(np.angle(values))
            phase.semilogx(frequencies, np.where(np.abs(np.diff(degrees, prepend=degrees[0])) > 180.0, math.nan, degrees), **looks)
        tidy(amplitude, f"{output.replace('_', ' ')} [{shown.sign}]")
        tidy(phase, "phase [deg]")
        phase.yaxis.set_major_locator(MultipleLocator(90.0))
        phase.set_ylim(-195.0, 195.0)
    for panel in panels[::2]:
        low, high = panel.get_ylim()
        if high < 100.0 * low:  # too few powers of ten to read the axis by
            panel.yaxis.set(major_locator=LogLocator(subs=(1.0, 2.0, 5.0)), major_formatter="{x:g}", minor_formatter=NullFormatter())
    panels[-1].set_xlim(frequencies[0], frequencies[-1])
    panels[-1].xaxis.set(major_locator=LogLocator(subs=(1.0, 2.0, 5.0)), major_formatter="{x:g}", minor_formatter=NullFormatter())
    panels[-1].set_xlabel("frequency [Hz]", fontsize=FONT_SIZE)
    figure.suptitle(title, fontsize=FONT_SIZE + 1.0)
    named = panels[0].get_legend_handles_labels()
    figure.legend(*named, loc="outside lower center", ncols=3, fontsize=SMALL, frameon=False, handlelength=SAMPLE)
    return figure
