"""The pictures of the documents, from the same results as the report: `python -m reports.readme_pictures`.

After `make report`, and after `quickreturn benchmark` on a machine that does nothing else.
"""

import io
from pathlib import Path

from PIL import Image

from cases.benchmark import stored
from cases.case_file import load_case
from cases.experiment.published import axis_labels
from cases.jobs.store import Store
from cases.jobs.workshop import Workshop
from cases.library.thesis import RUNS, run_name
from cases.runs.comparison import cross_validate
from reports.plots.cycle import cycle_figure
from reports.plots.overview import overview_figure
from reports.plots.picture import Picture
from reports.plots.work_precision import work_precision_figure

FOLDER = Path(__file__).parents[1] / "docs/pictures"
COLOURS = 64  # of the palette: flat colours and their soft edges need no more


def main() -> None:
    """Write all pictures; results that are not stored are computed."""
    workshop = Workshop(Store())
    results = cross_validate([load_case(run_name(run)) for run in RUNS], workshop)
    FOLDER.mkdir(exist_ok=True)
    _write("overview", overview_figure(results))
    _write("run-24", cycle_figure(results[-1], axis_labels(24)))
    measured = stored(results[-1].case, workshop)
    _write("methods", None if measured is None else work_precision_figure(measured))


def _write(name: str, picture: Picture | None) -> None:
    if picture is None:
        raise SystemExit(f"{name}: there is nothing to draw")
    image = Image.open(io.BytesIO(picture.data)).convert("RGB").quantize(COLOURS)
    image.save(FOLDER / f"{name}.png", optimize=True)
    print(f"{name}.png {image.width} x {image.height}")


if __name__ == "__main__":
    main()
