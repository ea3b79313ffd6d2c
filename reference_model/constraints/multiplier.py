"""The constraint by a Lagrange multiplier: index-1 form, stabilized (RIVALS.md, section 3)."""

from reference_model.compilation import inlined
from reference_model.constraints.gap import Gap
from reference_model.constraints.joint import CONSISTENT, Joint
from reference_model.constraints.solve import ideal_force
from reference_model.constraints.workspace import OpenWorkspace
from reference_model.parameters import Parameters


def multiplier(stabilization: float) -> Joint:
    """The multiplier is the slider force that makes gap'' = -2 rate gap' - rate^2 gap.

    Args:
        stabilization: the rate, 1/s; 0 leaves the drift as it comes.
    """
    return Joint(False, 0.0, 0.0, stabilization, CONSISTENT, 0.0)


@inlined
def multiplier_force(joint: Joint, p: Parameters, gap: Gap, w: OpenWorkspace) -> tuple[bool, float]:
    """Slider force (N) and accelerations, equation R3.1."""
    rate = joint.stabilization
    return ideal_force(p, w, -gap.remainder - 2.0 * rate * gap.rate - rate**2 * gap.value)
