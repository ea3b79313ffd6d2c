"""The material of the follower by its published bending stiffness."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from quickreturn.cases.files.units import in_si
from quickreturn.cases.library.thesis.data import read_toml
from quickreturn.cases.library.thesis.runs import run_case

#: Young's modulus of common wrought aluminium alloys, Pa: 6061 and 2024, 10.0 and 10.6 million psi.
ALUMINIUM: Final = (10.0e6 * in_si("psi"), 10.6e6 * in_si("psi"))


@dataclass(frozen=True)
class StiffnessReading:
    """Young's modulus that the published bending stiffness and the nominal section mean, compared with aluminium's."""

    published: str  # as printed
    modulus: float  # Young's modulus that follows, Pa
    below: tuple[float, float]  # relative distance below ordinary aluminium, least and greatest
    # relative reduction of EI that would undo the median excess of a frequency (which grows with its root); None without one
    needed: float | None


def stiffness_reading(excesses: Sequence[float]) -> StiffnessReading:
    """The reading; `excesses`: relative excess of the single cubic's frequency, one per half cycle."""
    modulus = run_case(24).scene.follower.elastic_modulus
    below = sorted(1.0 - modulus / ordinary for ordinary in ALUMINIUM)
    needed = 1.0 - (1.0 + float(np.median(excesses))) ** -2.0 if excesses else None
    return StiffnessReading(read_toml("scene.toml")["follower"]["bending_stiffness"], modulus, (below[0], below[1]), needed)
