"""The pictures of the documents that do not move: `python -m reports.document_pictures`.

Run 24's steady state is computed where it is not stored; the methods are those of the recorded benchmark.
"""

import io
from pathlib import Path

from PIL import Image

from cases.case_file import load_case
from cases.experiment.published import axis_labels
from cases.jobs.store import Store
from cases.jobs.workshop import Workshop
from cases.runs.comparison import cross_validate
from reports.plots.cycle import cycle_figure
from reports.plots.picture import Picture
from reports.plots.work_precision import work_precision_figure
from reports.recorded import benchmarks

FOLDER = Path(__file__).parents[1] / "docs/pictures"
RUN = 24
CASE = f"thesis-{RUN}"
COLOURS = 64  # of the palette: flat colours and their soft edges need no more


def main() -> None:
    """Write them."""
    (result,) = cross_validate([load_case(CASE)], Workshop(Store()))
    FOLDER.mkdir(exist_ok=True)
    _write("run-24", cycle_figure(result, axis_labels(RUN)))
    _write("methods", work_precision_figure(benchmarks()[CASE]))


def _write(name: str, picture: Picture | None) -> None:
    if picture is None:
        raise SystemExit(f"{name}: there is nothing to draw")
    image = Image.open(io.BytesIO(picture.data)).convert("RGB").quantize(COLOURS)
    image.save(FOLDER / f"{name}.png", optimize=True)
    print(f"{name}.png {image.width} x {image.height}")


if __name__ == "__main__":
    main()
