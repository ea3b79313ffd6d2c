"""Jobs: what is to be computed, in processes of its own, named by one key, kept in one store."""
