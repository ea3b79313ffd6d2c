"""Templates of the chapters."""
