"""What the thesis leaves open, and accuracy beside cost."""

from typing import Any, Final

import numpy as np
import pandas as pd

from cases.measures import CHANNELS
from cases.runs.comparison import REFERENCE
from reports.findings.agreement import engines_of
from reports.page.content import Content
from reports.page.plot import Plot, Series
from reports.tables import studies as tables
from reports.tables.orbits import GONE_AT, SETTLED_AT, both_ways, orbits
from reports.tables.table import Table
from reports.words import HALF, case_label, size

#: What two solutions may differ by to confirm each other.
CONFIRMED: Final = 5e-4
#: A change of more than this part is worth a word; in a strong run the measure itself may be half of it off.
NOTABLE: Final = 0.01


def open_points(content: Content) -> dict[str, Any] | None:
    """None where the runs that it is about are not all shown."""
    if content.studies is None or content.studies.sensitivity.empty:
        return None
    frame = content.studies.sensitivity
    return {
        "notable": NOTABLE,
        "frequency": _strongest(frame, "first_mode_frequency"),
        "amplitude": _strongest(frame, "first_mode_amplitude"),
        "failures": content.studies.failures,
        "plot": _sensitivity(frame),
        "table": tables.sensitivity(frame),
    }


def _strongest(frame: pd.DataFrame, quantity: str) -> list[tuple[str, float]]:
    """Changes and how far they move a quantity at most, the strongest first."""
    known = frame[(frame["quantity"] == quantity) & frame["relative_change"].notna()]
    largest = known.assign(size=known["relative_change"].abs()).groupby("change")["size"].max().sort_values(ascending=False)
    return [(str(change), float(value)) for change, value in largest.items()]


def _sensitivity(frame: pd.DataFrame) -> Plot:
    known = frame[(frame["quantity"] == "first_mode_frequency") & frame["relative_change"].notna()]
    series = []
    for (run, half), group in known.groupby(["run", "half"], sort=False):
        changes, moved = [str(change) for change in group["change"]], [100.0 * float(value) for value in group["relative_change"]]
        texts = [f"{change}: {size(value / 100.0)}" for change, value in zip(changes, moved, strict=True)]
        series.append(Series(f"{case_label(str(run))}, {HALF[str(half)]}", "", changes, moved, texts, line=False))
    return Plot(
        "sensitivity.csv",
        "",
        "change of the first-mode frequency [%]",
        series,
        categories=list(dict.fromkeys(known["change"])),
        legend="bottom_left",
    )


def accuracy(content: Content) -> dict[str, Any] | None:
    """None for a report on other cases than the thesis' runs, where no steady state was found directly either."""
    studies = content.studies
    marching = [name for name in engines_of(content.results) if name != REFERENCE]
    found = orbits(content.results, marching)
    if studies is None and not found.rows:
        return None
    confirmation = (
        [] if studies is None else [{str(key): value for key, value in row.items()} for row in studies.confirmation.to_dict("records")]
    )
    return {
        "studied": studies is not None,
        "errors": {} if studies is None else {row["engine"]: float(row["tip_deflection"]) for row in studies.accuracy.to_dict("records")},
        "confirmation": confirmation,
        "confirmed": CONFIRMED,
        "failures": () if studies is None else studies.failures,
        "both_ways": [] if studies is None else studies.both_ways.to_dict("records"),
        "saved": _saved(found),
        "settled_at": SETTLED_AT,
        "gone_at": GONE_AT,
        "plot": None if studies is None or studies.convergence.empty else _convergence(studies.convergence),
        "accuracy": None if studies is None else tables.accuracy(studies.accuracy),
        "confirmation_table": None if studies is None else tables.confirmation(studies.confirmation),
        "convergence": None if studies is None else tables.convergence(studies.convergence),
        "orbits": found,
        "both_ways_table": None if studies is None or studies.both_ways.empty else both_ways(studies.both_ways),
        "solve_times": tables.solve_times(content.results),
    }


def _convergence(frame: pd.DataFrame) -> Plot:
    finest = frame[(frame["tolerance"] == frame["tolerance"].min()) & ~frame["is_reference"]]
    columns = [name for name in ("tip_deflection", *CHANNELS, "slider_force") if name in frame.columns]
    series = [
        Series(name.replace("_", " "), "", [int(n) for n in finest["modes"]], [float(value) for value in finest[name]],
               [f"{int(n)} modes: {size(float(value))}" for n, value in zip(finest["modes"], finest[name], strict=True)])
        for name in columns
    ]  # fmt: skip
    return Plot("convergence.csv", "modes", "error, RMS over RMS", series, "y")


def _saved(found: Table) -> dict[str, float] | None:
    """How much less work than marching a direct search is, in the median."""
    columns = [column.key for column in found.columns]
    work, settled, gone = (
        np.array([row[columns.index(key)].value for row in found.rows], dtype=float)
        for key in ("cycles_of_work", "cycles_to_settled", "cycles_to_gone")
    )
    if not len(work):
        return None
    ratios = {"settled": settled / work, "gone": gone / work}
    return {"work": float(np.nanmedian(work)), "runs": len(work), **{name: float(np.nanmedian(ratio)) for name, ratio in ratios.items()}}
