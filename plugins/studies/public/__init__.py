"""Public functions that study a machine, and their results."""
