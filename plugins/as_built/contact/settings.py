"""Settings of the chain of links, and the ladder of them."""

from dataclasses import dataclass
from typing import Final

from quickreturn.engines.ladder import Ladder
from quickreturn.engines.settings import Settings, setting


@dataclass(frozen=True, kw_only=True)
class ContactSettings(Settings):
    """Number of boxes, time step, time constant of the contact and armature."""

    links: int = setting(13, "number of links", low=4, high=90)
    step: float = setting(0.7, "largest time step, in units of the longest stable one of the straight chain", low=0.01, high=1.0)
    contact_time: float = setting(2.0, "time constant of the contact, in time steps (MuJoCo's solref)", low=2.0, high=1000.0)
    armature: float = setting(
        0.25, "inertia added to each hinge, in units of mass per length x link length^3; allows larger steps", low=0.0, high=100.0
    )


#: Links -> error of the tip deflection that they claim in run 24, damped by its material, over 2 s.
_CLAIMS: Final = {13: 8.7e-2, 20: 3.2e-2, 26: 1.3e-2, 40: 8.7e-3, 64: 2.2e-3}
LADDER: Final = Ladder(tuple((ContactSettings(links=links), claim) for links, claim in _CLAIMS.items()), size="links", order=1.8)
