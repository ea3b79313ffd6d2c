"""Pictures by matplotlib: of cases, trajectories, studies and recorded tables, and those of the documents."""
