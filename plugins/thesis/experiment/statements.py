"""Statements of the thesis about simulation and experiment, in a form that numbers can confirm or contradict."""

import functools
import math
from dataclasses import dataclass
from typing import Literal

from quickreturn.cases.library.thesis.data import read_toml
from quickreturn.cases.library.thesis.runs import RUNS

Kind = Literal["relation", "frequency", "observation", "cause"]


@dataclass(frozen=True)
class Statement:
    """A statement of the thesis, read as a range of numbers."""

    id: str  # short name
    section: str  # of the thesis
    words: str  # the statement in our words
    kind: Kind  # "relation" (a ratio per run), "frequency" (a range in Hz), "observation" or "cause" (words only)
    quantity: str  # what is compared
    runs: tuple[int, ...]  # numbers of the runs that it is about
    low: float = -math.inf  # smallest value that the words mean, -inf if there is none
    high: float = math.inf  # largest value that the words mean, inf if there is none
    share: float = 1.0  # share of the runs that must show it


@functools.cache
def statements() -> tuple[Statement, ...]:
    """All statements in the order of the thesis."""
    listed = []
    for entry in read_toml("statements.toml")["statement"]:
        runs = tuple(RUNS) if entry["runs"] == "all" else tuple(range(entry["runs"][0], entry["runs"][1] + 1))
        listed.append(Statement(**entry | {"runs": runs}))
    return tuple(listed)
