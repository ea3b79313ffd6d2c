"""The rows that record the long studies on the thesis (`reports.long_studies`)."""

from collections.abc import Sequence
from typing import Any

from quickreturn.cases.running.workshop import Workshop
from quickreturn.plugins.thesis.inference import study
from quickreturn.plugins.thesis.inference.unknowns import points
from quickreturn.plugins.thesis.inference.weights import infer
from quickreturn.plugins.thesis.sharpness import planted
from quickreturn.plugins.thesis.starts import starts


def planted_rows(workshop: Workshop) -> dict[str, Sequence[Any]]:
    """Rows of planted errors."""
    return {"planted": planted(workshop)}


def start_rows(workshop: Workshop) -> dict[str, Sequence[Any]]:
    """Rows of other starts."""
    return {"starts": starts(workshop)}


def finding_rows(workshop: Workshop) -> dict[str, Sequence[Any]]:
    """Rows of the machines, and of two engines on the printed one and the likeliest ones."""
    rows = study.study(workshop)
    best = [points()[0], *infer(tuple(rows), {}).best] if rows else []
    return {"finding": rows, "finding_confirmed": study.confirmed(best, workshop)}
