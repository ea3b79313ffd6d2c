"""The chapter on the drive, and templates."""
