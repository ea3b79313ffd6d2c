"""Comparison: engines with each other, and recorded tables with engines."""
