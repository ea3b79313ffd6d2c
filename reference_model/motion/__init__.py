"""The equations of motion of one beam in the angle of its tangent, compiled once for all shapes and slider constraints."""
