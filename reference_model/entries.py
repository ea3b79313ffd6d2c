"""The compiled functions that Python calls for a beam: its equations, the observables of its states, and the integrators.

`python -m quickreturn.reference_model.entries` makes the objects that a wheel brings along, on Linux, whatever the processor. They are
written into the package, for all processors of one level, and serve as long as the sources are those that they are made from.
"""

import os
import shutil
import tempfile
from typing import Final

from quickreturn.reference_model.native.cache_folder import SHIPPED, VARIABLE
from quickreturn.reference_model.native.objects import LEVEL, Entry

#: The equations of motion, and the observables of states.
KERNEL: Final = Entry("quickreturn.reference_model.motion.equations:kernel", 4 * "i")
OBSERVATIONS: Final = Entry("quickreturn.reference_model.motion.observe:observe_states", 8 * "i")
#: The linearised equations, and the product of the mass matrix with accelerations, for the implicit integrator; and that integrator.
LINEARISED: Final = Entry("quickreturn.reference_model.motion.linearisation:linearise", 4 * "i")
WEIGHED: Final = Entry("quickreturn.reference_model.motion.linearisation:weigh", 4 * "i")
IMPLICIT_LOOP: Final = Entry("quickreturn.reference_model.radau_loop:loop", "i")
#: The explicit integrator, and its steps in the crank angle.
LOOP: Final = Entry("quickreturn.reference_model.dop853_loop:loop", 6 * "i" + "fiii" + "fff" + "iiii")
STEPS: Final = Entry("quickreturn.reference_model.dop853_loop:steps_to", 5 * "i" + "fii")

if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        # before the compiler is imported; no feature of this processor beyond those of the level
        os.environ.update({VARIABLE: folder, "NUMBA_CPU_NAME": LEVEL, "NUMBA_CPU_FEATURES": ""})
        shutil.rmtree(SHIPPED, ignore_errors=True)
        SHIPPED.mkdir()
        for entry in (KERNEL, LOOP, OBSERVATIONS, STEPS, LINEARISED, WEIGHED, IMPLICIT_LOOP):
            entry.compiled()
            shutil.move(entry.path, entry.shipped)
            print(entry.shipped, entry.shipped.stat().st_size)
