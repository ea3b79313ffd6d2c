"""What could have made the thesis' finding: each effect by itself, at three strengths, in all 24 runs.

`effects` is what is changed, `response` brings a changed scene to its steady cycles and measures them, `study` holds them against the
scene as published.
"""
