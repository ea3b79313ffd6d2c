"""The compiled functions that Python calls for a beam: its equations, the observables of its states, and the integrators."""

from typing import Final

from quickreturn.reference_model.native.objects import Entry

#: The equations of motion, and the observables of states.
KERNEL: Final = Entry("quickreturn.reference_model.motion.equations:kernel", 4 * "i")
OBSERVATIONS: Final = Entry("quickreturn.reference_model.motion.observe:observe_states", 8 * "i")
#: The linearised equations, and the product of the mass matrix with accelerations, for the implicit integrator; and that integrator.
LINEARISED: Final = Entry("quickreturn.reference_model.motion.linearisation:linearise", 4 * "i")
WEIGHED: Final = Entry("quickreturn.reference_model.motion.linearisation:weigh", 4 * "i")
IMPLICIT_LOOP: Final = Entry("quickreturn.reference_model.radau_loop:loop", "i")
#: The explicit integrator, and its steps in the crank angle.
LOOP: Final = Entry("quickreturn.reference_model.dop853_loop:loop", 6 * "i" + "fiii" + "fff" + "iiii")
STEPS: Final = Entry("quickreturn.reference_model.crank_angle_steps:steps_to", 5 * "i" + "fii")
