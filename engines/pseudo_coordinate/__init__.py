"""Engines `thesis` and `reference`: the hand-derived explicit model of `reference_model` behind the engine interface."""
