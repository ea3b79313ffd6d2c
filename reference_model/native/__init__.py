"""How equations become machine code: numba's options and cache, tuples passed by address, four numbers in one register."""
