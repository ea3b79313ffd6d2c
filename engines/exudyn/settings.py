"""Settings of the `exudyn` engine and the ladder from accuracy to settings."""

from dataclasses import dataclass
from typing import Final

from engines.settings import Settings, setting

FEWEST_ELEMENTS: Final = 6
LARGEST_STEP: Final = 5e-3  # s


@dataclass(frozen=True, kw_only=True)
class ExudynSettings(Settings):
    """Discretization in space and time; second order in both."""

    elements: int = setting(16, "ANCF cable elements along the follower", low=FEWEST_ELEMENTS, high=96)
    step: float = setting(3e-4, "largest step of the time integration; the output step is divided evenly", unit="s", low=1e-5, high=LARGEST_STEP)
    spectral_radius: float = setting(0.9, "generalized-alpha: damping of the highest frequencies, 1 is none", low=0.5, high=0.95)
    newton_tolerance: float = setting(1e-6, "relative residual at which Newton's iteration stops", low=1e-10, high=1e-4)


#: Error of the tip deflection in run 24's first 2 s -> elements, step in s (measured against 64 elements, 2.5e-5 s).
LADDER: Final = (
    (5e-2, 8, 1e-3),
    (1e-2, 12, 5e-4),
    (3e-3, 16, 2.5e-4),
    (1e-3, 32, 1.25e-4),
    (3e-4, 48, 6.25e-5),
    (1e-4, 64, 4e-5),
)


def settings_for(accuracy: float) -> ExudynSettings:
    """Cheapest rung of the ladder whose error is at most `accuracy`, or the finest one."""
    for error, elements, step in LADDER:
        if error <= accuracy * (1.0 + 1e-9):
            return ExudynSettings(elements=elements, step=step)
    return ExudynSettings(elements=LADDER[-1][1], step=LADDER[-1][2])
