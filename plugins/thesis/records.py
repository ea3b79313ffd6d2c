"""Recorded results of the long studies on the thesis, and the rows that record them (`reports.long_studies`)."""

from collections.abc import Sequence
from typing import Any

from quickreturn.cases.running.workshop import Workshop
from quickreturn.plugins.thesis import sharpness
from quickreturn.plugins.thesis import starts as other_starts
from quickreturn.plugins.thesis.inference import study
from quickreturn.plugins.thesis.inference.unknowns import points
from quickreturn.plugins.thesis.inference.weights import infer
from quickreturn.reports.long_studies import table


def finding() -> list[study.Row]:
    """The machines of the inference."""
    return table("finding", study.Row)


def confirmed() -> list[study.Confirmation]:
    """Two engines on the likeliest machines."""
    return table("finding_confirmed", study.Confirmation)


def planted() -> list[sharpness.Planted]:
    """In how many runs errors of each size are found."""
    return table("planted", sharpness.Planted)


def starts() -> list[other_starts.Start]:
    """Settled cycles from other starts."""
    return table("starts", other_starts.Start)


def planted_rows(workshop: Workshop) -> dict[str, Sequence[Any]]:
    """Rows of planted errors."""
    return {"planted": sharpness.planted(workshop)}


def start_rows(workshop: Workshop) -> dict[str, Sequence[Any]]:
    """Rows of other starts."""
    return {"starts": other_starts.starts(workshop)}


def finding_rows(workshop: Workshop) -> dict[str, Sequence[Any]]:
    """Rows of the machines, and of two engines on the printed one and the likeliest ones."""
    rows = study.study(workshop)
    best = [points()[0], *infer(tuple(rows), {}).best] if rows else []
    return {"finding": rows, "finding_confirmed": study.confirmed(best, workshop)}
