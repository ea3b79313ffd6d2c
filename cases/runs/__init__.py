"""Runs: an engine is brought to its steady state on a scene, measured, and compared with the others."""
