"""Draws the pictures that no command draws, run 24's cycle and the recorded race of methods: `python docs/pictures/draw.py docs/pictures`.

Run 24's steady state takes some minutes unless it is stored.
"""

import io
import sys
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from PIL import Image

from quickreturn.cases.comparison.campaign import cross_validate
from quickreturn.cases.library import load_case
from quickreturn.cases.motion.time_scale import CHANNELS
from quickreturn.cases.running.store import Store
from quickreturn.cases.running.workshop import Workshop
from quickreturn.plugins.methods import drawing as methods
from quickreturn.plugins.methods.studies import recorded
from quickreturn.reports.drawing import cycle
from quickreturn.reports.drawing.style import picture

CASE = "thesis-24"
COLOURS = 48  # in the palette: the most frequent ones, so that lines keep their colours; smoothed edges get the nearest


def main(folder: Path) -> None:
    """Write the pictures into a folder."""
    (result,) = cross_validate([load_case(CASE)], Workshop(Store()))
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "run-24.png").write_bytes(png(cycle.draw([result], CHANNELS)))
    (folder / "methods.png").write_bytes(png(methods.draw(next(found for found in recorded("benchmark") if found.case == CASE))))


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
