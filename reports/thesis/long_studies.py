"""Recorded results of the long studies on the thesis; importing this registers them."""

from quickreturn.cases.thesis.finding.study import Row
from quickreturn.cases.thesis.scatter import Band
from quickreturn.reports.long_studies import STUDIES, table

STUDIES.extend(("finding", "unprinted"))


def finding() -> list[Row]:
    """The changes by each effect in the thesis' runs."""
    return table("finding", Row)


def bands() -> list[Band]:
    """The bands of the thesis' runs over the scatter of unprinted quantities."""
    return table("unprinted", Band)
