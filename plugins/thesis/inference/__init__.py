"""What made the thesis find its frequencies right before the return and too high after it: one inference over all explanations together.

`unknowns` are what the thesis leaves open, `response` brings a machine to its steady cycles and reads them, `study` computes the points,
`emulator` interpolates them, `joint` adds what frozen modes say, `statements` read the thesis, and `weights` infer.
"""
