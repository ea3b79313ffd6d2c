"""Files: cases, quantities with units, and tables as text; read, changed and written, with messages about their mistakes."""
