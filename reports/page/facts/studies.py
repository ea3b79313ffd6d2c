"""Facts of the chapter on accuracy and cost."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from quickreturn.cases.benchmark.findings import Point
from quickreturn.cases.benchmark.truth import CONFIRMED
from quickreturn.cases.runs.comparison import REFERENCE
from quickreturn.engines.error_parts import ESTIMATED
from quickreturn.reports.findings.agreement import engines_of
from quickreturn.reports.page.content import Content
from quickreturn.reports.page.plot import Plot, Series
from quickreturn.reports.tables import studies as tables
from quickreturn.reports.tables.orbits import GONE_AT, SETTLED_AT, both_starts, orbits
from quickreturn.reports.tables.table import Table
from quickreturn.reports.words import size


def accuracy(content: Content) -> dict[str, Any] | None:
    """The facts for `chapters/accuracy.html`; None without studies and without a steady state that was found directly."""
    studies = content.studies
    marching = [name for name in engines_of(content.results) if name != REFERENCE]
    orbit_table = orbits(content.results, marching)
    if studies is None and not orbit_table.rows:
        return None
    facts: dict[str, Any] = {
        "studies": studies,
        "confirmed": CONFIRMED,
        "saved": _saved(orbit_table),
        "settled_at": SETTLED_AT,
        "gone_at": GONE_AT,
        "orbits": orbit_table,
        "solve_times": tables.solve_times(content.results),
    }
    if studies is not None:
        facts |= {
            "plot": _convergence(studies.convergence),
            "accuracy": tables.accuracy(studies.accuracy),
            "of_record": content.of_record.get("confirmation"),
            "confirmation": tables.confirmation(studies.converged, studies.confirming),
            "convergence": tables.convergence(studies.convergence),
            "both_starts": both_starts(studies.both_starts),
            "prescribed": studies.prescribed and studies.converged and tables.prescribed(studies.prescribed, studies.converged),
        }
    return facts


def _convergence(points: Sequence[Point]) -> Plot | None:
    if not points:
        return None
    tightest = min(point.settings["tolerance"] for point in points)
    finest = [point for point in points[:-1] if point.settings["tolerance"] == tightest]
    series = []
    for name in ESTIMATED:
        errors = {point.settings["modes"]: error for point in finest if (error := point.error(name)) is not None}
        texts = [f"{modes} modes: {size(error)}" for modes, error in errors.items()]
        series.append(Series(name.replace("_", " "), name, [*errors], [100.0 * error for error in errors.values()], texts))
    return Plot("convergence.csv", "modes", "error, RMS over RMS [%]", series, "y")


def _saved(orbit_table: Table) -> dict[str, float] | None:
    """Median work of a direct search, in cycles, and the ratio of the cycles of marching to it."""
    keys = ("cycles_of_work", "cycles_to_settled", "cycles_to_gone")
    work, settled, gone = (np.array([row[key].value for row in orbit_table.rows], dtype=float) for key in keys)
    if not len(work):
        return None
    ratios = {"settled": settled / work, "gone": gone / work}
    return {"work": float(np.nanmedian(work)), "runs": len(work), **{name: float(np.nanmedian(ratio)) for name, ratio in ratios.items()}}
