"""The thesis' open question: which of the methods excel in accuracy and efficiency."""

from collections.abc import Mapping, Sequence
from typing import Final

from cases.benchmark import SCENES, Benchmark, fastest_at, observed_order, pareto_front
from cases.benchmark.findings import LEVELS, Measured, Point
from cases.benchmark.measurement import BUDGET, CONFIRMED, NOT_TRIED
from cases.runs.comparison import REFERENCE
from reports.pages.blocks import Chapter
from reports.pages.content import Content
from reports.tables import benchmark as tables
from reports.tables.benchmark import level_words
from reports.words import case_label, counted, duration, listed, number, percent, size, times

#: Engines that are packages of others, in this project's adapters.
PACKAGES: Final = ("exudyn", "mujoco")
_QUESTION: Final = (
    "The thesis closes with a question: of the methods for a load that moves inside a flexible body's domain, which excel in accuracy and"
    " efficiency? Here every method that it names, its own carried on, and two packages simulate the same beam in the same scenes, over a"
    " ladder of settings each; only the treatment of the constraint and the shapes differ."
)
_LIMITS: Final = (
    "Errors are against a solution of the reference with many modes, which mujoco's chain, refined until it agrees, confirms to the"
    " differences given: an error smaller than that difference is not known better than to it.",
    "Solve time is from the prepared model to the finished table of observables every millisecond, one thread, one process held on one"
    " processor, the least of repetitions that are interleaved over all points. Setup and compilation are apart. On a shared machine ratios"
    " within a scene mean more than seconds.",
    "All methods but exudyn and the dynamics of mujoco are this project's code, compiled alike. mujoco has no joint for this constraint:"
    " its chain is held by a compiled multiplier of this project, with a corrected centre line, which makes it far better than a"
    " polygon of links and is part of what is measured. exudyn runs as it comes, in its C++ core.",
    "Ladders were chosen on run 24. What the methods cost elsewhere is shown as it is, without choosing anew.",
    "This is one beam, one loop, one moving load. A three-dimensional structure, contact, or many bodies are the packages' ground and none"
    " of them is measured here.",
)


def methods(content: Content) -> Chapter:
    """The chapter; a note in its place where nothing was measured."""
    chapter = Chapter("methods", "Which method excels", "Methods")
    chapter.text(_QUESTION)
    found = list(content.benchmarks)
    if not found:
        chapter.text("Speed against error is shown with the 24 runs of the thesis, and after `quickreturn benchmark`.", "note")
        return chapter
    chapter.points([line for table in found[:1] for line in _levels(table)] + _overall(found), numbered=True)
    missing = [case_label(name) for name in SCENES if name not in {table.case for table in found}]
    if missing:
        chapter.text(
            f"Not measured yet: {listed(missing)}. `quickreturn benchmark` measures all scenes and keeps them for this page.", "note"
        )
    chapter.table(tables.fastest(found))
    for table in found:
        _scene(chapter, table, content)
    chapter.heading("Error and degrees of freedom", "freedom", "Degrees of freedom")
    chapter.table(tables.orders(found))
    chapter.heading("The cost of the reference", "reference-cost")
    chapter.table(tables.reference_cost(found[0]))
    chapter.heading("What the joints let through", "joints")
    chapter.table(tables.joints(found[0]))
    chapter.heading("How it was measured, and its limits", "benchmark-limits", "Limits")
    chapter.table(tables.scenes(found))
    chapter.points(_LIMITS)
    chapter.text(_machine(found[0]), "note")
    chapter.table(tables.failures(found))
    chapter.table(tables.points(found))
    return chapter


def headline(content: Content) -> str:
    """The answer in one sentence; "" where nothing was measured."""
    found = list(content.benchmarks)
    firsts = [next(iter(best)) for table in found for level in LEVELS if (best := fastest_at(table.points, level))]
    if not firsts:
        return ""
    counts = {name: firsts.count(name) for name in dict.fromkeys(firsts)}
    shares = [f"{name} in {count} of {len(firsts)}" for name, count in sorted(counts.items(), key=lambda item: -item[1])]
    level = LEVELS[1]
    best = fastest_at(found[0].points, level)
    timed = [_timed(name, measured) for name, (point, measured) in best.items() if point.engine == name]
    told = f" To {level_words(level)} in {case_label(found[0].case)}: {listed(timed)}." if timed else ""
    scenes = counted(len(found), "scene")
    return (
        f"Which method excels, the thesis' open question: fastest to an error of 1, 0.1 and 0.01 % on {scenes} is {listed(shares)}.{told}"
    )


def _levels(table: Benchmark) -> list[str]:
    """One sentence per level: the fastest, the next, the packages."""
    lines = []
    for level in LEVELS:
        found = fastest_at(table.points, level)
        if not found:
            lines.append(f"{level_words(level)} of {case_label(table.case)}'s tip deflection is reached by no method of these ladders.")
            continue
        first, *others = found
        sentence = f"To {level_words(level)} of {case_label(table.case)}'s tip deflection {_timed(first, found[first][1])} is fastest"
        rest = [name for name in others if found[name][0].engine not in (*PACKAGES, found[first][0].engine)]
        told = [_compared(name, found, first) for name in others if name in (*rest[:1], *PACKAGES)]
        sentence += f"; {listed(told)}" if told else ""
        sentence += "".join(f"; {_absent(name, table)}" for name in PACKAGES if name not in found)
        lines.append(f"{sentence}.")
    return lines


def _absent(name: str, table: Benchmark) -> str:
    """Why a package has no time at a level."""
    states = [point.status for point in table.points if point.method == name]
    if any(state.startswith(NOT_TRIED) for state in states):
        return f"{name} was not tried that fine, it took longer than {table.longest:g} s before"
    return f"{name} does not get there with the settings of its ladder" if states else f"{name} is not here"


def _timed(name: str, measured: Measured) -> str:
    return f"{name} ({duration(measured.solve_seconds)})"


def _compared(name: str, found: Mapping[str, tuple[Point, Measured]], first: str) -> str:
    seconds, least = found[name][1].solve_seconds, found[first][1].solve_seconds
    return f"{name} takes {duration(seconds)}, {times(seconds / least)} as long"


def _overall(found: Sequence[Benchmark]) -> list[str]:
    """What holds over all scenes: fronts, orders, models that do not converge."""
    lines = []
    for table in found:
        shares = [point.method for point in pareto_front(table.points)]
        parts = [f"{name} ({counted(shares.count(name), 'setting')})" for name in dict.fromkeys(shares)]
        lines.append(f"Pareto front of {case_label(table.case)}: {listed(parts)}.")
    table = found[0]
    known = {name: observed_order(table.points, name) for name in tables.methods_of(found)}
    told = [f"{name} {number(order, '.1f')}" for name, order in known.items() if order is not None]
    lines.append(f"Observed order of the error in the degrees of freedom, {case_label(table.case)}: {listed(told)}.")
    stuck = _stuck(table)
    if stuck:
        lines.append(f"Finer settings do not help {listed(stuck)} in {case_label(table.case)}: what is left is the model's error.")
    return lines


def _stuck(table: Benchmark) -> list[str]:
    """Methods whose error stays above a half over all their settings, with it."""
    words = []
    for name in tables.methods_of([table]):
        errors = [error for point in table.points if point.method == name and (error := point.error()) is not None]
        if errors and min(errors) > 0.5:
            words.append(f"{name} ({size(min(errors))})")
    return words


def _scene(chapter: Chapter, table: Benchmark, content: Content) -> None:
    label = case_label(table.case)
    title = table.title if table.title.lower().startswith("run ") else f"{label}: {table.title}"
    chapter.heading(title[0].upper() + title[1:], f"benchmark-{table.case.replace('.', '-')}", label)
    if not table.confirmed:
        difference = table.confirmation.get("differences", {}).get("tip_deflection")
        words = f"agree to {size(difference)} only" if difference is not None else "could not be compared"
        chapter.text(
            f"The solution measured against and the one that should confirm it {words}: errors below {percent(CONFIRMED, 'g')} or that"
            " difference say nothing here.",
            "warning",
        )
    chapter.figures(
        (
            content.pictures.of_all.get(f"work precision {table.case}"),
            f"{label}: error over solve time. The grey band is the Pareto front, hollow marks are variants (Hermite elements;"
            " force and slider both linear between nodes); in the"
            " hatched range errors are less than what the two solutions that stand for the truth differ by.",
        ),
        (
            content.pictures.of_all.get(f"freedom {table.case}"),
            f"{label}: error over degrees of freedom.",
        ),
    )
    chapter.table(tables.front(table))


def _machine(table: Benchmark) -> str:
    repeated = (
        f"up to {counted(table.repetitions, 'repetition')} of a point, within {BUDGET:g} s; settings finer than those that take"
        f" {table.longest:g} s were not tried"
    )
    versions = ", ".join(f"{name}: {words}" for name, words in table.machine.items())
    return f"Measured with {repeated}. {versions}. Errors are against {REFERENCE} with many modes, not against its default."
