"""The hard scenes: where engines break, and whether they say so."""

from cases.case_file import load_case
from cases.jobs.workshop import Workshop
from cases.judging.conditioning import CHANGE, ILL
from cases.judging.matrix import MODEL, REQUESTED, Matrix, judge_scenes
from cases.judging.verdicts import LATER, MEANINGS
from cases.library import catalogue
from cases.library.hard import IMPOSSIBLE, TAG
from reports.pages.blocks import Chapter
from reports.pages.content import Content
from reports.tables import hard_scenes as tables
from reports.words import counted, percent


def stored_matrix(workshop: Workshop) -> Matrix | None:
    """What `make verify` left of the matrix, without computing anything; None where there is nothing."""
    matrix = judge_scenes([load_case(entry.name) for entry in catalogue(TAG)], workshop, compute=False)
    return matrix if matrix.cells else None


def hard_scenes(content: Content) -> Chapter:
    """The matrix of verdicts."""
    chapter = Chapter("hard", "Hard scenes: where engines break, and whether they say so", "Hard scenes")
    matrix = content.hard_scenes
    if matrix is None:
        chapter.text(
            f"Every engine on {counted(len(catalogue(TAG)), 'hard scene')} (`quickreturn cases --tag {TAG}`) is judged by `make verify`. It"
            " has not been run with this store, or with other code than this page.",
            "note",
        )
        return chapter
    chapter.text(
        "Each scene is run 24 with something changed that makes it hard, or an ordinary machine with a stiff arm. Every engine is asked for"
        f" a tip deflection good to {percent(REQUESTED, '.0f')} and judged by what its runs show of themselves: how far they are from the"
        " same scene at coarser and at finer settings, whether their energy balance closes, and whether other engines contradict them."
        " None of this knows the right answer; afterwards every claim is checked against a converged solution."
    )
    chapter.text(*_outcome(matrix))
    chapter.points([f"{kind}: {meaning}." for kind, meaning in MEANINGS.items()])
    chapter.table(tables.verdicts(matrix))
    if MODEL in matrix.engines:
        chapter.text(
            f"The discretization of {MODEL} is its model: it is judged by how well it solves its own equations, and how far these are from"
            " the converged solution stands beside the verdict.",
            "note",
        )
    chapter.heading("Scenes that cannot be", "hard-impossible")
    chapter.text("A mechanism whose slider would leave the follower by its geometry alone is refused before anything runs:")
    chapter.points(list(IMPOSSIBLE.values()))
    chapter.heading("How well the scenes are conditioned", "hard-conditioning")
    chapter.text(
        f"No parameter is known to {percent(CHANGE, 'g')}. Where so little moves the answer by more than {percent(ILL, '.0f')}, a verdict"
        f" of accurate means agreement up to a horizon, and beyond it energy, extremes and spectrum to within {percent(LATER, '.0f')}; the"
        " cell says up to when."
    )
    chapter.table(tables.conditioning(matrix))
    chapter.table(tables.cells(matrix))
    return chapter


def _outcome(matrix: Matrix) -> tuple[str, str]:
    """What the check against the converged solution found, with its tone."""
    checked = [cell for cell in matrix.cells.values() if cell.holds is not None]
    wrong = matrix.silently_wrong
    missing = len(matrix.cases) * len(matrix.engines) - len(matrix.cells)
    text = f"Of {counted(len(matrix.cells), 'cell')} {len(checked)} claim an accuracy that could be checked; "
    if wrong:
        names = ", ".join(f"{cell.engine} in {cell.scene}" for cell in wrong)
        text += f"{counted(len(wrong), 'claim')} did not hold: {names}."
    else:
        text += "every one of these claims held: no cell is silently wrong."
    if missing:
        text += f" {counted(missing, 'cell')} of the matrix {'has' if missing == 1 else 'have'} not been computed."
    return text, "warning" if wrong else ""
