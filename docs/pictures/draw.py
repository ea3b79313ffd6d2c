"""Draws the still pictures of the documents: `python docs/pictures/draw.py docs/pictures`.

Run 24's steady state and the studies take some minutes unless they are stored; the picture of methods shows the recorded race.
"""

import io
import sys
from pathlib import Path
from typing import Final

import numpy as np
from matplotlib.figure import Figure
from PIL import Image

from quickreturn.cases.comparison.campaign import cross_validate
from quickreturn.cases.files.case import Case
from quickreturn.cases.library import load_case
from quickreturn.cases.running.store import Store
from quickreturn.cases.running.workshop import Workshop
from quickreturn.plugins.methods import drawing as methods
from quickreturn.plugins.methods.studies import recorded
from quickreturn.plugins.studies.drawing import resonance
from quickreturn.plugins.studies.drawing import study as study_plot
from quickreturn.plugins.studies.resonance_curve.curve import SPEED, range_of
from quickreturn.plugins.studies.resonance_curve.search import job
from quickreturn.plugins.studies.sweep.grid import Grid, axis
from quickreturn.plugins.studies.sweep.rows import MeasureRequest
from quickreturn.plugins.studies.sweep.study import study
from quickreturn.plugins.thesis.experiment import printed_ranges
from quickreturn.reports.drawing import cycle
from quickreturn.reports.drawing.style import new_figure, picture

RUN = 24
CASE = f"thesis-{RUN}"
COLOURS = 48  # in the palette: the most frequent ones, so that lines keep their colours; smoothed edges get the nearest


#: Crank speeds of the resonance curve, and measure -> the two varied keys of its map, as in the commands of `docs/studies.md`.
CURVE: Final = "180 rpm .. 260 rpm"
MAPS: Final = {
    "peak.tip_acceleration": ("crank.prescribed_speed = 90 rpm .. 240 rpm : 101", "tip.mass = 0 g .. 50 g : 26"),
    "multiplier": ("crank.prescribed_speed = 240 rpm .. 400 rpm : 65", "tip.mass = 0 g .. 100 g : 21"),
}


def main(folder: Path) -> None:
    """Write the pictures into a folder."""
    case, workshop = load_case(CASE), Workshop(Store())
    (result,) = cross_validate([case], workshop)
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "run-24.png").write_bytes(png(cycle.draw_cycle(result, printed_ranges(RUN))))
    (folder / "methods.png").write_bytes(png(methods.draw(next(found for found in recorded("benchmark") if found.case == CASE))))
    (folder / "resonance.png").write_bytes(png(curve(case, workshop)))
    for measure, axes in MAPS.items():
        request = MeasureRequest(measures=(measure,), claims=False, duration=case.duration)
        drawn = study_plot.draw(study(Grid(case, tuple(axis(text) for text in axes)), request, workshop))
        (folder / f"{measure.rpartition('.')[2].replace('_', '-')}.png").write_bytes(png(drawn))


def curve(case: Case, workshop: Workshop) -> Figure:
    """The resonance curve of a case over `CURVE`."""
    (outcome,) = workshop.outcomes([job(case, range_of(SPEED, CURVE, "range"), claims=False)], "resonance curve")
    assert outcome.value is not None
    figure = new_figure(4.2)
    resonance.draw(figure, outcome.value, case.name, case.units)
    return figure


def png(figure: Figure) -> bytes:
    """A figure as a small PNG file of few colours."""
    file = io.BytesIO()
    red, green, blue = np.asarray(Image.open(io.BytesIO(picture(figure, ".png"))).convert("RGB"), dtype=int).transpose(2, 0, 1)
    # a colour as one number is sorted ten times as fast as three
    codes, which, counts = np.unique(red << 16 | green << 8 | blue, return_inverse=True, return_counts=True)
    colours = np.stack([codes >> 16, codes >> 8 & 255, codes & 255], axis=1)
    kept = colours[np.argsort(-counts)[:COLOURS]]
    nearest = np.argmin(np.sum((colours[:, None] - kept) ** 2, axis=2), axis=1)
    small = Image.fromarray(nearest[which].reshape(red.shape).astype(np.uint8), "P")
    small.putpalette(kept.astype(np.uint8).tobytes())
    small.save(file, "PNG", optimize=True)
    return file.getvalue()


if __name__ == "__main__":
    if len(sys.argv) != 2:
        raise SystemExit("python docs/pictures/draw.py FOLDER: give the folder for the pictures")
    main(Path(sys.argv[1]))
