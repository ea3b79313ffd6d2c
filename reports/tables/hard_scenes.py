"""The matrix of verdicts on the hard scenes, each cell with its claim; the conditioning of the scenes; every cell in full as a file."""

from collections.abc import Mapping
from typing import Any, Final

from cases.judging.conditioning import CHANGE, ILL
from cases.judging.matrix import Judged, Matrix
from cases.judging.verdicts import ACCURATE, CONTRADICTED, DIVERGED, ENDED, NOT_CONVERGED, REFUSED
from reports.tables.table import Cell, Column, Mark, Table, TableBuilder
from reports.words import TIED, number, percent, size

#: How a verdict looks. Its words are in the cell, so that nothing rests on colour.
_MARKS: Final[Mapping[str, Mark]] = {
    ACCURATE: "good",
    ENDED: "good",
    NOT_CONVERGED: "missed",
    CONTRADICTED: "failed",
    DIVERGED: "missed",
    REFUSED: "open",
}


def verdicts(matrix: Matrix) -> Table:
    """A row per scene, a column per engine."""
    builder = TableBuilder(
        "hard_scenes",
        "Verdict on every engine in every hard scene, with the error that it claims of its tip deflection (RMS over RMS, from coarser and"
        " finer settings of its own, not from the right answer) and, where the run or the judgement ends before the scene's duration, up to"
        " when. The reason is where the pointer rests, and in the CSV file.",
        (
            Column("scene", "scene", in_page=False),
            Column("title", "run 24 with"),
            *(Column(name, name) for name in matrix.engines),
        ),
    )
    for case in matrix.cases:
        cells = {name: _cell(matrix.cells.get((case.name, name)), case.duration) for name in matrix.engines}
        builder.add(scene=case.name, title=short_title(case.title), **cells)
    return builder.table()


def short_title(title: str) -> str:
    """What is changed in run 24."""
    return title.removeprefix("Run 24, ")


def _cell(judged: Judged | None, duration: float) -> Cell:
    if judged is None:
        return Cell(None, "not computed", mark="open")
    verdict = judged.verdict
    if judged.silently_wrong:
        return Cell(
            "silently wrong", f"silently wrong: claims {_size(verdict.claimed_error)}, is {_size(judged.true_error)}", mark="failed"
        )
    texts = {
        ACCURATE: f"accurate {_size(verdict.claimed_error)}" + _until(verdict.stretch, duration),
        ENDED: f"ends at {_time(verdict.time)}, until then accurate {_size(verdict.claimed_error)}",
        NOT_CONVERGED: NOT_CONVERGED,
        CONTRADICTED: CONTRADICTED,
        DIVERGED: "no result" if verdict.time is None else f"diverged at {_time(verdict.time)}",
        REFUSED: REFUSED,
    }
    text = texts[verdict.kind]
    if judged.model_error is not None and verdict.kind in (ACCURATE, ENDED):
        text += f" (its model: {size(judged.model_error)} off)"
    return Cell(verdict.kind, text, verdict.reason, _MARKS[verdict.kind])


def _size(error: float | None) -> str:
    return "unknown" if error is None else size(error)


def _time(time: float | None) -> str:
    return "an unknown time" if time is None else f"{number(time, '.4g')}{TIED}s"


def _until(stretch: float | None, duration: float) -> str:
    if stretch is None or stretch >= duration * (1.0 - 1e-9):
        return ""
    return f" up to {_time(stretch)}, then in energy, extremes and spectrum"


def conditioning(matrix: Matrix) -> Table:
    """What a small change of a parameter does to the answer of each scene."""
    part = f"{number(100.0 * CHANGE, 'g')}{TIED}%"
    changes = ("stiffness", "damping", "speed", "speed at the same crank angle")
    builder = TableBuilder(
        "hard_scenes_conditioning",
        "Change of the tip deflection (RMS over RMS, by the reference, over the scene's duration or until it ends) when a parameter grows"
        f" by {part}. Horizon: until when no change reaches {percent(ILL, '.0f')}, where a change of speed counts at the same crank angle;"
        " beyond it two good solutions run apart. Converged: estimated error of the solution that the verdicts are checked against.",
        (
            Column("scene", "scene", in_page=False),
            Column("title", "run 24 with"),
            *(Column(_key(name), name, "1", ".2g", "%", 100.0, group=f"change of the answer for {part} of") for name in changes),
            Column("horizon", "horizon", "s", ".3g"),
            Column("duration", "duration", "s", "g"),
            Column("converged", "converged", "1", ".2g", "%", 100.0),
        ),
    )
    for case in matrix.cases:
        found = matrix.conditionings.get(case.name)
        values: dict[str, Any] = {_key(name): found.changes.get(name) for name in changes} if found else {}
        builder.add(
            scene=case.name,
            title=short_title(case.title),
            horizon=found.horizon if found else None,
            duration=case.duration,
            converged=matrix.converged.get(case.name),
            **values,
        )
    return builder.table()


def _key(change: str) -> str:
    return change.replace(" ", "_")


def cells(matrix: Matrix) -> Table:
    """Every cell with its evidence, as a file."""
    builder = TableBuilder(
        "hard_scenes_cells",
        "Every cell of the matrix: verdict and reason, claimed error, the error found afterwards against the converged solution, settings.",
        (
            Column("scene", "scene"),
            Column("engine", "engine"),
            Column("verdict", "verdict"),
            Column("reason", "reason"),
            Column("claimed_error", "claimed", "1", ".2g"),
            Column("stretch", "up to", "s", "g"),
            Column("time", "time", "s", "g"),
            Column("true_error", "found afterwards", "1", ".2g"),
            Column("claim_holds", "holds"),
            Column("model_error", "model error", "1", ".2g"),
            Column("settings", "settings"),
        ),
        in_page=False,
    )
    known = (matrix.cells.get((case.name, name)) for case in matrix.cases for name in matrix.engines)
    for cell in filter(None, known):
        builder.add(
            {**vars(cell.verdict), **vars(cell)},
            verdict=cell.verdict.kind,
            claim_holds=cell.holds,
            settings=", ".join(f"{name} = {value}" for name, value in cell.settings.items()),
        )
    return builder.table()
