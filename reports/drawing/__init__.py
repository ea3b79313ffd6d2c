"""Pictures for the documents and of recorded tables."""
