"""One check of an engine by its name."""

from collections.abc import Iterator

from quickreturn.engines.base import AnyEngine
from quickreturn.plugins.conform.behaviour import failures, repetition
from quickreturn.plugins.conform.bench import Bench, Check, Motion, check_by
from quickreturn.plugins.conform.columns import Examined, examined
from quickreturn.plugins.conform.motion import motion
from quickreturn.plugins.conform.promises import frequencies, ladder
from quickreturn.plugins.conform.quantities import alone, followed, follower_alone, together, turning
from quickreturn.plugins.conform.rods import motion_alone, rods
from quickreturn.plugins.conform.scenes import CHANGES, CHANGES_ALONE, FEATURES, SPUN_UP

_GROUPS = {
    "ladder": ladder,
    "estimates": ladder,
    "frequencies": frequencies,
    "failures": failures,
    "rod": rods,
    "the same the second time": lambda bench: repetition(bench, "not tried"),
    "the follower alone": alone,
}


def tried(engine: AnyEngine, name: str, found: Examined | None = None) -> Check:
    """The check of this name, without most of those before it; `found`: what is wrong already, None: what the mild scene shows."""
    bench = Bench(engine, motion_alone(engine))
    if name == "an arm that turns fully":
        return check_by(name, turning, bench)
    if name == "quantity with everything on":
        return check_by(name, together, bench, bench.scene, FEATURES, found or examined(bench, bench.mild))
    kind, _, quantity = name.partition("quantity " if name.startswith("quantity ") else ": ")
    alike = [change for change in (CHANGES if name.startswith("quantity ") else CHANGES_ALONE) if change.name == quantity]
    if alike and kind in ("", "the follower alone"):
        mild = bench.mild if kind == "" else Motion(follower_alone(bench), SPUN_UP)
        found = found or examined(bench, mild)
        return check_by(name, followed, bench, mild.scene, alike[0], set(found.rows), found)
    checks: Iterator[Check] = next((checks for start, checks in _GROUPS.items() if name.startswith(start)), motion)(bench)
    return next(check for check in checks if check.check == name)
