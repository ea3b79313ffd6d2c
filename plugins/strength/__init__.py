"""What a machine bears and needs: stress along the arm, safety, forces in joints and bearings, the drive, and what happens in a turn."""
