"""How equations become machine code: numba's options and cache, tuples by their address, four numbers in one register."""
