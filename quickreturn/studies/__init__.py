"""Studies of one machine: which method, over its quantities, over one of them, and fitted to a table."""
