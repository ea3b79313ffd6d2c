"""Recorded results of the long studies on the thesis, and the rows that record them (`reports.long_studies`)."""

from collections.abc import Sequence
from typing import Any

from quickreturn.cases.running.workshop import Workshop
from quickreturn.plugins.thesis import scatter, sharpness
from quickreturn.plugins.thesis import starts as other_starts
from quickreturn.plugins.thesis.finding import study
from quickreturn.reports.long_studies import table


def finding() -> list[study.Row]:
    """The changes by each effect in the thesis' runs."""
    return table("finding", study.Row)


def bands() -> list[scatter.Band]:
    """The bands of the thesis' runs over the scatter of unprinted quantities."""
    return table("unprinted", scatter.Band)


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
    """Rows of the changes by each effect."""
    return {"finding": study.study(workshop)}


def band_rows(workshop: Workshop) -> dict[str, Sequence[Any]]:
    """Rows of the bands."""
    return {"unprinted": scatter.bands(workshop)}
