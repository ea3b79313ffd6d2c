"""`quickreturn.linearise`: the linear model of a case, about rest or about its settled cycle."""

import math
from collections.abc import Sequence
from types import NoneType
from typing import Final

from quickreturn.arguments import AnyCase, one_case
from quickreturn.cases.files.errors import Argument, CaseError, as_written
from quickreturn.plugins.linear.at_rest import about_rest
from quickreturn.plugins.linear.cycle import about_cycle
from quickreturn.plugins.linear.model import LinearModel

#: Number of natural modes, unless another is asked for, and the largest: about rest, and about the settled cycle.
AT_REST: Final = 10, 40
OF_CYCLE: Final = 5, 16


def linearise(
    case: AnyCase,
    inputs: str | Sequence[str],
    outputs: str | Sequence[str],
    crank_angle: float | None = None,
    *,
    cycle: bool = False,
    modes: int | None = None,
) -> LinearModel:
    """The linear model of a machine about rest: follower straight, no gravity, with the dampings of the scene; or about its settled cycle.

    At rest with the input `torque` the crank is free to turn, and its angle is a state. Otherwise it is held, as by `modes`.

    Args:
        case: a name, a path or a `Case`.
        inputs: one or several of `torque` (of the drive, all of it), `tool_force` (on the flexible end, along b2) and `base_torque` (on the
            follower's base at P; it frees the base of a follower alone); about the cycle keys of the case file, such as `crank.torque`.
        outputs: one or several columns of trajectories; about the cycle as the slider passes its farthest place.
        crank_angle: about which the machine moves, degrees; None: that of the start. About the cycle it has no meaning.
        cycle: whether the model is about the settled cycle, from turn to turn.
        modes: number of natural modes; None: 10 at rest, 5 about the cycle.

    Raises:
        CaseError: no such input or output, an invalid number of modes, or a crank angle that is of no use.
        Refusal: at rest friction, which sticks, a rigid follower, a torque on a crank whose speed is prescribed or that a spring turns;
            about the cycle a rigid follower, a joint that gives way or rubs.
        EngineTrouble: the machine has no settled cycle.
    """
    loaded, (usual, most) = one_case(case), OF_CYCLE if cycle else AT_REST
    count = usual if modes is None else modes
    if not (isinstance(count, int) and 1 <= count <= most):
        raise CaseError(Argument("modes"), None, as_written(modes), "cannot be", f"a whole number from 1 to {most} is accepted")
    if not isinstance(crank_angle, (float, int, NoneType)):
        raise CaseError(Argument("crank-angle"), None, as_written(crank_angle), "is no number", "give it in degrees, such as 90")
    if crank_angle is not None and (cycle or loaded.scene.crank is None or not math.isfinite(crank_angle)):
        why = "is of no use about a cycle" if cycle else "is no angle" if loaded.scene.crank else "is of no use without a crank"
        raise CaseError(Argument("crank-angle"), None, f"{crank_angle:g}", why, "leave it out")
    if cycle:
        return about_cycle(loaded, inputs, outputs, count)
    return about_rest(loaded, inputs, outputs, None if crank_angle is None else math.radians(crank_angle), count)
