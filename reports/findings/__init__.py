"""Numbers and verdicts computed from results, without layout."""
