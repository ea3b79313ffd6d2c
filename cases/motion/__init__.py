"""Motion: an engine is brought to its steady state, and a cycle is measured, simulated and measured signals alike.

Pre-return is the half in which the slider travels from its farthest to its nearest place, post-return the way back, whatever the
crank's direction; a cycle starts farthest, at a crank angle of 180°. A half holds three to six oscillations of a first mode whose
frequency drifts with the crank angle, on a large slow part: the measures fit the drifting oscillation, on the time scale of the mechanism
itself.
"""
