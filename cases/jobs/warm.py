"""Imported by the fork server alone: what numba does before its first function takes 0.4 s, which each worker would spend anew."""

import numba

numba.njit("float64(float64)")(lambda x: x)
