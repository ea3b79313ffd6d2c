"""The first start: while one process compiles the equations of motion, a second compiles what else an integration needs.

Compiling takes one core; with two the first start is shorter by two fifths. If the second process cannot start, or compiles for other types
than those needed, the first process compiles what is missing, and only time is lost.
"""

import gc
from typing import Any

from numba import types

from quickreturn.reference_model.compiled_state import STATE_TYPE
from quickreturn.reference_model.motion import inertia
from quickreturn.reference_model.motion.compiled_layout import PARAMETERS_TYPE, TABLES_TYPE, WORKSPACE_TYPE
from quickreturn.reference_model.native.pointers import At


def compiled_by_the_second() -> list[tuple[Any, tuple[types.Type, ...]]]:
    """Functions that the second process compiles, each with the types of its arguments."""
    at = tuple(map(At, (PARAMETERS_TYPE, TABLES_TYPE, WORKSPACE_TYPE)))
    return [
        (inertia.assemble, (*at, STATE_TYPE)),  # these four are the parts of the equations that the first process compiles last
        (inertia.bias_accelerations, (*at, STATE_TYPE)),
        (inertia.moment_about_pivot, at),
        (inertia.dissipation, (*at, STATE_TYPE)),
    ]


if __name__ == "__main__":
    # here, for what stands at the head of a file that uses the compiler counts as compiled (`native.cache_folder`)
    from quickreturn.reference_model.entries import LOOP, OBSERVATIONS

    gc.disable()  # as engines.accurate has it while it compiles
    for function, signature in compiled_by_the_second():
        function.compile(signature)
    for entry in (OBSERVATIONS, LOOP):
        entry.compiled()
