"""Cases: scenes with their units and data, the measures of their motion, and the runner that computes and stores results."""
