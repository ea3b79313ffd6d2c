"""The text of a case file: read, changed and written, with messages about its mistakes."""
