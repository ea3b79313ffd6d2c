"""What the results say: numbers and verdicts computed from them, without a word of layout."""
