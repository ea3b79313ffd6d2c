"""Quick-returns as the users of other programs build them, with their packages alone."""
