"""Ways of treating the constraint at the slider other than eliminating it: the equations are in `RIVALS.md`."""
