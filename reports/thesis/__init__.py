"""What a report says of the thesis. No module outside imports this package but the top, which passes `content_type` to the report."""
