"""Where a machine lies on the recorded map of methods over classes of machines, and which methods are fastest there."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Final

from quickreturn.arguments import AnyCase, one_case
from quickreturn.cases.files.errors import CaseError
from quickreturn.cases.files.shown import Cell, Printable, Rows
from quickreturn.cases.library import library_case
from quickreturn.computing import checked
from quickreturn.engines.base import Refusal
from quickreturn.engines.registry import engine
from quickreturn.plugins.methods.groups import MEANINGS, Groups, groups_of
from quickreturn.plugins.methods.map import LEVELS, TIMES, Map
from quickreturn.plugins.methods.row import REFUSED, Row
from quickreturn.reference_model.mechanism import Mechanism
from quickreturn.reference_model.scene_values import NAMED, values_of
from quickreturn.reports.words import duration

#: Quantities of a case file that the groups contain.
_GROUPED: Final = frozenset(
    {"crank.torque", "crank.prescribed_speed", "base.damping", "follower.damping", "follower.material_damping", "slider.joint_stiffness"}
)
#: Relative difference up to which a ratio of lengths counts as that of the map.
_SIMILAR: Final = 0.05


@dataclass(frozen=True, repr=False)
class Advice(Printable):
    """What the recorded map says of a machine."""

    case: str  # name of the machine
    groups: Groups  # its dimensionless groups
    accuracy: float  # error of the tip deflection that is wanted
    level: float  # error at which the map compares methods: its largest one that is no larger than `accuracy`, or its smallest one
    scene: str  # name of the nearest scene of the map
    steps: float  # how far the machine is from it, in steps of the map
    sharpness: float | None  # relative difference of two independent solutions of that scene; None if it has no second one
    outside: tuple[str, ...]  # sentences, each on a quantity for which the machine lies outside the map and this is an extrapolation
    use: Mapping[str, str]  # name of a time, see `map.TIMES` -> the fastest engine that models this machine; absent where there is none
    reaches: tuple[Row, ...]  # what each engine reached in that scene, or its refusal of this machine

    def _parts(self) -> Iterator[Cell]:
        yield f"{self.case}: which method for an error of {100.0 * self.accuracy:g} %"
        yield Rows([(MEANINGS[name], f"{value:.3g}") for name, value in vars(self.groups).items()])
        sharp = "" if self.sharpness is None else f"; two formulations agree there to {self.sharpness:.1e}"
        yield f"nearest scene of the map: {self.scene} ({self.steps:.1f} steps away){sharp}"
        yield from (f"outside the map, so this is an extrapolation: {each}" for each in self.outside)
        yield from (f"fastest by {by}: {self.use.get(by, 'no method is known to reach it')}" for by in TIMES)
        rows = []
        for each in self.reaches:
            times = ("-" if seconds is None else duration(seconds) for seconds in (each.solve_seconds, each.answer_seconds))
            missed = each.solve_seconds is None
            left = f"{100.0 * each.error:.2g} % remains" if missed and each.error is not None else ""
            rows.append((each.engine, *times, "; ".join(filter(None, (each.status if missed else "", left, each.remark)))))
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

    chosen, error, known = one_case(case), checked(accuracy) or LEVELS[0], class_map()
    groups = groups_of(chosen.mechanism)
    if groups is None:
        problem = "a follower that cannot bend, or a crank that stands still, has no place on the map of classes"
        raise CaseError(chosen.name, None, None, problem, "a finite follower.bending_stiffness and a crank that turns")
    if not known.scenes:
        raise CaseError(chosen.name, None, None, "the map of classes has not been recorded", "python -m quickreturn.record classes")
    level = max((each for each in LEVELS if each <= error), default=LEVELS[-1])
    scene, steps = known.nearest(groups)
    reaches = tuple(_for_machine(chosen.mechanism, trial) for trial in known.at(scene, level))
    able = {trial.engine for trial in reaches if trial.status != REFUSED}
    use = {by: name for by in TIMES if (name := next((each for each in known.ranked(scene, level, by) if each in able), ""))}
    outside = [*beyond(known, groups), *_off_the_map(chosen.mechanism)]
    if error < level:
        outside.append(f"an error of {100.0 * error:g} % is asked for, the tightest of the map is {100.0 * level:g} %")
    return Advice(chosen.name, groups, error, level, scene.name, steps, scene.difference, tuple(outside), use, reaches)


def beyond(known: Map, groups: Groups) -> Iterator[str]:
    """A sentence on each group in which a machine lies outside all scenes."""
    for name, value in vars(groups).items():
        values = [getattr(scene.groups, name) for scene in known.scenes]
        if not 0.999 * min(values) <= value <= 1.001 * max(values):
            yield f"{MEANINGS[name]} is {value:.3g}, the map has {min(values):g} to {max(values):g}"


def _off_the_map(mechanism: Mechanism) -> Iterator[str]:
    """Sentences on features of a machine that no scene of the map has: their effect on the methods is unknown."""
    given = {f"{section}.{key}": value for section, values in values_of(mechanism).items() for key, value in values.items()}
    for name, value in given.items():
        if name in NAMED and name not in _GROUPED and value != NAMED[name].default:
            yield f"{name} is given, but no scene of the map has it"
    reach, usual = (each.follower.length / each.pivot_distance for each in (mechanism, library_case("thesis-24").mechanism))
    if abs(reach / usual - 1.0) > _SIMILAR:
        yield f"follower.length over mechanism.pivot_distance is {reach:.3g}, on the map it is {usual:.3g}"


def _for_machine(mechanism: Mechanism, trial: Row) -> Row:
    """What an engine reached in a scene of the map, with the status `REFUSED` if it refuses this machine, and only then."""
    try:
        engine(trial.engine).check(mechanism)
    except Refusal as refusal:
        return Row(scene=trial.scene, engine=trial.engine, level=trial.level, status=REFUSED, remark=str(refusal))
    return replace(trial, remark="") if trial.status == REFUSED else trial
