"""An FMU as its description and the file beside it tell it."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

#: Relative difference up to which values are the same: the rounding of a unit.
SAME: Final = 1e-9


@dataclass(frozen=True)
class Variable:
    """A variable of an FMU: SI value = factor x value of the variable + offset."""

    name: str
    reference: int  # FMI's value reference
    kind: str  # its type as FMI calls it, as do the functions that get it: Real, Float64, Float32
    factor: float
    offset: float


@dataclass(frozen=True)
class Fmu:
    """An FMU, and what the file beside it declares; keys are those of a case file."""

    path: str  # of the FMU
    about: Any  # an `fmpy.model_description.ModelDescription` with co-simulation
    digest: str  # hash of the FMU
    fingerprint: str  # hash of the FMU and of the declarations
    method: str
    parameters: Mapping[str, tuple[Variable, ...]]  # by key, one for each number of its value
    fixed: Mapping[str, float | tuple[float, ...]]  # values that are built in, SI
    constants: Mapping[str, Any]  # values of the FMU's own parameters by their names
    outputs: Mapping[str, Variable]  # by column
    steps: tuple[float, ...]  # s, coarse to fine

    @property
    def fmi(self) -> str:
        """The first digit of its version of FMI."""
        return str(self.about.fmiVersion[0])


def steps_within(output_step: float, step: float) -> int:
    """Number of communication steps in an output step."""
    return max(1, math.ceil(output_step / step * (1.0 - SAME)))
