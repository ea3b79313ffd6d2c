"""Running: jobs in separate processes, each with a key, their results in one store."""
