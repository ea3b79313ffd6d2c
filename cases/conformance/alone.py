"""Checks of the follower alone, if the engine models it: its columns, and its quantities one by one."""

import functools
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any, Final

from quickreturn.cases.conformance.bench import DECISIVE, Bench, Motion, compared_columns, truth
from quickreturn.cases.conformance.checks import Check, Fault, check_by, some
from quickreturn.cases.conformance.models import acts_as_if
from quickreturn.cases.conformance.motion import findings
from quickreturn.cases.conformance.quantities import followed, tell_of_rows
from quickreturn.cases.conformance.scenes import BASE, Change
from quickreturn.cases.conformance.scenes import CHANGES as IN_A_MECHANISM
from quickreturn.cases.mistakes.diagnosis import share_of
from quickreturn.engines.base import EngineFailure, Refusal
from quickreturn.engines.scene import check_scene
from quickreturn.reference_model.mechanism import FollowerAlone, SpinUp
from quickreturn.reference_model.scene_values import changed

DURATION: Final = 0.6  # s: the base has turned steadily for a while
#: The mild scene's follower on a turning base: it bends by a hundredth of its length.
SCENE: Final = FollowerAlone(spin_up=SpinUp(speed=6.0, time=0.4), base=BASE.base, follower=BASE.follower, tip=BASE.tip)
#: The same without a body at the end, for an engine that models none.
BARE: Final = replace(SCENE, tip=None)
_EVERYTHING: Final[Mapping[str, Any]] = {
    "tip.mass": 0.08, "tip.inertia": 8e-4, "tip.center_of_mass": 0.05, "follower.damping": 2.0, "mechanism.gravity": (4.0, -7.0)
}  # fmt: skip
#: Every quantity of a follower alone, except those without effect on the columns; of most the change is that in a mechanism.
_AS_IN_A_MECHANISM: Final = (
    "mechanism.gravity along n1", "mechanism.gravity along n2", "follower.length", "follower.mass_per_length", "follower.bending_stiffness",
    "follower.damping", "follower.material_damping", "tip.mass", "tip.inertia", "tip.center_of_mass",
)  # fmt: skip
CHANGES: Final = (
    Change("base.spin_up_speed", {"base.spin_up_speed": 8.0}, duration=DURATION),
    Change("base.spin_up_time", {"base.spin_up_time": 0.3}, duration=DURATION),
    *(replace(change, alike={}, duration=DURATION) for change in IN_A_MECHANISM if change.name in _AS_IN_A_MECHANISM),
)


def alone(bench: Bench) -> Iterator[Check]:
    """All checks of the follower alone; a single check that says so if the engine does not model it."""
    scene, changes = SCENE, CHANGES
    try:
        check_scene(bench.engine, SCENE)
    except Refusal as refusal:
        try:
            check_scene(bench.engine, BARE)
        except Refusal:
            yield Check("the follower alone", "passed", f"refused: {refusal}")
            return
        scene, changes = BARE, tuple(change for change in CHANGES if not change.name.startswith("tip."))
    told = set[str]()
    check = check_by("the follower alone", _columns, bench, scene, told)
    yield check
    if check.status == "failed" and not told:
        yield Check("the follower alone: quantities", "not judged", "its motion is wrong already", "mend that first")
        return
    look = functools.partial(followed, wrong=False, told=told)
    checks = [check_by(f"the follower alone: {change.name}", look, bench, scene, change) for change in changes]
    yield from checks
    words = "the follower alone, with everything on"
    if any(check.status == "failed" for check in checks):
        yield Check(words, "not judged", "its quantities are not followed one by one", "mend those first")
    else:
        yield check_by(words, _columns, bench, changed(scene, _EVERYTHING), told)


def _columns(bench: Bench, scene: FollowerAlone, told: set[str]) -> str:
    """The columns against reference; columns with wrong rows are added to `told`."""
    motion = Motion(scene, DURATION)
    try:
        wrong = findings(bench, motion, told)
    except EngineFailure as failure:
        raise Fault(f"none is delivered: {failure.cause}", failure.advice) from failure
    run, right, off = bench.run(motion), truth(motion).columns, bench.errors(motion)
    if not wrong:
        return f"{len(off)} columns, the worst off by {share_of(max(off.values()))}"
    tell_of_rows(wrong, told, len(wrong))
    moves = {name: run[name] for name in compared_columns(run, DECISIVE, right) if name not in told}
    if model := acts_as_if(motion, moves, bench.tolerances(motion)):
        raise Fault(model.finding.cause, model.finding.advice)
    worst = sorted(wrong, key=lambda name: -off[name])
    raise Fault(f"{some([f'{name} is off by {share_of(off[name])}' for name in worst])}", "compare it with reference's follower alone")
