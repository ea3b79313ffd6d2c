"""Checks of a trajectory: its rows and pieces, each column against `reference`, identities that need none, first rows, a bent start.

A column that is found wrong is left out of the checks that follow: one mistake is told once.
"""

import functools
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, Final, NamedTuple

import numpy as np

from cases.conformance.bench import Bench, Truth, bent_start, truth
from cases.conformance.checks import TELL_THE_AUTHOR, Array, Check, Fault, looked_at, percent
from cases.conformance.models import acts_as_if
from cases.conformance.scenes import OUTPUT_STEP
from cases.conformance.suspects import Finding, diagnose
from engines.base import EngineFailure, Refusal
from engines.relative import rms
from engines.start import Start, standard_start
from engines.start_state import reconstruct
from engines.trajectory import Trajectory
from reference_model.mechanism import Mechanism

#: A scene's run one rung above the default, see `Bench.sharpened`.
Sharpened = Callable[[Mechanism], Trajectory | None]

#: Between output steps that are this many times as large nothing may change, in this part of a column where the engine says nothing.
_COARSER: Final = 4
_SAME: Final = 0.02
_BENT_DURATION: Final = 0.25  # s
#: What is wrong -> what is left of a start then.
_IGNORED: Final[Mapping[str, Mapping[str, Any]]] = {
    "the start's deflection and its rate are ignored: the follower begins straight": {"deflection": None, "deflection_rate": None},
    "the start's deflection rate is ignored: the follower begins bent and is not bending": {"deflection_rate": None},
    "the start's deflection is ignored: the follower begins straight": {"deflection": None},
}
#: A finer rung that leaves no more than this part of a difference shows that it comes from the resolution.
FALLS: Final = 0.7
#: Coarse columns are called so from this part on.
_COARSE: Final = 0.02


def motion(bench: Bench) -> Iterator[Check]:
    """All checks of a trajectory, in order."""
    try:
        run, known, tolerances, late, depending, found, model = _mild(bench)
    except EngineFailure as failure:
        yield Check("a trajectory", "failed", f"none is delivered in a mild scene: {failure.cause}", failure.advice)
        return
    wrong = set(late)
    yield looked_at("pieces continue", _pieces, bench, run, tolerances, wrong | set(depending))
    yield from late.values()
    yield from _columns(bench, "column", run, known, tolerances, wrong, found, model)
    yield from (check for column, check in depending.items() if column not in wrong)  # a column explained needs no second word
    wrong.update(depending)
    yield from _identities(run, bench.scene, wrong)
    yield looked_at("first row of the standard start", _first_row, bench.scene, standard_start(bench.scene), run, wrong)
    yield from _bent(bench, wrong)


class _Mild(NamedTuple):
    """The trajectory of the mild scene, the right one, by how much columns may be off, and what is wrong with which column.

    Attributes:
        late: columns that come late with a coarser output step.
        depending: columns that depend on it otherwise.
        found: others that are wrong.
        model: a mistake of the model that explains them.
    """

    run: Trajectory
    known: Truth
    tolerances: Mapping[str, float] | None
    late: Mapping[str, Check]
    depending: Mapping[str, Check]
    found: Mapping[str, Finding]
    model: Finding | None


@functools.lru_cache(maxsize=1)
def _mild(bench: Bench) -> _Mild:
    """Raises EngineFailure if there is no trajectory."""
    run = bench.run(bench.scene)
    known = truth(bench.scene)
    tolerances = bench.tolerances(known, bench.scene)
    late, depending = _rows(bench, run, tolerances)
    names = [name for name in bench.columns(run.columns) if name not in late]
    return _Mild(run, known, tolerances, late, depending, *_findings(bench, names, bench.scene, run, known, tolerances, bench.sharpened))


def _rows(bench: Bench, run: Trajectory, tolerances: Mapping[str, float] | None) -> tuple[dict[str, Check], dict[str, Check]]:
    """The same motion with a coarser output step: columns that come late with it, and others that depend on it."""
    name, step = "the same with another output step", _COARSER * OUTPUT_STEP
    try:
        coarse = bench.run(bench.scene, duration=step * (len(run) // _COARSER), output_step=step)
    except EngineFailure as failure:
        return {"time": Check(name, "failed", f"with {1e3 * step:g} ms between rows: {failure.cause}", failure.advice)}, {}
    late, depending = dict[str, Check](), dict[str, Check]()
    for column in bench.columns(run.columns):
        fine, there = run[column], coarse[column]
        allowed = max(0.0 if tolerances is None else tolerances[column], (_SAME if tolerances is None else 1e-4) * _swing(fine))
        off = rms(there - fine[::_COARSER][: len(there)])
        if off <= allowed:
            continue
        for lag in (1, 2, -1):
            if rms(there[3:-3] - _later(fine, lag, len(there))[3:-3]) <= 0.3 * off:
                words = f"{column} comes {abs(lag)} row{'s' if abs(lag) > 1 else ''} {'late' if lag > 0 else 'early'}"
                advice = "take it at the instant of the row, after the last step, with everything brought up to date"
                late[column] = Check(f"{name}: {column}", "failed", words, advice)
                break
        else:
            words = f"{column} changes by {percent(off / max(_swing(fine), 1e-300))} with the distance of the rows"
            advice = "compute it from the state at the instant of the row, not from rows before and after"
            depending[column] = Check(f"{name}: {column}", "failed", words, advice)
    return late, depending or {"": Check(name, "passed" if not late else "not judged")}


def _later(fine: Array, lag: int, rows: int) -> Array:
    """What the coarse rows of a column would be that is `lag` rows late in both: the fine one shows it `lag` fine rows late already."""
    at = np.clip(np.arange(rows) * _COARSER - (_COARSER - 1) * lag, 0, len(fine) - 1)
    return fine[at]


def _swing(values: Array) -> float:
    return rms(values - np.mean(values))


def _pieces(bench: Bench, run: Trajectory, tolerances: Mapping[str, float] | None, wrong: set[str]) -> None:
    """A simulation advanced in pieces goes on where it stood."""
    rows, scene = 60, bench.scene
    span = rows * OUTPUT_STEP
    simulation = bench.engine.prepare(scene, standard_start(scene), bench.settings(scene))
    try:
        pieces = [simulation.advance(span, OUTPUT_STEP) for _ in range(3)]
    except Exception as error:  # an author's engine may raise anything
        cause = f"advancing a second time raises {type(error).__name__}: {error}"
        raise Fault(cause, "keep the state between calls of advance") from error
    keep = "keep the state in the simulation and begin each piece with the row that the one before ended with"
    for number, piece in enumerate(pieces):
        begin, first = number * rows, piece["time"][0]
        if len(piece) != rows + 1:
            raise Fault(f"piece {number + 1} has {len(piece)} rows in place of {rows + 1}", keep)
        if abs(first - number * span) > 0.1 * OUTPUT_STEP:
            cause = f"the time of piece {number + 1} begins at {first:.4g} s, not where the one before ended"
            if abs(first) < 0.1 * OUTPUT_STEP:
                cause = "the time begins at zero again in each piece"
            raise Fault(cause, "count time in the simulation: `self.time` plus the grid")
        if number and abs(simulation.time - 3 * span) > 0.1 * OUTPUT_STEP:
            cause = f"`time` of the simulation is {simulation.time:.4g} s after {3 * rows} ms"
            raise Fault(cause, "add the duration to it in each advance")
        off = [column for column in _jumps(bench, piece, run, begin, tolerances) if column not in wrong]
        if off and all(column in ("dissipated_energy", "drive_work") for column in off):
            raise Fault(f"{' and '.join(off)} begins anew in each piece", "sum from the start of the simulation")
        if off and abs(piece["crank_angle"][0] - run["crank_angle"][0]) < 1e-9:
            raise Fault("each piece begins in the start again", keep)
        if off:
            raise Fault(f"in pieces {', '.join(off)} goes another way than in one go, from {begin} ms on", keep)


def _jumps(bench: Bench, piece: Trajectory, run: Trajectory, begin: int, tolerances: Mapping[str, float] | None) -> list[str]:
    rows = slice(begin, begin + len(piece))
    return [
        name
        for name in bench.columns(run.columns)
        if rms(piece[name] - run[name][rows])
        > max(0.0 if tolerances is None else 3.0 * tolerances[name], (_SAME if tolerances is None else 1e-3) * _swing(run[name]), 1e-12)
    ]


def _columns(
    bench: Bench,
    kind: str,
    run: Trajectory,
    known: Truth,
    tolerances: Mapping[str, float] | None,
    wrong: set[str],
    found: Mapping[str, Finding],
    model: Finding | None = None,
) -> Iterator[Check]:
    """Each column against `reference`; or the model, where it explains several at once."""
    names = [name for name in bench.columns(run.columns) if name not in wrong]
    if model is not None:
        worst = max((rms(run[name] - known.columns[name]) / rms(known.columns[name]), name) for name in found)
        cause = f"{model.cause} ({worst[1]} is {percent(worst[0])} off)"
        yield Check(f"{kind}s together", "failed", cause, model.advice)
        wrong.update(found)
        return
    for name in names:
        if name in found:
            wrong.add(name)
            yield Check(f"{kind} {name}", "failed", found[name].cause, found[name].advice)
            continue
        off = rms(run[name] - known.columns[name]) / (rms(known.columns[name]) or 1.0)
        by_itself = "" if tolerances is not None else ", and makes no claim that it is not"
        coarse = f"coarse: {percent(off)} from reference{by_itself}"
        yield Check(f"{kind} {name}", "passed", coarse if off > _COARSE else "")
    if before := sorted(wrong & set(run.columns) - set(names)):
        yield Check(f"{kind} {', '.join(before)}", "not judged", "their rows are wrong already", "mend those first")


def _findings(
    bench: Bench,
    names: Sequence[str],
    scene: Mechanism,
    run: Trajectory,
    known: Truth,
    tolerances: Mapping[str, float] | None,
    sharpened: Sharpened,
) -> tuple[dict[str, Finding], Finding | None]:
    """What is wrong with which column; and with the model, where that explains several at once."""
    found: dict[str, Finding] = {}
    for name in names:
        tolerance = None if tolerances is None else tolerances[name]
        finding = diagnose(name, run[name], known.columns[name], tolerance, known.columns, scene)
        if finding is not None:
            found[name] = finding
    puzzling = [name for name, finding in found.items() if not finding.explained]
    if puzzling and tolerances is not None and (finer := sharpened(scene)) is not None:
        for name in puzzling:  # what falls with the resolution is no mistake of the column: its estimate is too small, which is told there
            if rms(finer[name] - known.columns[name]) <= FALLS * rms(run[name] - known.columns[name]):
                del found[name]
        puzzling = [name for name in puzzling if name in found]
    moves = tuple(name for name in names if name not in found or name in puzzling or len(found) > 2)
    if len(found) > 1 and scene is bench.scene:
        return found, acts_as_if(scene, {name: run[name] for name in moves}, known, tolerances)
    return found, None


@dataclass(frozen=True)
class Amiss:
    """What `motion` finds wrong in the mild scene, so that other checks do not tell it again.

    Attributes:
        columns: whose own rows are wrong.
        motion: whether the motion is, in the mild scene already.
    """

    columns: frozenset[str]
    motion: bool


def amiss(bench: Bench) -> Amiss:
    """What is wrong with the mild scene's trajectory. Raises EngineFailure if there is none."""
    mild = _mild(bench)
    explained = {name for name, finding in mild.found.items() if finding.explained and mild.model is None}
    return Amiss(frozenset({*mild.late, *mild.depending, *explained}), len(explained) < len(mild.found))


def _identities(run: Trajectory, scene: Mechanism, wrong: set[str]) -> Iterator[Check]:
    """What holds between the columns of one trajectory, whatever the model."""
    d, h, q2 = scene.pivot_distance, OUTPUT_STEP, run["follower_angle"]
    x, y = run["tip_x"] - d, run["tip_y"]
    a = np.gradient(np.gradient([x, y], h, axis=1), h, axis=1)
    crank = scene.crank.length
    to_slider = np.array([crank * np.cos(run["crank_angle"]) - d, crank * np.sin(run["crank_angle"])])
    identities: Sequence[tuple[str, tuple[str, ...], Array, float]] = (
        ("crank_speed", ("crank_angle",), np.gradient(run["crank_angle"], h), 0.01),
        ("tip_deflection", ("tip_x", "tip_y", "follower_angle"), np.cos(q2) * y - np.sin(q2) * x, 1e-3),
        ("tip_acceleration", ("tip_x", "tip_y", "follower_angle"), np.cos(q2) * a[1] - np.sin(q2) * a[0], 0.3),
        ("slider_position", ("crank_angle",), np.hypot(*to_slider), 1e-3),
    )
    for name, others, expected, part in identities:
        check = f"identity: {name} from {', '.join(others)}"
        tainted = [column for column in (name, *others) if column in wrong]
        if tainted:
            yield Check(check, "not judged", f"{tainted[0]} is wrong already", "mend that first")
            continue
        inner = slice(3, -3)  # differences are one-sided at the ends
        beside = {column: values[inner] for column, values in run.columns.items()}
        finding = diagnose(name, run[name][inner], expected[inner], part * rms(expected[inner]), beside, scene)
        yield Check(check, "passed") if finding is None else Check(check, "failed", finding.cause, finding.advice)


def _first_row(scene: Mechanism, start: Start, run: Trajectory, wrong: set[str], part: float = 1e-6) -> None:
    """Where the loop puts crank, follower and slider at the start, to a part of the follower's length or of a radian."""
    state = reconstruct(scene, start)
    tip = state.position(np.array([scene.follower.length]))[0]
    b2 = np.array([-np.sin(state.follower_angle), np.cos(state.follower_angle)])
    expected = {
        "crank_angle": start.crank_angle,
        "crank_speed": start.crank_speed,
        "follower_angle": state.follower_angle,
        "slider_position": state.slider_position,
        "tip_x": tip[0],
        "tip_y": tip[1],
        "tip_deflection": float(b2 @ (tip - [scene.pivot_distance, 0.0])),
    }
    for name, value in expected.items():
        found, second = map(float, run[name][:2])
        if name not in wrong and abs(found - value) > part * (abs(start.crank_speed) if name == "crank_speed" else 1.0):
            cause = f"{name} is {found:.6g} in the first row, the start puts it at {value:.6g}"
            if abs(found - second) < abs(found - value) and name != "crank_speed":
                cause += "; the first row is not the start"
            raise Fault(cause, "deliver the state of the start as the first row, before any step")


def _bent(bench: Bench, wrong: set[str]) -> Iterator[Check]:
    """A start with a bent follower in motion: its first row, and where it goes from there."""
    scene = bench.soft
    start, check = bent_start(scene), "a bent, moving start"
    try:
        run = bench.run(scene, duration=_BENT_DURATION, start=start)
    except (EngineFailure, Refusal) as failure:
        cause = failure.cause if isinstance(failure, EngineFailure) else str(failure)
        advice = "see engines.start_state.reconstruct: it closes the loop for any start"
        yield Check(check, "failed", f"it is not accepted: {cause}", advice)
        return
    known = truth(scene, _BENT_DURATION, start=start)
    tolerances = bench.tolerances(known, scene, duration=_BENT_DURATION, start=start)
    # a start is met as closely as the model can bend, which its own error of the deflection tells
    deflection = rms(known.columns["tip_deflection"])
    part = 0.5 * deflection if tolerances is None else tolerances["tip_deflection"] + 0.02 * deflection
    first = looked_at(f"first row of {check}", _first_row, scene, start, run, wrong, part)
    off = _departure(run, known.columns)
    for cause, left_out in _IGNORED.items():
        other = truth(scene, _BENT_DURATION, start=replace(start, **left_out))
        if _departure(run, other.columns) < 0.4 * off and off > 0.05:
            yield Check(check, "failed", cause, "see engines.start_state.reconstruct: it tells place and velocity of every point")
            return
    yield first
    if not {"slider_position", "crank_angle"} & wrong and rms(_bow(run.columns, scene)) < 0.3 * rms(_bow(known.columns, scene)):
        cause = "slider_position is the straight distance from the pivot, not the arc length"
        yield Check(f"{check}: slider_position", "failed", cause, "integrate along the bent centre line")
        wrong.add("slider_position")
    if first.status == "failed":
        yield Check(check, "not judged", "it does not begin where it should", TELL_THE_AUTHOR)
        return
    finer = partial(bench.sharpened, duration=_BENT_DURATION, start=start)
    names = [name for name in bench.columns(run.columns) if name not in wrong]
    found, _ = _findings(bench, names, scene, run, known, tolerances, finer)
    yield from _columns(bench, "from a bent, moving start:", run, known, tolerances, set(wrong), found)


def _departure(run: Trajectory, columns: Mapping[str, Array]) -> float:
    """How far the follower's bend is from another one, relative to that."""
    names = ("tip_deflection", "strain_1", "strain_2", "strain_3")
    return float(np.mean([rms(run[name] - columns[name]) / rms(columns[name]) for name in names]))


def _bow(columns: Mapping[str, Array], scene: Mechanism) -> Array:
    """By how much the arc length to the slider exceeds its straight distance from the pivot, m."""
    crank, angle = scene.crank.length, columns["crank_angle"]
    return columns["slider_position"] - np.hypot(crank * np.cos(angle) - scene.pivot_distance, crank * np.sin(angle))
