"""Parameters that are not known exactly: the scatter of results due to them, and their fit to a recorded table."""
