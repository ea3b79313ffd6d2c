"""Settings of the link chain, and the ladder of them."""

from dataclasses import dataclass
from typing import Final

from quickreturn.engines.ladder import Ladder
from quickreturn.engines.settings import Settings as AnySettings
from quickreturn.engines.settings import setting

#: Armature of a hinge, by default and at most, in the unit of `ChainSettings.armature` (LADDERS.md, section 4, as for the ladder).
ARMATURE: Final = 7e-4
STIFFEST_ARMATURE: Final = 1.0
MOST_LINKS: Final = 256


@dataclass(frozen=True, kw_only=True)
class ChainSettings(AnySettings):
    """Number of links, time step and armature."""

    links: int = setting(13, "number of links, and of hinges", low=1, high=MOST_LINKS)
    step: float = setting(0.9, "largest time step, in units of the longest stable one of the straight chain", low=0.01, high=2.0)
    armature: float = setting(
        ARMATURE,
        "inertia added to each hinge, in units of mass per length x (link length x length)^1.5; allows larger steps",
        low=0.0,
        high=STIFFEST_ARMATURE,
    )


#: Links -> error of the tip deflection that they claim in most of the thesis' runs over 2 s.
_CLAIMS: Final = {
    3: 0.35, 4: 0.15, 5: 0.09, 6: 0.05, 9: 0.02, 11: 1e-2, 13: 5e-3, 16: 2.5e-3, 20: 1.3e-3, 23: 9e-4, 28: 5e-4, 34: 3e-4, 41: 2e-4,
    53: 9e-5, 64: 5e-5, 90: 2.5e-5,
}  # fmt: skip
LADDER: Final = Ladder(tuple((ChainSettings(links=links), claim) for links, claim in _CLAIMS.items()), size="links", order=2.5)
