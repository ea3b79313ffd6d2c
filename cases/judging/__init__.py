"""Can it be trusted? Evidence of an engine in a scene, verdicts, and the matrix of engines and scenes."""
