"""Hard scenes: the verdict on every engine in every hard scene, with its claim, and the conditioning of the scenes."""

from collections import Counter
from collections.abc import Mapping
from typing import Any, Final

from quickreturn.cases.library.hard import IMPOSSIBLE
from quickreturn.engines.registry import MODEL
from quickreturn.plugins.methods.data import matrix_of
from quickreturn.plugins.methods.judging.conditioning import CHANGE, ILL
from quickreturn.plugins.methods.judging.matrix import REQUESTED, Judged, Matrix
from quickreturn.plugins.methods.judging.verdicts import (
    ACCURATE,
    CONTRADICTED,
    DIVERGED,
    ENDED,
    LATER,
    MEANINGS,
    NOT_CONVERGED,
    OWN_EQUATIONS,
    REFUSED,
    Verdict,
)
from quickreturn.reports.page.chapter import Chapter
from quickreturn.reports.page.content import Content
from quickreturn.reports.tables.table import Cell, Column, ColumnList, Mark, Table
from quickreturn.reports.words import TIED, counted, number, percent, percents, size

#: The look of a verdict. The cell also contains its words, so that colour alone carries no information.
_MARKS: Final[Mapping[str, Mark]] = {
    ACCURATE: "good",
    ENDED: "good",
    OWN_EQUATIONS: "model",
    NOT_CONVERGED: "missed",
    CONTRADICTED: "failed",
    DIVERGED: "missed",
    REFUSED: "open",
}
#: Columns that name a scene: its name in the CSV file, its change of run 24 in the page.
_SCENE: Final = (Column("scene", in_page=False), Column("title", "run 24 with"))


def hard_scenes(content: Content) -> Chapter | None:
    """The chapter; None if no matrix of verdicts is stored."""
    matrix, record = content.of(matrix_of)
    if matrix is None:
        return None
    missing = len(matrix.cases) * len(matrix.engines) - len(matrix.cells)
    facts = {
        "of_record": record,
        "requested": REQUESTED,
        "silently_wrong": [f"{cell.engine} in {cell.scene}" for cell in matrix.silently_wrong],
        "missing": f"{counted(missing, 'cell')} of the matrix {'has' if missing == 1 else 'have'} not been computed." if missing else "",
        "meanings": MEANINGS,
        "model": MODEL,
        "of_model": MODEL in matrix.engines,
        "impossible": list(IMPOSSIBLE.values()),
        "change": CHANGE,
        "ill": ILL,
        "later": LATER,
        "verdicts": verdicts(matrix),
        "conditioning": conditioning(matrix),
        "cells": cells(matrix),
    }
    return Chapter("hard", "Hard scenes", finding(matrix), facts)


def finding(matrix: Matrix) -> str:
    """The number of cells with each verdict, and of claims that were checked and did not hold."""
    kinds, checked = Counter(cell.kind for cell in matrix.cells.values()), _checked(matrix)
    texts = [_own_equations(matrix, kinds[kind]) if kind == OWN_EQUATIONS else f"{kinds[kind]} {kind}" for kind in MEANINGS if kinds[kind]]
    wrong, own = len(matrix.silently_wrong), sum(cell.of_own_equations for cell in checked)
    told = f"{counted(wrong, 'claim')} did not hold" if wrong else "none silently wrong"
    against = f", {own} of them against a model’s own equations" if own else ""
    return f"Of {counted(len(matrix.cells), 'cell')} {', '.join(texts)}; {told} of {len(checked)} claims that could be checked{against}"


def _checked(matrix: Matrix) -> list[Judged]:
    """The cells whose claim could be checked."""
    return [cell for cell in matrix.cells.values() if cell.holds is not None]


def _own_equations(matrix: Matrix, count: int) -> str:
    """The number of cells that solve the engine's own equations alone, and how far the model is off there."""
    off = [cell.model_error for cell in matrix.cells.values() if cell.kind == OWN_EQUATIONS and cell.model_error is not None]
    how_far = percents(min(off), max(off), ".0f") if len(off) > 1 else size(off[0]) if off else ""
    model = f" ({MODEL}, whose model is {how_far} off there)" if how_far else ""
    return f"{count} {'solve their' if count > 1 else 'solves its'} own equations alone{model}"


def verdicts(matrix: Matrix) -> Table:
    """A row per scene, a column per engine."""
    table = Table(
        "hard_scenes",
        """Verdict on every engine in every hard scene, and the error that the engine claims for its tip deflection (RMS over RMS, from its
        own coarser and finer settings, not from the right answer). If the run or the judgement ends before the scene's duration, the cell
        gives the time. A click on a verdict shows the reason; the CSV file has it, too.""",
        (*_SCENE, *(Column(name, name) for name in matrix.engines)),
    )
    for case in matrix.cases:
        of_engines = {name: _cell(matrix.cells.get((case.name, name)), case.duration) for name in matrix.engines}
        table.add(scene=case.name, title=short_title(case.title), **of_engines)
    return table


def short_title(title: str) -> str:
    """The title of a scene without "Run 24, ", so that it names the change alone."""
    return title.removeprefix("Run 24, ")


def _cell(judged: Judged | None, duration: float) -> Cell:
    if judged is None:
        return Cell(None, "not computed", mark="open")
    verdict = judged.verdict
    claimed = _size(verdict.claimed_error)
    if judged.silently_wrong:
        return Cell("silently wrong", f"silently wrong: claims {claimed}, is {_size(judged.true_error)}", mark="failed")
    texts = {
        ACCURATE: f"accurate {claimed}{_until(verdict.stretch, duration)}",
        ENDED: f"ends at {_time(verdict.time)}, until then accurate {claimed}",
        DIVERGED: "no result" if verdict.time is None else f"diverged at {_time(verdict.time)}",
    }
    text = texts.get(verdict.kind, verdict.kind)
    if judged.kind == OWN_EQUATIONS:
        text = f"{OWN_EQUATIONS}{_ends(verdict)}; its model is {_off(judged.model_error)}"
    elif judged.model_error is not None and verdict.kind in (ACCURATE, ENDED):
        text += f" (its model: {_off(judged.model_error)})"
    return Cell(judged.kind, text, verdict.reason, _MARKS[judged.kind])


def _ends(verdict: Verdict) -> str:
    return f", whose slider leaves at {_time(verdict.time)}" if verdict.kind == ENDED else ""


def _off(model_error: float | None) -> str:
    return "of unknown error" if model_error is None else f"{size(model_error)} off"


def _size(error: float | None) -> str:
    return "unknown" if error is None else size(error)


def _time(time: float | None) -> str:
    return "an unknown time" if time is None else f"{number(time, '.4g')}{TIED}s"


def _until(stretch: float | None, duration: float) -> str:
    if stretch is None or stretch >= duration * (1.0 - 1e-9):
        return ""
    return f" up to {_time(stretch)}, then in energy, extremes and spectrum"


def conditioning(matrix: Matrix) -> Table:
    """Effect of a small change of a parameter on the answer of each scene."""
    change = f"{number(100.0 * CHANGE, 'g')}{TIED}%"
    changes = ("stiffness", "damping", "speed", "speed at the same crank angle")
    columns = (
        *_SCENE,
        *(Column(_key(name), name, "%", ".2g", group=f"change of the answer for {change} of") for name in changes),
        Column("horizon", unit="s", form=".3g"),
        Column("duration", unit="s", form="g"),
        Column("converged", unit="%", form=".2g"),
    )
    table = Table(
        "hard_scenes_conditioning",
        f"""Change of the tip deflection when a parameter grows by {change} (RMS over RMS, computed by the reference, over the scene's
        duration or until the run ends). Horizon: the time until which no change reaches {percent(ILL, ".0f")} (after a change of speed, tip
        deflections are compared at the same crank angle); beyond it two good solutions diverge. Converged: estimated error of the solution
        against which the verdicts are checked.""",
        columns,
    )
    for case in matrix.cases:
        conditioned = matrix.conditionings.get(case.name)
        values: dict[str, Any] = {_key(name): conditioned.changes.get(name) for name in changes} if conditioned else {}
        table.add(conditioned, scene=case.name, title=short_title(case.title), duration=case.duration, **values)
    return table


def _key(change: str) -> str:
    return change.replace(" ", "_")


def cells(matrix: Matrix) -> Table:
    """Every cell with its evidence, as a file."""
    numbers = {"claimed_error": "1", "stretch": "s", "time": "s", "true_error": "1"}
    columns: ColumnList = (
        *("scene", "engine", "verdict", "reason"),
        *(Column(key, unit=unit) for key, unit in numbers.items()),
        "claim_holds",
        Column("model_error", unit="1"),
        "settings",
    )
    table = Table(
        "hard_scenes_cells",
        "Every cell of the matrix: verdict and reason, claimed error, the error against the converged solution, settings.",
        columns,
        in_page=False,
    )
    judged = (matrix.cells.get((case.name, name)) for case in matrix.cases for name in matrix.engines)
    for cell in filter(None, judged):
        settings = ", ".join(f"{name} = {value}" for name, value in cell.settings.items())
        table.add({**vars(cell.verdict), **vars(cell)}, verdict=cell.kind, claim_holds=cell.holds, settings=settings)
    return table
