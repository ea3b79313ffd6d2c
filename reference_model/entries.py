"""The compiled functions that Python calls for a beam: its equations, the observables of its states, and two integrators."""

from typing import Final

from quickreturn.reference_model.native.objects import Entry

#: The equations of motion, and the observables of states.
KERNEL: Final = Entry("quickreturn.reference_model.motion.equations:kernel", 4 * "i")
OBSERVATIONS: Final = Entry("quickreturn.reference_model.motion.observe:observe_states", 8 * "i")
#: The integrator, and its steps in the crank angle.
LOOP: Final = Entry("quickreturn.reference_model.dop853_loop:loop", 6 * "i" + "fiii" + "fff" + "iiii")
STEPS: Final = Entry("quickreturn.reference_model.crank_angle_steps:steps_to", 5 * "i" + "fii")
