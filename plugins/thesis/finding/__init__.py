"""Possible causes of the thesis' finding: each effect by itself, at three strengths, in all 24 runs.

`effects` changes a scene, `response` brings it to its steady cycles and measures them, `study` compares them with the scene as published.
"""
