"""Makes the objects that a wheel brings along: `python -m quickreturn.reference_model.ship`, on Linux, whatever the processor.

They are written into the package, for all processors of one level, and serve as long as the sources are those that they are made from.
"""

import os
import shutil
import tempfile

from quickreturn.reference_model.native.cache_folder import SHIPPED, VARIABLE
from quickreturn.reference_model.native.objects import LEVEL

if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        # before the compiler is imported; no feature of this processor beyond those of the level
        os.environ.update({VARIABLE: folder, "NUMBA_CPU_NAME": LEVEL, "NUMBA_CPU_FEATURES": ""})
        from quickreturn.reference_model.entries import IMPLICIT_LOOP, KERNEL, LINEARISED, LOOP, OBSERVATIONS, STEPS, WEIGHED

        shutil.rmtree(SHIPPED, ignore_errors=True)
        SHIPPED.mkdir()
        for entry in (KERNEL, LOOP, OBSERVATIONS, STEPS, LINEARISED, WEIGHED, IMPLICIT_LOOP):
            entry.compiled()
            shutil.move(entry.path, entry.shipped)
            print(entry.shipped, entry.shipped.stat().st_size)
