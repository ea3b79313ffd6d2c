"""The report: findings from results, tables, plots and the page."""
