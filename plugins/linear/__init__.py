"""Linear models of a machine with inputs and outputs: state space, poles, Bode plot."""
