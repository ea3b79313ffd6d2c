"""Which method for which class of machines: a map over dimensionless groups, measured, and where a machine lies on it."""
