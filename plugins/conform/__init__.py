"""Whether an adapter does what it says."""
