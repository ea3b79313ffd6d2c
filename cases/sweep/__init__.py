"""Studies over a grid of machines: what varies, what is measured, and rows of points of which each continues the one before."""
