"""Where a machine lies on the map of classes, and which method the map advises."""

from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from typing import Any

from cases.case import Case
from cases.classes.groups import MEANINGS, Groups, groups_of
from cases.classes.map import TIMES, Map, distance, level_for, off_the_map
from cases.classes.measurement import LEVELS, REFUSED, Reach
from cases.errors import CaseError
from cases.shown import Cell, Rows, Shown
from quickreturn.accuracy import checked
from quickreturn.catalogue import AnyCase, one_case


@dataclass(frozen=True, repr=False)
class Advice(Shown):
    """What the recorded map says of a machine.

    Attributes:
        case: name of the machine.
        groups: in which it is told from others.
        accuracy: error of the tip deflection that is wanted.
        level: error at which methods were compared: the loosest that is as tight, or the tightest.
        scene: name of the nearest scene of the map.
        steps: how far the machine is from it, in steps of the map.
        sharpness: by how much two independent solutions of that scene differ; None where it has no second one.
        outside: sentences, each on something in which the machine lies outside the map: there the advice is an extrapolation.
        use: of `cases.classes.map.TIMES` -> the engine that was fastest there and takes this machine; absent where none is known.
        reaches: of each engine what it reached in that scene; of one that refuses this machine that.
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
    reaches: tuple[Reach, ...]

    @property
    def document(self) -> dict[str, Any]:
        """For JSON."""
        return asdict(self)

    def _parts(self) -> Iterator[Cell]:
        yield f"{self.case}: which method for an error of {100.0 * self.accuracy:g} %"
        yield Rows([(MEANINGS[name], f"{value:.3g}") for name, value in vars(self.groups).items()])
        sharp = "" if self.sharpness is None else f"; two formulations agree there to {self.sharpness:.1e}"
        yield f"nearest scene of the map: {self.scene} ({self.steps:.1f} steps away){sharp}"
        yield from (f"outside the map, so this is an extrapolation: {each}" for each in self.outside)
        for by in TIMES:
            if by in self.use:
                yield f"{by}: {self.use[by]}"
            else:
                yield f"{by}: no method is known that gets to {100.0 * self.level:g} %"
        rows = [(each.engine, _time(each.solve_seconds), _time(each.waited_seconds), _remark(each)) for each in self.reaches]
        yield Rows(rows, ("engine", "solve", "wait", f"one turn of the crank to {100.0 * self.level:g} % there"))


def advise(case: AnyCase, accuracy: float = LEVELS[0]) -> Advice:
    """Where a machine lies on the recorded map of classes, and which methods are fastest there.

    Args:
        case: a name, a path or a `Case`.
        accuracy: error of the tip deflection that is wanted, 1e-4 to 0.05.

    Raises:
        CaseError: no such case, or a machine without a bending frequency or a turning crank, which has no place on the map.
        ValueError: an accuracy that cannot be asked for.
    """
    from reports.long_studies import class_map

    chosen, wanted = one_case(case), checked(accuracy) or LEVELS[0]
    groups, known = groups_of(chosen.mechanism), class_map()
    if groups is None:
        problem = "a follower that cannot bend or a crank that stands still has no place on the map of classes"
        raise CaseError(chosen.name, "follower.bending_stiffness", None, problem, "a finite stiffness and a crank that turns")
    if not known.scenes:
        raise CaseError(chosen.name, None, None, "the map of classes has not been recorded", "python -m reports.long_studies classes")
    return _advice(chosen, groups, wanted, known)


def _advice(case: Case, groups: Groups, accuracy: float, known: Map) -> Advice:
    level, scene = level_for(accuracy) or LEVELS[-1], known.nearest(groups)
    refusals = {reach.engine: _refusal(case, reach.engine) for reach in known.at(scene, level)}
    use = dict[str, str]()
    for by in TIMES:
        takers = [name for name, _ in known.place(scene, level, by).ranked if not refusals[name]]
        use |= {by: takers[0]} if takers else {}
    outside = [
        f"{MEANINGS[name]} is {getattr(groups, name):.3g}, the map has {low:g} to {high:g}"
        for name, (low, high) in known.outside(groups).items()
    ]
    if accuracy < level:
        outside.append(f"an error of {100.0 * accuracy:g} % is asked for, the map has {100.0 * level:g} %")
    return Advice(
        case=case.name,
        groups=groups,
        accuracy=accuracy,
        level=level,
        scene=scene.name,
        steps=distance(scene.groups, groups),
        sharpness=scene.difference,
        outside=(*outside, *off_the_map(case.mechanism)),
        use=use,
        reaches=tuple(
            Reach(reach.scene, reach.engine, level, REFUSED, remark=refusals[reach.engine]) if refusals[reach.engine] else reach
            for reach in known.at(scene, level)
        ),
    )


def _refusal(case: Case, name: str) -> str:
    """Why an engine refuses a machine, "" if it does not."""
    from engines.base import Refusal
    from engines.registry import engine

    try:
        engine(name).check(case.mechanism)
    except Refusal as refusal:
        return str(refusal)
    return ""


def _time(seconds: float | None) -> str:
    return "-" if seconds is None else f"{1e3 * seconds:.2g} ms" if seconds < 1.0 else f"{seconds:.2g} s"


def _remark(reach: Reach) -> str:
    """The status where the engine does not get there, and the reason."""
    left = f"{100.0 * reach.error:.2g} % are left" if reach.error is not None and reach.solve_seconds is None else ""
    told = [reach.status if reach.solve_seconds is None else "", left, reach.remark]
    return "; ".join(filter(None, told))
