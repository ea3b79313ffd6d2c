"""An FMU as its description tells it, and what the file beside it declares."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

from quickreturn.engines.base import EstimateOf

#: Relative difference up to which values are the same: the rounding of a unit.
SAME: Final = 1e-9


@dataclass(frozen=True)
class Variable:
    """A variable of an FMU: SI value = factor x value of the variable + offset."""

    name: str
    reference: int  # FMI's value reference
    kind: str  # what FMI calls the functions that set and get it: Real, Integer, Boolean, Float64, ...
    factor: float = 1.0
    offset: float = 0.0


@dataclass(frozen=True)
class Fmu:
    """A file with its description."""

    path: str
    about: Any  # an `fmpy.model_description.ModelDescription` with co-simulation
    digest: str  # hash of the file
    fingerprint: str  # hash of the file and of the declarations

    @property
    def fmi(self) -> str:
        """The first digit of its version of FMI."""
        return str(self.about.fmiVersion[0])


@dataclass(frozen=True)
class Declarations:
    """What the file beside the FMU says of it; keys are those of a case file."""

    parameters: Mapping[str, tuple[Variable, ...]]  # by key, one for each number of its value
    fixed: Mapping[str, float | tuple[float, ...]]  # values that are built in, SI
    constants: tuple[tuple[Variable, Any], ...]  # values of the FMU's own parameters, as it takes them
    outputs: Mapping[str, Variable]  # by column
    steps: tuple[float, ...]  # s, coarse to fine
    errors: tuple[float, ...]  # of the tip deflection, for each step; empty if unknown
    order: float  # of the error in the step
    estimates: EstimateOf
    method: str


def steps_within(output_step: float, step: float) -> int:
    """Number of communication steps in an output step."""
    return max(1, math.ceil(output_step / step * (1.0 - SAME)))
