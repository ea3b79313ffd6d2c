"""What all studies of methods share: one trial and its row, the truth of a scene, plans of what to try, and queries on the rows."""
