"""Tables of the report: one description gives both the table in the page and the CSV file beside it; columns that chapters share."""
