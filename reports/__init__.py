"""The report: chapters, tables, plots and the page."""
