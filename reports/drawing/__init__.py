"""Pictures by matplotlib: of cases, trajectories, studies and recorded tables, and those of the documents.

Importing a module of this package raises MissingExtra if matplotlib is not installed.
"""

from quickreturn.reports.output import require

require("plot", "a picture")
