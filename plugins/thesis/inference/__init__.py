"""What made the thesis find its frequencies right before the return and too high after it: one inference over all explanations together.

`unknowns` are what the thesis leaves open, `response` brings a machine to its steady cycles and reads them, `study` computes the machines,
`emulator` interpolates between them, `words` are what the thesis says, `weights` infer, with what frozen modes of run 24 say, and
the study also has two engines compute the likeliest machines.
"""
