"""The pictures of the documents that do not move: `python -m reports.document_pictures docs/pictures`.

Run 24's steady state is computed where it is not stored; the methods are those of the recorded benchmark.
"""

import io
import sys
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from PIL import Image

from cases.case_file import load_case
from cases.experiment.published import axis_labels
from cases.jobs.store import Store
from cases.jobs.workshop import Workshop
from cases.runs.comparison import cross_validate
from reports.long_studies import benchmarks
from reports.plots import cycle, work_precision
from reports.plots.style import PER_INCH

RUN = 24
CASE = f"thesis-{RUN}"
COLOURS = 48  # of the palette: the most frequent ones, so that lines keep theirs exactly; their smoothed edges take the nearest


def main(folder: Path) -> None:
    """Write them into a folder."""
    (result,) = cross_validate([load_case(CASE)], Workshop(Store()))
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "run-24.png").write_bytes(png(cycle.draw_cycle(result, axis_labels(RUN))))
    (folder / "methods.png").write_bytes(png(work_precision.draw(benchmarks()[CASE])))


def png(figure: Figure) -> bytes:
    """A small file of few colours."""
    drawn, file = io.BytesIO(), io.BytesIO()
    figure.savefig(drawn, format="png", dpi=PER_INCH)
    pixels = np.asarray(Image.open(drawn).convert("RGB"), dtype=int)
    colours, which, counts = np.unique(pixels.reshape(-1, 3), axis=0, return_inverse=True, return_counts=True)
    kept = colours[np.argsort(-counts)[:COLOURS]]
    nearest = np.argmin(np.sum((colours[:, None] - kept) ** 2, axis=2), axis=1)
    small = Image.fromarray(nearest[which].reshape(pixels.shape[:2]).astype(np.uint8), "P")
    small.putpalette(kept.astype(np.uint8).tobytes())
    small.save(file, "PNG", optimize=True)
    return file.getvalue()


if __name__ == "__main__":
    if len(sys.argv) != 2:
        raise SystemExit("python -m reports.document_pictures FOLDER: give the folder that they go to")
    main(Path(sys.argv[1]))
