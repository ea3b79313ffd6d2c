"""What several chapters, the first screen and commands read off results: differences between engines."""
