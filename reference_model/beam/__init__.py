"""Shapes of the follower's tangent angle, and their tables for compiled code."""
