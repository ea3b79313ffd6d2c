"""Recorded results of the long studies on the thesis; importing this registers their code."""

from typing import Final

from quickreturn.cases.jobs.key import SIMULATION
from quickreturn.cases.thesis.finding.study import Row
from quickreturn.cases.thesis.scatter import Band
from quickreturn.reports.long_studies import CODE, table

_MEASURES: Final = ("quickreturn.cases.measures", "quickreturn.cases.runs")
CODE["finding"] = (*SIMULATION, "quickreturn.cases.thesis.finding", *_MEASURES)
CODE["unprinted"] = (
    *SIMULATION,
    "quickreturn.cases.thesis.scatter",
    "quickreturn.cases.uncertainty",
    "quickreturn.cases.sweep",
    *_MEASURES,
)


def finding() -> list[Row]:
    """The changes by each effect in the thesis' runs."""
    return table("finding", Row)


def bands() -> list[Band]:
    """The bands of the thesis' runs over the scatter of unprinted quantities."""
    return table("unprinted", Band)
