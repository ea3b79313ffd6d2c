"""Studies of a machine: sweeps over grids, scatter of quantities, calibration, and resonance curves."""
