"""Moving boundaries after Beale and Scott: a linear beam across the line from the pivot to the slider, on two domains that meet there."""
