"""Computes the pack's problems anew, each by formulations of different origin."""
