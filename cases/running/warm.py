"""Imported only by the fork server: numba's initialisation takes 0.4 s, which each worker would otherwise spend again."""

import numba

numba.njit("float64(float64)")(lambda x: x)
