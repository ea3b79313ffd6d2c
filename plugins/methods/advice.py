"""Where a machine lies on the recorded map of methods over classes of machines, and which methods are fastest there."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

from quickreturn.arguments import AnyCase, one_case
from quickreturn.cases.files.case import Case
from quickreturn.cases.files.errors import CaseError
from quickreturn.cases.files.shown import Cell, Printable, Rows
from quickreturn.cases.files.units import in_si
from quickreturn.computing import checked
from quickreturn.engines.base import Refusal
from quickreturn.engines.registry import engine
from quickreturn.plugins.methods.groups import MEANINGS, Groups, groups_of
from quickreturn.plugins.methods.map import LEVELS, TIMES, Map, off_the_map
from quickreturn.plugins.methods.row import REFUSED, Row


@dataclass(frozen=True, repr=False)
class Advice(Printable):
    """What the recorded map says of a machine.

    Attributes:
        case: name of the machine.
        groups: its dimensionless groups.
        accuracy: error of the tip deflection that is wanted.
        level: error at which the map compares methods: its largest one that is no larger than `accuracy`, or its smallest one.
        scene: name of the nearest scene of the map.
        steps: how far the machine is from it, in steps of the map.
        sharpness: relative difference of two independent solutions of that scene; None if it has no second one.
        outside: sentences, each on a quantity for which the machine lies outside the map and the advice is an extrapolation.
        use: name of a time, see `map.TIMES` -> the fastest engine that models this machine; absent where there is none.
        reaches: what each engine reached in that scene, or its refusal of this machine.
    """

    case: str
    groups: Groups
    accuracy: float
    level: float
    scene: str
    steps: float
    sharpness: float | None
    outside: tuple[str, ...]
    use: Mapping[str, str]
    reaches: tuple[Row, ...]

    def _parts(self) -> Iterator[Cell]:
        yield f"{self.case}: which method for an error of {100.0 * self.accuracy:g} %"
        yield Rows([(MEANINGS[name], f"{value:.3g}") for name, value in vars(self.groups).items()])
        sharp = "" if self.sharpness is None else f"; two formulations agree there to {self.sharpness:.1e}"
        yield f"nearest scene of the map: {self.scene} ({self.steps:.1f} steps away){sharp}"
        yield from (f"outside the map, so this is an extrapolation: {each}" for each in self.outside)
        yield from (f"fastest by {by}: {self.use.get(by, 'no method is known to reach it')}" for by in TIMES)
        rows = [(each.engine, _time(each.solve_seconds), _time(each.answer_seconds), _remark(each)) for each in self.reaches]
        yield Rows(rows, ("engine", "solve", "wait", f"a turn of the crank in that scene, to {100.0 * self.level:g} %"))


def advise(case: AnyCase, accuracy: float = LEVELS[0]) -> Advice:
    """Where a machine lies on the recorded map of classes, and which methods are fastest there. Nothing is simulated.

    Args:
        case: a name, a path or a `Case`.
        accuracy: error of the tip deflection that is wanted, 1e-4 to 0.05.

    Raises:
        CaseError: no such case, or a machine without a bending frequency or without a turning crank; it has no place on the map.
        ValueError: `accuracy` is out of range.
    """
    from quickreturn.plugins.methods.studies import class_map

    chosen, error, recorded_map = one_case(case), checked(accuracy) or LEVELS[0], class_map()
    groups = groups_of(chosen.mechanism)
    if groups is None:
        problem = "a follower that cannot bend, or a crank that stands still, has no place on the map of classes"
        raise CaseError(chosen.name, None, None, problem, "a finite follower.bending_stiffness and a crank that turns")
    if not recorded_map.scenes:
        raise CaseError(chosen.name, None, None, "the map of classes has not been recorded", "python -m quickreturn.record classes")
    return _advice(chosen, groups, error, recorded_map)


def _advice(case: Case, groups: Groups, accuracy: float, class_map: Map) -> Advice:
    level = max((each for each in LEVELS if each <= accuracy), default=LEVELS[-1])
    scene, steps = class_map.nearest(groups)
    reaches = tuple(_for_machine(case, trial) for trial in class_map.at(scene, level))
    able = {trial.engine for trial in reaches if trial.status != REFUSED}
    methods = {by: [name for name in class_map.ranked(scene, level, by) if name in able] for by in TIMES}
    outside = [
        f"{MEANINGS[name]} is {getattr(groups, name):.3g}, the map has {low:g} to {high:g}"
        for name, (low, high) in class_map.outside(groups).items()
    ]
    if accuracy < level:
        outside.append(f"an error of {100.0 * accuracy:g} % is asked for, the tightest of the map is {100.0 * level:g} %")
    outside += off_the_map(case.mechanism)
    use = {by: names[0] for by, names in methods.items() if names}
    return Advice(case.name, groups, accuracy, level, scene.name, steps, scene.difference, tuple(outside), use, reaches)


def _for_machine(case: Case, trial: Row) -> Row:
    """What an engine reached in a scene of the map, with the status `REFUSED` if it refuses this machine, and only then."""
    try:
        engine(trial.engine).check(case.mechanism)
    except Refusal as refusal:
        known = {name: getattr(trial, name) for name in ("scene", "engine", "level")}
        return Row(**known, status=REFUSED, remark=str(refusal))
    return replace(trial, remark="") if trial.status == REFUSED else trial


def _time(seconds: float | None) -> str:
    return "-" if seconds is None else f"{seconds / in_si('ms'):.3g} ms" if seconds < 1.0 else f"{seconds:.2g} s"


def _remark(trial: Row) -> str:
    """The status and the remaining error of an engine that misses the level, and the reason."""
    missed = trial.solve_seconds is None
    left = f"{100.0 * trial.error:.2g} % remains" if missed and trial.error is not None else ""
    return "; ".join(filter(None, (trial.status if missed else "", left, trial.remark)))
