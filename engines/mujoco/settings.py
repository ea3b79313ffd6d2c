"""Settings of the link chain, and the ladder of them."""

from dataclasses import dataclass
from typing import Final

from quickreturn.engines.ladder import Ladder
from quickreturn.engines.settings import Settings as AnySettings
from quickreturn.engines.settings import setting

#: Armature of a hinge, by default and at most, in the unit of `ChainSettings.armature` (LADDERS.md, section 4, as for the ladder).
ARMATURE: Final = 7e-4
STIFFEST_ARMATURE: Final = 1.0


@dataclass(frozen=True, kw_only=True)
class ChainSettings(AnySettings):
    """Number of links, time step and armature."""

    links: int = setting(13, "number of links, and of hinges", low=1, high=256)
    step: float = setting(0.0, "largest time step; 0: what the chain's fastest rate allows", unit="s", low=0.0, high=0.01)
    armature: float = setting(
        ARMATURE,
        "inertia added to each hinge, in units of mass per length x (link length x length)^1.5; allows larger steps",
        low=0.0,
        high=STIFFEST_ARMATURE,
    )


#: Links -> error of the tip deflection that they claim in run 24 over 2 s.
_CLAIMS: Final = {12: 7.1e-3, 13: 6.0e-3, 15: 2.9e-3, 18: 2.9e-3, 22: 1.5e-3, 27: 1.4e-3, 33: 6.3e-4, 40: 3.0e-4, 64: 9.7e-5, 90: 4.9e-5}
LADDER: Final = Ladder(tuple((ChainSettings(links=links), claim) for links, claim in _CLAIMS.items()), size="links", order=2.5)
