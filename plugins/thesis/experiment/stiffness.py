"""The material of the follower by its published bending stiffness."""

from typing import Final

from quickreturn.cases.files.units import in_si
from quickreturn.cases.library.thesis.runs import run_case

#: Young's modulus of common wrought aluminium alloys, Pa: 6061 and 2024, 10.0 and 10.6 million psi.
ALUMINIUM: Final = (10.0e6 * in_si("psi"), 10.6e6 * in_si("psi"))


def below_aluminium() -> tuple[float, float]:
    """Relative distance of the modulus that the printed stiffness and the nominal section mean below aluminium's, least and greatest."""
    low, high = sorted(1.0 - run_case(24).scene.follower.elastic_modulus / ordinary for ordinary in ALUMINIUM)
    return low, high
