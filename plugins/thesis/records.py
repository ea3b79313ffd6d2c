"""Recorded results of the long studies on the thesis, and the rows that record them (`reports.long_studies`)."""

from collections.abc import Sequence
from typing import Any

from quickreturn.cases.running.workshop import Workshop
from quickreturn.plugins.thesis import scatter
from quickreturn.plugins.thesis.finding import study
from quickreturn.reports.long_studies import table


def finding() -> list[study.Row]:
    """The changes by each effect in the thesis' runs."""
    return table("finding", study.Row)


def bands() -> list[scatter.Band]:
    """The bands of the thesis' runs over the scatter of unprinted quantities."""
    return table("unprinted", scatter.Band)


def finding_rows(workshop: Workshop) -> dict[str, Sequence[Any]]:
    """Rows of the changes by each effect."""
    return {"finding": study.study(workshop)}


def band_rows(workshop: Workshop) -> dict[str, Sequence[Any]]:
    """Rows of the bands."""
    return {"unprinted": scatter.bands(workshop)}
