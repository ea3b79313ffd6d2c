"""Checks of a trajectory: its rows and pieces, each column against `reference`, identities that need none, first rows, a bent start.

A column that is found wrong is left out of the checks that follow: one mistake is told once.
"""

import functools
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, Final, NamedTuple

import numpy as np

from cases.conformance.bench import Bench, Motion, bent_start, columns_of, truth
from cases.conformance.checks import TELL_THE_AUTHOR, Array, Check, Fault, looked_at, percent
from cases.conformance.models import acts_as_if
from cases.conformance.scenes import OUTPUT_STEP, SOFT
from cases.mistakes import EXPLAINED, Finding, diagnose
from engines.base import EngineFailure, Refusal
from engines.relative import rms
from engines.start import standard_start
from engines.start_state import reconstruct
from engines.trajectory import Trajectory
from reference_model.mechanism import Mechanism, changed

#: Between output steps that are this many times as large nothing may change, in this part of a column where the engine says nothing.
_COARSER: Final = 4
_SAME: Final = 0.02
#: Rows by which a column may come late or early.
_LAGS: Final = (1, -1, 2, -2, 3)
_IN_TIME: Final = "take it at the instant of the row, after the last step, with everything derived brought up to date"
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
        late, depending, found, model = amiss(bench)
    except EngineFailure as failure:
        yield Check("a trajectory", "failed", f"none is delivered in a mild scene: {failure.cause}", failure.advice)
        return
    wrong = set(late)
    yield looked_at("pieces continue", _pieces, bench, wrong | set(depending))
    yield from late.values()
    yield from _columns(bench, bench.mild, "column", wrong, found, model)
    yield from (check for column, check in depending.items() if column not in wrong)  # a column explained needs no second word
    wrong.update(depending)
    yield from _identities(bench.run(bench.mild), bench.scene, wrong)
    yield looked_at("first row of the standard start", _first_row, bench, bench.mild, wrong)
    yield from _bent(bench, wrong)


class Amiss(NamedTuple):
    """What is wrong in the mild scene.

    Attributes:
        late: columns that come late with a coarser output step.
        depending: columns that depend on it otherwise.
        found: others that are wrong.
        model: a mistake of the model that explains them.
    """

    late: Mapping[str, Check]
    depending: Mapping[str, Check]
    found: Mapping[str, Finding]
    model: Finding | None

    @property
    def columns(self) -> frozenset[str]:
        """Those whose own rows are wrong: no other check tells that again."""
        explained = {name for name, finding in self.found.items() if finding.explained and self.model is None}
        return frozenset({*self.late, *self.depending, *explained})

    @property
    def motion(self) -> bool:
        """Whether more is wrong than rows."""
        return self.model is not None or not all(finding.explained for finding in self.found.values())


@functools.lru_cache(maxsize=1)
def amiss(bench: Bench) -> Amiss:
    """What is wrong with the mild scene's trajectory. Raises EngineFailure if there is none."""
    run, (late, depending) = bench.run(bench.mild), _rows(bench)
    found = _findings(bench, bench.mild, late)
    if len(found) < 2:
        return Amiss(late, depending, found, None)
    of_rows = {name for name in found if found[name].explained and len(found) == 2}
    moves = {name: run[name] for name in columns_of(run) if name not in late and name not in of_rows}
    return Amiss(late, depending, found, acts_as_if(bench.mild, moves, bench.tolerances(bench.mild)))


def _rows(bench: Bench) -> tuple[dict[str, Check], dict[str, Check]]:
    """The same motion with a coarser output step: columns that come late with it, and others that depend on it."""
    run, tolerances = bench.run(bench.mild), bench.tolerances(bench.mild)
    name, step = "the same with another output step", _COARSER * OUTPUT_STEP
    try:
        coarse = bench.run(replace(bench.mild, duration=step * (len(run) // _COARSER), output_step=step))
    except EngineFailure as failure:
        return {"time": Check(name, "failed", f"with {1e3 * step:g} ms between rows: {failure.cause}", failure.advice)}, {}
    late, depending = dict[str, Check](), dict[str, Check]()
    for column in columns_of(run):
        fine, there = run[column], coarse[column]
        off = rms(there - fine[::_COARSER][: len(there)])
        if off <= _allowed(column, fine, tolerances, 1e-4):
            continue
        for lag in _LAGS:
            if rms(there[3:-3] - _later(fine, lag, len(there))[3:-3]) <= 0.3 * off:
                late[column] = Check(f"{name}: {column}", "failed", f"{column} {_comes(lag)}", _IN_TIME)
                break
        else:
            words = f"{column} changes by {percent(off / max(_swing(fine), 1e-300))} with the distance of the rows"
            advice = "compute it from the state at the instant of the row, not from rows before and after"
            depending[column] = Check(f"{name}: {column}", "failed", words, advice)
    return late, depending or {"": Check(name, "passed" if not late else "not judged")}


def _allowed(column: str, values: Array, tolerances: Mapping[str, float] | None, part: float, times: float = 1.0) -> float:
    """By how much a column may differ from another run's: as the engine says, and by a part of its swing."""
    return _SAME * _swing(values) if tolerances is None else max(times * tolerances[column], part * _swing(values))


def _later(fine: Array, lag: int, rows: int) -> Array:
    """What the coarse rows of a column would be that is `lag` rows late in both: the fine one shows it `lag` fine rows late already."""
    at = np.clip(np.arange(rows) * _COARSER - (_COARSER - 1) * lag, 0, len(fine) - 1)
    return fine[at]


def _comes(lag: int) -> str:
    return f"comes {abs(lag)} row{'s' if abs(lag) > 1 else ''} {'late' if lag > 0 else 'early'}"


def _swing(values: Array) -> float:
    return rms(values - np.mean(values))


def _pieces(bench: Bench, wrong: set[str]) -> None:
    """A simulation advanced in pieces goes on where it stood."""
    rows, scene, run, tolerances = 60, bench.scene, bench.run(bench.mild), bench.tolerances(bench.mild)
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
        off = [
            column
            for column in columns_of(run)
            if rms(piece[column] - run[column][begin : begin + len(piece)])
            > max(_allowed(column, run[column], tolerances, 1e-3, 3.0), 1e-12)
            if column not in wrong
        ]
        if off and all(column in ("dissipated_energy", "drive_work") for column in off):
            raise Fault(f"{' and '.join(off)} begins anew in each piece", "sum from the start of the simulation")
        if off and abs(piece["crank_angle"][0] - run["crank_angle"][0]) < 1e-9:
            raise Fault("each piece begins in the start again", keep)
        if off:
            raise Fault(f"in pieces {', '.join(off)} goes another way than in one go, from {begin} ms on", keep)


def _columns(
    bench: Bench, motion: Motion, kind: str, wrong: set[str], found: Mapping[str, Finding], model: Finding | None = None
) -> Iterator[Check]:
    """Each column against `reference`; or the model, where it explains several at once."""
    run, known = bench.run(motion), truth(motion).columns
    off = {name: rms(run[name] - known[name]) / (rms(known[name]) or 1.0) for name in columns_of(run) if name not in wrong}
    if model is not None:
        worst = max(found, key=lambda name: off[name])
        yield Check(f"{kind}s together", "failed", f"{model.cause} ({worst} is {percent(off[worst])} off)", model.advice)
        wrong.update(found)
        return
    before = sorted(wrong & set(run.columns))
    by_itself = "" if bench.tolerances(motion) is not None else ", and makes no claim that it is not"
    for name, part in off.items():
        if name in found:
            wrong.add(name)
            yield Check(f"{kind} {name}", "failed", found[name].cause, found[name].advice)
        else:
            yield Check(f"{kind} {name}", "passed", f"coarse: {percent(part)} from reference{by_itself}" if part > _COARSE else "")
    if before:
        yield Check(f"{kind} {', '.join(before)}", "not judged", "their rows are wrong already", "mend those first")


def _findings(bench: Bench, motion: Motion, left_out: Iterable[str]) -> dict[str, Finding]:
    """What is wrong with which column."""
    run, known, tolerances = bench.run(motion), truth(motion).columns, bench.tolerances(motion)
    found: dict[str, Finding] = {}
    for name in columns_of(run):
        if name not in left_out:
            tolerance = None if tolerances is None else tolerances[name]
            finding = _diagnosed(name, run[name], known[name], tolerance, known, motion.scene)
            if finding is not None:
                found[name] = finding
    puzzling = [name for name, finding in found.items() if not finding.explained]
    if puzzling and tolerances is not None and (finer := bench.sharpened(motion)) is not None:
        for name in puzzling:  # what falls with the resolution is no mistake of the column: its estimate is too small, which is told there
            if rms(finer[name] - known[name]) <= FALLS * rms(run[name] - known[name]):
                del found[name]
    return found


def _diagnosed(
    name: str, found: Array, expected: Array, tolerance: float | None, beside: Mapping[str, Array], scene: Mechanism
) -> Finding | None:
    """As `diagnose`, or that it comes some rows late, whatever the output step, where that explains more."""
    finding = diagnose(name, found, expected, tolerance, beside, scene)
    if finding is None:
        return None
    for lag in _LAGS:
        early, late = (found, expected) if lag > 0 else (expected, found)
        left = rms(early[abs(lag) :] - late[: -abs(lag)])
        if left <= EXPLAINED * rms(found - expected) and (finding.left is None or left < finding.left):
            return Finding(f"{name} {_comes(lag)}", _IN_TIME, left)
    return finding


def _identities(run: Trajectory, scene: Mechanism, wrong: set[str]) -> Iterator[Check]:
    """What holds between the columns of one trajectory, whatever the model."""
    d, h, q2 = scene.pivot_distance, OUTPUT_STEP, run["follower_angle"]
    x, y = run["tip_x"] - d, run["tip_y"]
    a = np.gradient(np.gradient([x, y], h, axis=1), h, axis=1)
    identities: Sequence[tuple[str, tuple[str, ...], Array, float]] = (
        ("crank_speed", ("crank_angle",), np.gradient(run["crank_angle"], h), 0.01),
        ("tip_deflection", ("tip_x", "tip_y", "follower_angle"), np.cos(q2) * y - np.sin(q2) * x, 1e-3),
        ("tip_acceleration", ("tip_x", "tip_y", "follower_angle"), np.cos(q2) * a[1] - np.sin(q2) * a[0], 0.3),
        ("slider_position", ("crank_angle",), _to_slider(run.columns, scene), 1e-3),
    )
    for name, others, expected, part in identities:
        check = f"identity: {name} from {', '.join(others)}"
        tainted = [column for column in (name, *others) if column in wrong]
        if tainted:
            yield Check(check, "not judged", f"{tainted[0]} is wrong already", "mend that first")
            continue
        inner = slice(3, -3)  # differences are one-sided at the ends
        beside = {column: values[inner] for column, values in run.columns.items()}
        finding = _diagnosed(name, run[name][inner], expected[inner], part * rms(expected[inner]), beside, scene)
        yield Check(check, "passed") if finding is None else Check(check, "failed", finding.cause, finding.advice)


def _first_row(bench: Bench, motion: Motion, wrong: set[str], part: float = 1e-6) -> None:
    """Where the loop puts crank, follower and slider at the start, to a part of the follower's length or of a radian."""
    run, scene = bench.run(motion), motion.scene
    start = motion.start or standard_start(scene)
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
    soft, check = changed(bench.scene, SOFT), "a bent, moving start"
    start = bent_start(soft)
    motion = Motion(soft, _BENT_DURATION, start=start)
    try:
        run = bench.run(motion)
    except (EngineFailure, Refusal) as failure:
        cause = failure.cause if isinstance(failure, EngineFailure) else str(failure)
        advice = "see engines.start_state.reconstruct: it closes the loop for any start"
        yield Check(check, "failed", f"it is not accepted: {cause}", advice)
        return
    known, tolerances = truth(motion).columns, bench.tolerances(motion)
    # a start is met as closely as the model can bend, which its own error of the deflection tells
    deflection = rms(known["tip_deflection"])
    part = 0.5 * deflection if tolerances is None else tolerances["tip_deflection"] + 0.02 * deflection
    first = looked_at(f"first row of {check}", _first_row, bench, motion, wrong, part)
    off = _departure(run, known)
    for cause, left_out in _IGNORED.items():
        other = truth(replace(motion, start=replace(start, **left_out)))
        if _departure(run, other.columns) < 0.4 * off and off > 0.05:
            yield Check(check, "failed", cause, "see engines.start_state.reconstruct: it tells place and velocity of every point")
            return
    yield first
    if not {"slider_position", "crank_angle"} & wrong and rms(_bow(run.columns, soft)) < 0.3 * rms(_bow(known, soft)):
        cause = "slider_position is the straight distance from the pivot, not the arc length"
        yield Check(f"{check}: slider_position", "failed", cause, "integrate along the bent centre line")
        wrong.add("slider_position")
    if first.status == "failed":
        yield Check(check, "not judged", "it does not begin where it should", TELL_THE_AUTHOR)
        return
    yield from _columns(bench, motion, "from a bent, moving start:", wrong, _findings(bench, motion, wrong))


def _departure(run: Trajectory, columns: Mapping[str, Array]) -> float:
    """How far the follower's bend is from another one, relative to that."""
    names = ("tip_deflection", "strain_1", "strain_2", "strain_3")
    return float(np.mean([rms(run[name] - columns[name]) / rms(columns[name]) for name in names]))


def _to_slider(columns: Mapping[str, Array], scene: Mechanism) -> Array:
    """The straight distance from the pivot to the crank's tip, m."""
    crank, angle = scene.crank.length, columns["crank_angle"]
    return np.hypot(crank * np.cos(angle) - scene.pivot_distance, crank * np.sin(angle))


def _bow(columns: Mapping[str, Array], scene: Mechanism) -> Array:
    """By how much the arc length to the slider exceeds its straight distance from the pivot, m."""
    return columns["slider_position"] - _to_slider(columns, scene)
