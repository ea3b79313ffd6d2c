"""The pictures of the report: each function takes results and gives a `Picture`, or None where there is nothing to draw."""
