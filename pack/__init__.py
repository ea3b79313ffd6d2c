"""Reference results of flexible mechanisms, with bounds and checkers that need nothing else of this project."""
