"""Computed values beside published ones and closed forms that share nothing with the engines."""
