"""Names the mistake behind wrong numbers: those of a column, a scene, a start or frequencies."""
