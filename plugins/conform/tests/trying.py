"""One check of an engine by its name."""

from quickreturn.engines.base import AnyEngine
from quickreturn.plugins.conform.behaviour import failures, repetition
from quickreturn.plugins.conform.bench import FOLLOWERS, Bench, Check, check_by, first_modelled
from quickreturn.plugins.conform.columns import examined
from quickreturn.plugins.conform.motion import motion
from quickreturn.plugins.conform.promises import frequencies, ladder
from quickreturn.plugins.conform.quantities import alone, followed, together, turning
from quickreturn.plugins.conform.scenes import CHANGES, CHANGES_ALONE, FEATURES

_GROUPS = {
    "ladder": ladder,
    "estimates": ladder,
    "frequencies": frequencies,
    "failures": failures,
    "the same the second time": lambda bench: repetition(bench, "not tried"),
    "the follower alone": alone,
}


def tried(engine: AnyEngine, name: str) -> Check:
    """The check of this name, without most of those before it."""
    bench = Bench(engine)
    if name == "an arm that turns fully":
        return check_by(name, turning, bench)
    if name == "quantity with everything on":
        return check_by(name, together, bench, bench.scene, FEATURES, frozenset(examined(bench, bench.mild).wrong))
    kind, _, quantity = name.partition("quantity " if name.startswith("quantity ") else ": ")
    for change in CHANGES if kind == "" else CHANGES_ALONE:
        if change.name == quantity:
            before = bench.mild if kind == "" else first_modelled(bench.engine, FOLLOWERS)
            return check_by(name, followed, bench, before.scene, change, frozenset(examined(bench, before).wrong))
    checks = next((checks for start, checks in _GROUPS.items() if name.startswith(start)), motion)(bench)
    return next(check for check in checks if check.check == name)
