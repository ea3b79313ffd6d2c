"""Settings of the link chain, and the ladder of them."""

from dataclasses import dataclass

from engines.base import Refusal
from engines.settings import Settings as AnySettings
from engines.settings import setting

#: Links and the error of the tip deflection that they leave in run 24 (standard start, 2 s, every 1 ms), measured against 64 links
#: without armature; the last one from its difference to the one before.
LADDER = ((8, 3.9e-3), (12, 2.1e-3), (18, 6.6e-4), (27, 2.3e-4), (40, 9e-5), (60, 4.5e-5), (90, 2e-5))

#: Order at which the error is taken to fall with the number of links. Measured: 1.6 to 2.9 between rungs. The chain itself is of
#: order 4, the slider passing from link to link is not.
ORDER = 2.5
_RATIO = 1.5  # of the links from rung to rung


@dataclass(frozen=True, kw_only=True)
class ChainSettings(AnySettings):
    """How finely the follower is cut and how far a step goes."""

    links: int = setting(12, "number of links, and of hinges", low=1, high=256)
    step: float = setting(0.0, "largest time step; 0: what the chain's highest frequency allows", unit="s", low=0.0, high=0.01)
    armature: float = setting(
        7e-4,
        "inertia added to each hinge, in units of mass per length x (link length x length)^1.5; allows larger steps",
        low=0.0,
        high=0.1,
    )


def for_accuracy(accuracy: float) -> ChainSettings:
    """The cheapest rung whose error in run 24 is at most 0.55 of `accuracy` (the estimate exceeds the error up to 1.8-fold)."""
    enough = [links for links, error in LADDER if error <= 0.55 * accuracy]
    return ChainSettings(links=enough[0] if enough else LADDER[-1][0])


def coarser(settings: ChainSettings) -> tuple[ChainSettings, float]:
    """Two thirds of the links, and the factor by which the error grows.

    Raises:
        Refusal: there is but one link.
    """
    if settings.links == 1:
        raise Refusal("engine.links: 1 leaves no coarser chain to estimate the error from; give 2 or more")
    links = max(round(settings.links / _RATIO), 1)
    return settings.replaced(links=links), (settings.links / links) ** ORDER


def finer(settings: ChainSettings) -> ChainSettings | None:
    """The next rung with more links, None above the ladder."""
    above = [links for links, _ in LADDER if links > settings.links]
    return settings.replaced(links=above[0]) if above else None


def own(settings: AnySettings) -> ChainSettings:
    """The settings, known to be this engine's."""
    if not isinstance(settings, ChainSettings):
        raise TypeError(f"engine mujoco takes ChainSettings, not {type(settings).__name__}")
    return settings
