"""Studies over a grid of machines: varied keys, measures, and rows of points; each point continues the one before."""
