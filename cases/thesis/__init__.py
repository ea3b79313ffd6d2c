"""The thesis: its 24 runs as cases, its words and numbers, and the studies of what it saw. No module outside imports this package.

The entry-point group `quickreturn.cases` registers the runs with the library.
"""
