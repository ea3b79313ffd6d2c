"""Jobs: computations in separate processes, each with a key, stored in one store."""
