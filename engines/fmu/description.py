"""An FMU as its description tells it, and what the file beside it declares."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from quickreturn.engines.base import EstimateOf

#: Relative difference up to which values are the same: the rounding of a unit.
SAME: Final = 1e-9


@dataclass(frozen=True)
class Variable:
    """A variable of an FMU: SI value = factor x value of the variable + offset."""

    name: str
    reference: int  # FMI's value reference
    kind: str  # type of the variable in the FMU: Real, Integer, Float64, ...
    factor: float = 1.0
    offset: float = 0.0


@dataclass(frozen=True)
class Fmu:
    """A file, as its description says."""

    path: str
    fmi: str  # "2" or "3"
    identifier: str  # name of its library
    token: str  # identifies the description to the library
    maker: str  # the tool that exported it
    states: int  # number of its continuous states
    once: bool  # whether a process can hold only one instance
    fingerprint: str  # hash of the file and of the declarations


@dataclass(frozen=True)
class Declarations:
    """What the file beside the FMU says of it; keys are those of a case file."""

    parameters: Mapping[str, tuple[Variable, ...]]  # by key, one for each number of its value
    fixed: Mapping[str, float | tuple[float, ...]]  # values that are built in, SI
    constants: tuple[tuple[Variable, float], ...]  # values of the FMU's own parameters, in its unit
    outputs: Mapping[str, Variable]  # by column
    steps: tuple[float, ...]  # s, coarse to fine
    errors: tuple[float, ...] = ()  # of the tip deflection, for each step; empty if unknown
    order: float = 1.0  # of the error in the step
    estimates: EstimateOf = "integration"
    method: str = ""


def steps_within(output_step: float, step: float) -> int:
    """Number of communication steps in an output step."""
    return max(1, math.ceil(output_step / step * (1.0 - SAME)))
