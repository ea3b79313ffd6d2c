"""The engines whose equations are this project's own: `thesis`, `reference`, and the rivals on the same beam."""
