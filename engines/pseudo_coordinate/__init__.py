"""Engines `thesis`, `fixed-shapes` and `reference`: the explicit models of `reference_model` behind the engine interface."""
