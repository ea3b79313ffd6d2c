"""Settings of the link chain, and the ladder of them."""

from dataclasses import dataclass
from typing import Final

from engines.base import Comparison
from engines.ladder import Ladder
from engines.settings import Settings as AnySettings
from engines.settings import setting

#: Inertia of the hinges in units of the links' (LADDERS.md, section 4, has what was measured for this and all that follows).
ARMATURE: Final = 7e-4
#: Where the first bending frequency is more than this many times the crank's, the follower's fast modes follow its load nearly at rest. The
#: hinges then bear an armature that grows with the square of the ratio for the same error, and the step with the ratio.
STIFF: Final = 20.0
STIFFEST_ARMATURE: Final = 1.0

#: Parts of the links with which a chain is compared, and the order that is counted on. The slider, as it passes from link to link, shakes
#: each chain in its own way, so that one difference alone may vanish by accident; where it passes them at the rate of a natural frequency
#: the error does not fall with their number.
COARSER: Final = (2.0 / 3.0, 3.0 / 4.0)
SAFE_ORDER: Final = 2.0

#: Fewer links than these have no order yet. They are compared with a finer chain, whose error is taken to be a third.
FEWEST_WITH_ORDER: Final = 12
FINER: Final = (18, 1.0 / 3.0)


@dataclass(frozen=True, kw_only=True)
class ChainSettings(AnySettings):
    """How finely the follower is cut and how far a step goes."""

    links: int = setting(13, "number of links, and of hinges", low=1, high=256)
    step: float = setting(0.0, "largest time step; 0: what the chain's highest frequency allows", unit="s", low=0.0, high=0.01)
    armature: float = setting(
        ARMATURE,
        "inertia added to each hinge, in units of mass per length x (link length x length)^1.5; allows larger steps",
        low=0.0,
        high=STIFFEST_ARMATURE,
    )


#: Links and what they claim of the tip deflection in run 24.
_CLAIMS: Final = {12: 7.1e-3, 13: 6.0e-3, 15: 2.9e-3, 18: 2.9e-3, 22: 1.5e-3, 27: 1.4e-3, 33: 6.3e-4, 40: 3.0e-4, 64: 9.7e-5, 90: 4.9e-5}
LADDER: Final = Ladder(tuple((ChainSettings(links=links), claim) for links, claim in _CLAIMS.items()), size="links", order=2.5)


def for_accuracy(accuracy: float, ratio: float = 0.0) -> ChainSettings:
    """The cheapest rung whose claim in run 24 is within `accuracy`; larger steps where the follower is stiff.

    Args:
        accuracy: error of the tip deflection.
        ratio: first bending frequency over the crank's (`natural_modes.stiffness_ratio`).
    """
    return LADDER.pick(accuracy).replaced(armature=min(ARMATURE * max(1.0, ratio / STIFF) ** 2, STIFFEST_ARMATURE))


def comparisons(settings: ChainSettings) -> tuple[Comparison, ...]:
    """Two coarser chains, or a finer one for a chain too coarse for that. The step, bound to stability, leaves no error of its own."""
    if settings.links < FEWEST_WITH_ORDER:
        links, factor = FINER
        return (Comparison(settings, settings.replaced(links=links), factor),)
    return tuple(Comparison(settings, settings.replaced(links=round(part * settings.links)), part**-SAFE_ORDER) for part in COARSER)
