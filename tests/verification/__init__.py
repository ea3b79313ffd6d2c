"""Long verification, run by `make verify`; the report shows its outcome."""
