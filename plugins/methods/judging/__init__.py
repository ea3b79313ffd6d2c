"""Judges engines in hard scenes: evidence of an engine in a scene, verdicts, and the matrix of engines and scenes."""
