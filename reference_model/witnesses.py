"""The witness of an output: an independent computation that confirms it.

Two computations are independent if no file computes what is compared in both. A closed form counts, another engine with its own equations,
another package, or differences of another output.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TypeAlias


@dataclass(frozen=True)
class Witness:
    """An independent computation of an output, and how far the two differ."""

    by: str  # the independent computation, in words
    largest: float  # largest difference found, relative to the size of the output
    test: str  # the test that computes the difference, by its name in pytest


#: Witnesses of the fields of a result, by name. A field without one is given, not computed.
Witnesses: TypeAlias = Mapping[str, Witness]
