"""HTML templates of the report and its style."""
