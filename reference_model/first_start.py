"""The first start: while one process compiles the equations of motion, a second compiles what else an integration needs.

Compiling takes one core; with two the first start is shorter by almost half. If the second process cannot start, the first one compiles
what is missing, and only time is lost.
"""

import gc

if __name__ == "__main__":
    # here, for what stands at the head of a file that uses the compiler counts as compiled (`native.cache_folder`)
    from quickreturn.reference_model.entries import LOOP, OBSERVATIONS

    gc.disable()  # as engines.accurate has it while it compiles
    for entry in (OBSERVATIONS, LOOP):
        entry.compiled()
