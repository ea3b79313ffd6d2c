"""The constraint as a transverse spring and damper at the moving point (RIVALS.md, section 4)."""

from reference_model.compilation import inlined
from reference_model.constraints.gap import Gap
from reference_model.constraints.joint import CONSISTENT, Joint
from reference_model.constraints.solve import given_force
from reference_model.constraints.workspace import OpenWorkspace
from reference_model.parameters import Parameters


def stiff_spring(stiffness: float, damping: float) -> Joint:
    """A spring (N/m) and a damper (N s/m) along the follower's normal at the foot of the crank tip."""
    return Joint(True, stiffness, damping, 0.0, CONSISTENT, 0.0)


@inlined
def spring_force(joint: Joint, p: Parameters, gap: Gap, w: OpenWorkspace) -> tuple[bool, float]:
    """Slider force (N) and accelerations, equation R4.1."""
    force = joint.stiffness * gap.value + joint.damping * gap.rate
    return given_force(p, w, force), force
