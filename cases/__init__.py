"""Cases: scenes with their units and data, the measures taken of them, and the runner that computes and keeps results."""
