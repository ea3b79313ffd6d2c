"""Settings of the link chain, and the ladder of them."""

from dataclasses import dataclass
from typing import Final

from engines.base import Comparison
from engines.ladder import Ladder
from engines.settings import Settings as AnySettings
from engines.settings import setting

#: Inertia of the hinges in units of the links'. In run 24 it lets 64 links run at a step of 1e-4 s for 0.01 % more error.
ARMATURE: Final = 7e-4
#: Where the first bending frequency is more than this many times the crank's, the follower's fast modes follow its load nearly at rest. The
#: hinges then bear an armature that grows with the square of the ratio for the same error, and the step with the ratio. In nine machines
#: (ratios 55 to 1700) it leaves 1e-5 to 5e-4 with and without, in a fifth of the steps and less.
STIFF: Final = 20.0
STIFFEST_ARMATURE: Final = 1.0

#: Parts of the links with which a chain is compared. The estimate is the sum of what the two pairs show: the slider, as it passes from link
#: to link, shakes each chain in its own way, so that one difference alone may vanish by accident. Where the links' rate meets a natural
#: frequency the error does not fall with their number at all (a soft machine: 18, 22 and 25 links leave 1.2, 1.5 and 1.2e-3; an aluminium
#: shaper: 8, 9 and 12 leave 1.6, 6.3 and 5.7e-4 of the acceleration). So no more than the second order counts, though run 24 converges with
#: 2.5: over 58 scenes (the library and 34 machines), six columns and 12 to 90 links the sum is above the error in 98.5 % of 819 cases, 1.34
#: times too small at worst and 3.6 times the error in the median; with 2.4 for the coarser chain it was 1.58 times too small at worst.
COARSER: Final = (2.0 / 3.0, 3.0 / 4.0)
SAFE_ORDER: Final = 2.0

#: Fewer links than these have no order yet: thesis' run 09 errs more with 8 than with 6. They are compared with a finer chain, whose
#: error is taken to be a third; theirs is 1.6 times the difference at most in 96 % of those scenes, and equal to it in the median.
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


#: Links and what they claim of the tip deflection in run 24 (standard start, 2 s, every 1 ms). Against `reference` with 13 modes the
#: errors are 2.1e-3, 9.2e-4, 7.2e-4, 6.6e-4, 4.9e-4, 2.4e-4, 1.3e-4, 8.7e-5, 3.3e-5 and 1.9e-5.
_CLAIMS: Final = {12: 7.1e-3, 13: 6.0e-3, 15: 2.9e-3, 18: 2.9e-3, 22: 1.5e-3, 27: 1.4e-3, 33: 6.3e-4, 40: 3.0e-4, 64: 9.8e-5, 90: 4.9e-5}
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
