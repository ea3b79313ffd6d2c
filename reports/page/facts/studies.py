"""Accuracy beside cost."""

from collections.abc import Sequence
from typing import Any, Final

import numpy as np

from quickreturn.cases.runs.comparison import REFERENCE
from quickreturn.cases.studies import StudiedRun
from quickreturn.engines.error_parts import ESTIMATED
from quickreturn.reports.findings.agreement import engines_of
from quickreturn.reports.page.content import Content
from quickreturn.reports.page.plot import Plot, Series
from quickreturn.reports.tables import studies as tables
from quickreturn.reports.tables.orbits import GONE_AT, SETTLED_AT, both_starts, orbits
from quickreturn.reports.tables.table import Table
from quickreturn.reports.words import size

#: What two solutions may differ by to confirm each other.
CONFIRMED: Final = 5e-4


def accuracy(content: Content) -> dict[str, Any] | None:
    """None for a report on other cases than the thesis' runs, where no steady state was found directly either."""
    studies = content.studies
    marching = [name for name in engines_of(content.results) if name != REFERENCE]
    found = orbits(content.results, marching)
    if studies is None and not found.rows:
        return None
    facts: dict[str, Any] = {
        "studies": studies,
        "confirmed": CONFIRMED,
        "saved": _saved(found),
        "settled_at": SETTLED_AT,
        "gone_at": GONE_AT,
        "orbits": found,
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
        }
    return facts


def _convergence(runs: Sequence[StudiedRun]) -> Plot | None:
    if not runs:
        return None
    tightest = min(run.settings["tolerance"] for run in runs)
    finest = [run for run in runs if run.settings["tolerance"] == tightest and not run.is_reference]
    modes = [run.settings["modes"] for run in finest]
    series = []
    for name in ESTIMATED:
        errors = [run.errors[name] for run in finest]
        texts = [f"{n} modes: {size(error)}" for n, error in zip(modes, errors, strict=True)]
        series.append(Series(name.replace("_", " "), name, modes, [100.0 * error for error in errors], texts))
    return Plot("convergence.csv", "modes", "error, RMS over RMS [%]", series, "y")


def _saved(found: Table) -> dict[str, float] | None:
    """Work of a direct search, in cycles, and how many times as many marching takes, in the median."""
    keys = ("cycles_of_work", "cycles_to_settled", "cycles_to_gone")
    work, settled, gone = (np.array([row[key].value for row in found.rows], dtype=float) for key in keys)
    if not len(work):
        return None
    ratios = {"settled": settled / work, "gone": gone / work}
    return {"work": float(np.nanmedian(work)), "runs": len(work), **{name: float(np.nanmedian(ratio)) for name, ratio in ratios.items()}}
