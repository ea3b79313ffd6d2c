"""Pictures: of the documents, and of recorded tables."""
