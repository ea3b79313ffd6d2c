"""The page: what moves on its first screen, its chapters, and how they become one file."""
