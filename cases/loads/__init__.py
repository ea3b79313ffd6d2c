"""What the parts of a machine must bear: stress along the arm, forces in joints and bearings, distance to resonance."""
