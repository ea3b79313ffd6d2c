"""Checks of a trajectory: its rows and pieces, each column against `reference`, identities that need none, first rows, a bent start.

A wrong column is left out of later checks, so that each mistake is reported once.
"""

import functools
import itertools
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, Final, NamedTuple

import numpy as np

from quickreturn.cases.conformance.bench import DECISIVE, ROUNDING, Bench, Motion, bent_start, compared_columns, solution, truth
from quickreturn.cases.conformance.checks import TELL_THE_AUTHOR, Array, Check, Fault, check_by, some
from quickreturn.cases.conformance.models import WrongModel, acts_as_if
from quickreturn.cases.conformance.rows import output_steps, pieces
from quickreturn.cases.conformance.scenes import OUTPUT_STEP, SOFT
from quickreturn.cases.mistakes.diagnosis import Finding, diagnose, lateness, share_of
from quickreturn.cases.mistakes.explanation import Hypothesis, explain
from quickreturn.engines.base import EngineFailure, Refusal
from quickreturn.engines.relative import rms
from quickreturn.engines.start import Start, standard_start
from quickreturn.engines.start_state import reconstruct
from quickreturn.engines.trajectory import Trajectory
from quickreturn.reference_model.mechanism import Mechanism, Scene
from quickreturn.reference_model.scene_values import changed

_BENT_DURATION: Final = 0.25  # s
#: Mistake -> the fields of the start that it changes.
_IGNORED: Final[Mapping[str, Mapping[str, Any]]] = {
    "the start's deflection and its rate are ignored: the follower begins straight": {"deflection": None, "deflection_rate": None},
    "the start's deflection rate is ignored: the follower begins bent and is not bending": {"deflection_rate": None},
    "the start's deflection is ignored: the follower begins straight": {"deflection": None},
}
#: Relative RMS difference of the later bend up to which no part of a bent start counts as ignored.
_IGNORABLE: Final = 0.05
#: A difference of which a finer rung leaves at most this part comes from the resolution.
FALLS: Final = 0.7
#: Largest number of unexplained columns that are reported one by one, unless one is off by `_WILD` times its size.
_ONE_BY_ONE: Final = 3
_WILD: Final = 1.0
#: Smallest relative difference for which a column is called coarse.
_COARSE: Final = 0.02


def motion(bench: Bench) -> Iterator[Check]:
    """All checks of a trajectory, in order; what needs other output steps comes last if the time is limited."""
    try:
        late, depending, wrong_columns, model = mistakes_in_mild_scene(bench)
    except EngineFailure as failure:
        yield Check("a trajectory", "failed", f"none is delivered in a mild scene: {failure.cause}", failure.advice)
        return
    wrong = set(late)
    if bench.seconds is None:
        yield check_by("pieces continue", pieces, bench, wrong | set(depending))
    yield from late.values()
    yield from _columns(bench, bench.mild, "column", wrong, wrong_columns, model)
    yield from dict.fromkeys(check for column, check in depending.items() if column not in wrong)  # an explained column is reported once
    wrong.update(depending)
    yield from _identities(bench.run(bench.mild), bench.scene, wrong)
    yield check_by("first row of the standard start", check_first_row, bench, bench.mild, wrong)
    yield from _bent(bench, wrong)
    if bench.seconds is not None:
        yield check_by("pieces continue", pieces, bench, wrong)
        late, depending = output_steps(bench)
        yield from dict.fromkeys(check for column, check in (late | depending).items() if column not in wrong)


class MistakesInMildScene(NamedTuple):
    """An engine's mistakes in the mild scene, by column."""

    late: Mapping[str, Check]  # columns that come late with a coarser output step
    depending: Mapping[str, Check]  # columns that depend on the output step in another way
    findings: Mapping[str, Finding]  # other wrong columns
    model: WrongModel | None  # a mistake of the model that explains these findings

    @property
    def columns(self) -> frozenset[str]:
        """Columns whose own rows are wrong: no other check reports them again."""
        explained = {name for name, finding in self.findings.items() if finding.explained and self.model is None}
        return frozenset({*self.late, *self.depending, *explained})

    @property
    def motion(self) -> bool:
        """Whether the motion itself is wrong, not only the rows of some columns."""
        return self.model is not None or not all(finding.explained for finding in self.findings.values())


@functools.lru_cache(maxsize=1)
def mistakes_in_mild_scene(bench: Bench) -> MistakesInMildScene:
    """The mistakes in the mild scene's trajectory, and with other output steps unless the time is limited. EngineFailure: there is none."""
    run, (late, depending) = bench.run(bench.mild), output_steps(bench) if bench.seconds is None else ({}, {})
    wrong = findings(bench, bench.mild, late)
    if len(wrong) < 2:
        return MistakesInMildScene(late, depending, wrong, None)
    of_rows = {name for name in wrong if wrong[name].explained and len(wrong) == 2}
    moves = {name: run[name] for name in compared_columns(run, DECISIVE) if name not in late and name not in of_rows}
    return MistakesInMildScene(late, depending, wrong, acts_as_if(bench.mild, moves, bench.tolerances(bench.mild)))


def _columns(
    bench: Bench, motion: Motion, kind: str, wrong: set[str], wrong_columns: Mapping[str, Finding], model: WrongModel | None = None
) -> Iterator[Check]:
    """Each column against `reference`; or the model, if it explains several at once."""
    run, off = bench.run(motion), {name: error for name, error in bench.errors(motion).items() if name not in wrong}
    if model is not None:
        worst = max(wrong_columns, key=lambda name: off[name])
        yield Check(
            f"{kind}s together", "failed", f"{model.finding.cause} ({worst} is off by {share_of(off[worst])})", model.finding.advice
        )
        wrong.update(off)
        return
    before = sorted(wrong & set(run.columns))
    by_itself = "" if bench.tolerances(motion) is not None else ", and makes no claim that it is not"
    puzzling = [name for name in wrong_columns if not wrong_columns[name].explained]
    if len(puzzling) > _ONE_BY_ONE and all(off[name] < _WILD for name in puzzling):
        yield _together(f"{kind}s together", puzzling, off)
        wrong.update(puzzling)
    told = [name for name in off if name in wrong_columns and name not in wrong]
    wrong.update(told)
    for names in _of_a_kind(told):
        cause, several = wrong_columns[names[0]].cause, len(names) > 1
        more = f"; {len(names) - 1} more of {names[0]} to {names[-1]} are so, or wrong otherwise" if several else ""
        yield Check(_named(kind, names), "failed", f"{cause}{more}", wrong_columns[names[0]].advice)
    passed = {name: f"coarse: {share_of(part)} from reference{by_itself}" if part > _COARSE else "" for name, part in off.items()}
    agreeing = [name for name in off if name not in wrong_columns]
    yield from (Check(f"{kind} {name}", "passed", passed[name]) for name in agreeing if passed[name])
    yield from (Check(_named(kind, names), "passed") for names in _of_a_kind([name for name in agreeing if not passed[name]]))
    if before:
        yield Check(f"{kind} {some(before)}", "not judged", "they are wrong already", "mend those first")


def _of_a_kind(names: Sequence[str]) -> Iterator[list[str]]:
    """Groups of columns: single ones, and all of a numbered kind such as `shape_01` together."""
    for stem, kind in itertools.groupby(names, key=lambda name: name.rstrip("0123456789")):
        several = list(kind)
        yield from [several] if len(several) > _ONE_BY_ONE and stem != several[0] else ([name] for name in several)


def _named(kind: str, names: Sequence[str]) -> str:
    return f"{kind} {names[0]}" + (f" to {names[-1]}" if len(names) > 1 else "")


def _together(check: str, names: Sequence[str], off: Mapping[str, float]) -> Check:
    """One check for many columns that are off by less than a mistake would make."""
    worst = sorted(names, key=lambda name: -off[name])[:_ONE_BY_ONE]
    most = ", ".join(f"{name} by {share_of(off[name])}" for name in worst)
    cause = f"{len(names)} columns are off by more than the engine's own estimate says, most {most}; no single mistake explains it"
    return Check(check, "failed", cause, "either the estimate is too small, or the model departs: compare a much finer run with reference")


def findings(bench: Bench, motion: Motion, left_out: Iterable[str]) -> dict[str, Finding]:
    """The mistake in each wrong column, by its name; `left_out`: columns that are not looked at."""
    run, right, tolerances = bench.run(motion), truth(motion).columns, bench.tolerances(motion)
    wrong: dict[str, Finding] = {}
    for name in compared_columns(run, right=right):
        if name not in left_out:
            tolerance = None if tolerances is None else tolerances[name]
            finding = _diagnosed(name, run[name], right[name], tolerance, right, motion.scene)
            if finding is not None:
                wrong[name] = finding
    if tolerances is None:
        return _alike_in_all_places(wrong, run)
    puzzling = [name for name, finding in wrong.items() if not finding.explained or finding.fitted]
    if puzzling:
        for name in falling(bench, motion, puzzling):
            del wrong[name]
    return wrong


def _alike_in_all_places(wrong: dict[str, Finding], run: Trajectory) -> dict[str, Finding]:
    """Findings for a model without an error estimate; findings at places along the follower count only if all places show the same."""
    kept = dict(wrong)
    for names in _of_a_kind(compared_columns(run)):
        causes = {wrong[name].cause.removeprefix(name) if name in wrong else "" for name in names}
        if len(names) > 1 and len(causes) > 1:
            kept = {name: finding for name, finding in kept.items() if name not in names}
    return kept


def falling(bench: Bench, motion: Motion, names: Iterable[str]) -> list[str]:
    """Columns whose error falls with finer settings, or was larger with coarser ones.

    Their mistake is an estimate that is too small, which another check reports.
    """
    run, right, left = bench.run(motion), truth(motion).columns, list(names)
    fallen, finest = list[str](), True
    for finer in bench.sharpened(motion):
        finest = False
        fallen += [name for name in left if rms(finer[name] - right[name]) <= FALLS * rms(run[name] - right[name])]
        left = [name for name in left if name not in fallen]
        if not left:
            break
    if finest and (coarser := bench.coarsened(motion)) is not None:
        fallen += [name for name in left if rms(run[name] - right[name]) <= FALLS * rms(coarser[name] - right[name])]
    return fallen


def _diagnosed(
    name: str, found: Array, expected: Array, tolerance: float | None, right: Mapping[str, Array], scene: Scene
) -> Finding | None:
    """As `diagnose`; a column may also come late, whatever the output step."""
    off = rms(found - expected)
    late = lateness(found, expected) if off > ROUNDING * rms(expected) else ()
    return diagnose(name, found, expected, tolerance, right, scene, late)


def _identities(run: Trajectory, scene: Mechanism, wrong: set[str]) -> Iterator[Check]:
    """Identities between the columns of one trajectory, for any model."""
    d, h, q2 = scene.pivot_distance, OUTPUT_STEP, run["follower_angle"]
    x, y = run["tip_x"] - d, run["tip_y"]
    a = np.gradient(np.gradient([x, y], h, axis=1), h, axis=1)
    identities: Sequence[tuple[str, tuple[str, ...], Array, float]] = (
        ("crank_speed", ("crank_angle",), np.gradient(run["crank_angle"], h), 0.01),
        ("tip_deflection", ("tip_x", "tip_y", "follower_angle"), np.cos(q2) * y - np.sin(q2) * x, 1e-3),
        ("tip_acceleration", ("tip_x", "tip_y", "follower_angle"), np.cos(q2) * a[1] - np.sin(q2) * a[0], 0.3),
        ("slider_position", ("crank_angle",), _to_slider(run.columns, scene), 1e-3),
        *(
            (name, (other,), np.gradient(run[other], h), part)
            for name, other, part in (("follower_rate", "follower_angle", 0.01), ("follower_acceleration", "follower_rate", 0.05))
            if {name, other} <= run.columns.keys()
        ),
    )
    for name, others, expected, part in identities:
        check = f"identity: {name} from {', '.join(others)}"
        tainted = [column for column in (name, *others) if column in wrong]
        if tainted:
            yield Check(check, "not judged", f"{tainted[0]} is wrong already", "mend that first")
            continue
        inner = slice(3, -3)  # differences are one-sided at the ends
        columns = {column: values[inner] for column, values in run.columns.items()}
        finding = _diagnosed(name, columns[name], expected[inner], part * rms(expected[inner]), columns, scene)
        yield Check(check, "passed") if finding is None else Check(check, "failed", finding.cause, finding.advice)


def check_first_row(bench: Bench, motion: Motion, wrong: set[str], part: float = 1e-6) -> None:
    """Check the first row: crank, follower and slider at the start, to `part` of the follower's length or of a radian, or as claimed."""
    run, scene, allowed = bench.run(motion), motion.scene, bench.tolerances(motion) or {}
    assert scene.crank is not None
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
        first, second = map(float, run[name][:2])
        size = abs(start.crank_speed) if name == "crank_speed" else 1.0
        if name not in wrong and abs(first - value) > max(part * size, allowed.get(name, 0.0)):
            cause = f"{name} is {first:.6g} in the first row, the start puts it at {value:.6g}"
            if abs(first - second) < abs(first - value) and name != "crank_speed":
                cause += "; the first row is not the start"
            raise Fault(cause, "deliver the state of the start as the first row, before any step")


def _bent(bench: Bench, wrong: set[str]) -> Iterator[Check]:
    """Check a start with a bent follower in motion: its first row, and the motion from there."""
    soft, check = changed(bench.scene, SOFT), "a bent, moving start"
    start = bent_start(soft)
    motion = Motion(soft, _BENT_DURATION, start=start)
    try:
        run = bench.run(motion)
    except Refusal as refusal:
        yield Check(check, "passed", f"refused: {refusal}")
        return
    except EngineFailure as failure:
        advice = "see engines.start_state.reconstruct: it closes the loop for any start"
        yield Check(check, "failed", f"it is not accepted: {failure.cause}", advice)
        return
    right, tolerances = truth(motion).columns, bench.tolerances(motion)
    # the model reproduces a bent start to about its own error of the deflection
    deflection = rms(right["tip_deflection"])
    part = 0.5 * deflection if tolerances is None else tolerances["tip_deflection"] + 0.02 * deflection
    first = check_by(f"first row of {check}", check_first_row, bench, motion, wrong, part)
    if ignored := _ignored(run.columns, motion, start):
        yield Check(check, "failed", ignored, "see engines.start_state.reconstruct: it tells place and velocity of every point")
        return
    yield first
    if not {"slider_position", "crank_angle"} & wrong and rms(_bow(run.columns, soft)) < 0.3 * rms(_bow(right, soft)):
        cause = "slider_position is the straight distance from the pivot, not the arc length"
        yield Check(f"{check}: slider_position", "failed", cause, "integrate along the bent centre line")
        wrong.add("slider_position")
    if first.status == "failed":
        yield Check(check, "not judged", "it does not begin where it should", TELL_THE_AUTHOR)
        return
    yield from _columns(bench, motion, "from a bent, moving start:", wrong, findings(bench, motion, wrong))


def _ignored(run: Mapping[str, Array], motion: Motion, start: Start) -> str:
    """The part of a bent start that is ignored, recognised from the later bend; "" if none is."""
    right = truth(motion).columns

    def bend(columns: Mapping[str, Array]) -> Array:
        return np.concatenate([columns[name] / rms(right[name]) for name in ("tip_deflection", "strain_1", "strain_2", "strain_3")])

    if rms(bend(run) - bend(right)) <= _IGNORABLE:
        return ""
    others = (
        Hypothesis(cause, "", bend(solution(replace(motion, start=replace(start, **left_out))))) for cause, left_out in _IGNORED.items()
    )
    explained = explain(bend(run), bend(right), others, coarse=True)
    return "" if explained is None else explained.words


def _to_slider(columns: Mapping[str, Array], scene: Mechanism) -> Array:
    """The straight distance from the pivot to the crank's tip, m."""
    crank, angle = scene.crank.length, columns["crank_angle"]
    return np.hypot(crank * np.cos(angle) - scene.pivot_distance, crank * np.sin(angle))


def _bow(columns: Mapping[str, Array], scene: Mechanism) -> Array:
    """By how much the arc length to the slider exceeds its straight distance from the pivot, m."""
    return columns["slider_position"] - _to_slider(columns, scene)
