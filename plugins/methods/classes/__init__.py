"""The fastest method for each class of machines: a measured map over dimensionless groups, and the place of a machine on it."""
