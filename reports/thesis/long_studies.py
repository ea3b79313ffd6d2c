"""Recorded results of the long studies on the thesis; importing this registers them."""

from quickreturn.cases.thesis import scatter
from quickreturn.cases.thesis.finding import study
from quickreturn.reports.long_studies import STUDIES, table

STUDIES["finding"] = lambda workshop: {"finding": study.study(workshop)}
STUDIES["unprinted"] = lambda workshop: {"unprinted": scatter.bands(workshop)}


def finding() -> list[study.Row]:
    """The changes by each effect in the thesis' runs."""
    return table("finding", study.Row)


def bands() -> list[scatter.Band]:
    """The bands of the thesis' runs over the scatter of unprinted quantities."""
    return table("unprinted", scatter.Band)
