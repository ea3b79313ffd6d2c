"""The pictures of the documents that do not move: `python -m reports.document_pictures docs/pictures`.

Run 24's steady state is computed where it is not stored; the methods are those of the recorded benchmark.
"""

import io
import sys
from pathlib import Path

from PIL import Image

from cases.case_file import load_case
from cases.experiment.published import axis_labels
from cases.jobs.store import Store
from cases.jobs.workshop import Workshop
from cases.runs.comparison import cross_validate
from reports.long_studies import benchmarks
from reports.plots.cycle import cycle_figure
from reports.plots.picture import Picture
from reports.plots.work_precision import work_precision_figure

RUN = 24
CASE = f"thesis-{RUN}"
COLOURS = 64  # of the palette: flat colours and their soft edges need no more


def main(folder: Path) -> None:
    """Write them into a folder."""
    (result,) = cross_validate([load_case(CASE)], Workshop(Store()))
    folder.mkdir(parents=True, exist_ok=True)
    _write(folder / "run-24.png", cycle_figure(result, axis_labels(RUN)))
    _write(folder / "methods.png", work_precision_figure(benchmarks()[CASE]))


def _write(path: Path, picture: Picture | None) -> None:
    if picture is None:
        raise SystemExit(f"{path}: there is nothing to draw")
    image = Image.open(io.BytesIO(picture.data)).convert("RGB").quantize(COLOURS)
    image.save(path, optimize=True)
    print(f"{path} {image.width} x {image.height}")


if __name__ == "__main__":
    if len(sys.argv) != 2:
        raise SystemExit("python -m reports.document_pictures FOLDER: give the folder that they go to")
    main(Path(sys.argv[1]))
