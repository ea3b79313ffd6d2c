"""The 24 runs of the thesis as cases: published numbers, and where these contradict each other."""
