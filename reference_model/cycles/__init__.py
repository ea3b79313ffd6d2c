"""The steady cycle: the map over a turn of the crank, its fixed points, and how they move with a parameter."""
