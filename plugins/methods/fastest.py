"""The fastest methods in a scene, and the figure about them on the first screen."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from quickreturn.engines.registry import own_engines
from quickreturn.plugins.methods.benchmark import Benchmark, Compiling
from quickreturn.plugins.methods.data import benchmarks_of, compiling_of
from quickreturn.plugins.methods.trials.queries import LEVELS, fastest_at
from quickreturn.reports.page.content import Content
from quickreturn.reports.words import case_label, duration, percent, times

#: Engines that are packages of other authors, in this project's adapters.
PACKAGES: Final = ("exudyn", "mujoco")


@dataclass(frozen=True)
class Fastest:
    """The fastest methods in a scene."""

    case: str  # the scene
    level: float  # relative error of the tip deflection that each must reach
    solve_times: Sequence[tuple[str, float]]  # method and s: the fastest, the next of another engine, and the packages
    setup_seconds: float = 0.0  # of the fastest method
    own: bool = False  # whether that is code of this project, compiled for the one mechanism
    compile_seconds: float | None = None  # of its first run on a machine; None if that was not measured


def fastest_in(table: Benchmark, level: float, compiling: Sequence[Compiling] = ()) -> Fastest:
    """The fastest methods in a scene to an error `level` of the tip deflection; `compiling`: what engines compile for."""
    best = fastest_at(table.trials, level)
    if not best:
        return Fastest(table.case, level, [])
    ranked = [(name, trial.engine, trial.seconds) for name, trial in best.items()]
    others = [entry for entry in ranked[1:] if entry[1] != ranked[0][1]]
    shown = ranked[:1] + others[:1] + [entry for entry in others[1:] if entry[0] in PACKAGES]
    first = next(iter(best.values()))
    compiled = next((each.compile_seconds for each in compiling if each.engine == first.engine), None)
    times = [(name, seconds) for name, _, seconds in shown]
    return Fastest(table.case, level, times, first.setup_seconds or 0.0, is_own(first.engine), compiled)


def is_own(engine: str) -> bool:
    """Whether an engine is code of this project, written for the one mechanism."""
    return engine in own_engines() and engine not in PACKAGES


def fastest_figure(content: Content) -> tuple[str, str] | None:
    """The fastest method to the second of the errors at which methods are compared; None if none reaches it."""
    benchmarks, _ = content.of(benchmarks_of)
    if not benchmarks:
        return None
    found = fastest_in(benchmarks[0], LEVELS[1], content.of(compiling_of))
    if not found.solve_times:
        return None
    (name, seconds), *others = found.solve_times
    own = ", made for this mechanism" if found.own else ""
    other = f"; {others[0][0]} takes {times(others[0][1] / seconds)} as long" if others else ""
    once = f" and, once on a machine, {duration(found.compile_seconds)} of compiling" if found.compile_seconds else ""
    solving = f"to solve {case_label(found.case)} to {percent(found.level, 'g')}, after a set-up of {duration(found.setup_seconds)}{once}"
    return duration(seconds), f"{solving}: {name}{own}{other}"
