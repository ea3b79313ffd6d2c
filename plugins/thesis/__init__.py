"""The thesis: its words and numbers, the studies of what it saw, and chapters on them."""
