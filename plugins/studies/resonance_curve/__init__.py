"""The periodic motion of a machine over one of its quantities."""
