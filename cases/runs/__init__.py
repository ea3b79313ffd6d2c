"""Runs: an engine brought to its steady state on a scene, measured, and held against the others."""
