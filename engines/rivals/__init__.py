"""Rival methods for the constraint and the moving load, on the same beam: `multiplier`, `stiff-spring` and `nodal-load`."""
