"""The chapters of the report, each a function from what is known to a `Chapter`."""
