"""What could have made the thesis' finding: each effect by itself, at three strengths, in all 24 runs.

`effects` declares what is changed, `response` brings a changed scene to its steady cycles and measures them, `study` holds them
against the scene as published.
"""

from cases.finding.effects import EFFECTS, Effect, Strength

__all__ = ["EFFECTS", "Effect", "Strength"]
