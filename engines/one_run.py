"""One run of an engine, and its natural frequencies, with the checks that both must pass.

They have one thread for linear algebra, for the eigenproblems of shapes are small: with a second one they use up to thirty times the
processor time, and save none.
"""

import contextlib
import gc
import math
import re
import time
import traceback
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import wraps
from pathlib import Path
from typing import Any, Final, Generic, TypeVar

import numpy as np
from threadpoolctl import threadpool_limits

from quickreturn.engines import progress
from quickreturn.engines.base import AnyEngine, EngineFailure, Refusal, Simulation, first_line
from quickreturn.engines.registry import MAIN
from quickreturn.engines.settings import SettingError, Settings
from quickreturn.engines.start import Start
from quickreturn.engines.trajectory import Trajectory
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.errors import OF_THE_MACHINE
from quickreturn.reference_model.mechanism import Mechanism, Scene

R = TypeVar("R")

#: Libraries below an engine: where a mistake of the engine surfaces in one, the message names the engine's line.
_BELOW: Final = frozenset({"numpy", "scipy"})
#: Change of the follower's angle between two rows, rad, that is a jump: while the slider passes close to P it turns by at most half a turn.
JUMP: Final = 1.5 * math.pi


@dataclass(frozen=True)
class CompletedRun:
    """The trajectory of a run, and the simulation at its end, which can be advanced further."""

    trajectory: Trajectory
    simulation: Simulation


class Remembered(Generic[R]):
    """Computes the result for some settings once. A failure is remembered, too.

    Attributes:
        results: results by settings.
    """

    def __init__(self, compute: Callable[[Settings], R], known: Mapping[Settings, R] | None = None) -> None:
        self.results = dict(known or {})
        self._failures: dict[Settings, EngineFailure] = {}
        self._compute = compute

    def __call__(self, settings: Settings) -> R:
        """The result for some settings. Raises EngineFailure, and what else the computation raises."""
        if settings in self._failures:
            raise self._failures[settings]
        if settings not in self.results:
            try:
                self.results[settings] = self._compute(settings)
            except EngineFailure as failure:
                self._failures[settings] = failure
                raise
        return self.results[settings]


def run_once(engine: AnyEngine, scene: Scene, start: Start | None, duration: float, output_step: float, settings: Settings) -> CompletedRun:
    """One run with the given settings, checked to be complete and finite.

    Raises:
        Refusal, SettingError: as the engine raises them.
        EngineFailure: the run broke down; any other exception of the engine is reported as this too.
        MemoryError, OSError, ImportError: memory, disk or another resource is exhausted, or a library is missing.
    """
    try:
        simulation = engine.prepare(scene, start, settings)
        trajectory = simulation.advance(duration, output_step)
    except (Refusal, SettingError, EngineFailure, *OF_THE_MACHINE):
        raise
    except Exception as error:  # a third-party engine may raise anything
        if lacks_memory(error):
            raise MemoryError(first_line(error)) from error
        raise EngineFailure(0.0, raised(error), "report this to the author of the engine") from error
    check_trajectory(trajectory, duration, output_step)
    if scene.turns_fully:
        _check_turning(trajectory)
    return CompletedRun(trajectory, simulation)


def _check_turning(trajectory: Trajectory) -> None:
    """Raise `EngineFailure` if the angle of a follower that turns fully jumps by a turn."""
    jumps = np.flatnonzero(np.abs(np.diff(trajectory["follower_angle"])) > JUMP)
    if jumps.size and float(np.max(np.abs(np.diff(trajectory["crank_angle"])))) < math.pi:
        cause = f"follower_angle jumps by a turn behind row {jumps[0]}, but the follower turns fully"
        raise EngineFailure(float(trajectory["time"][jumps[0]]), cause, "let it run on, near crank_angle: numpy.unwrap", trajectory)


def raised(error: BaseException) -> str:
    """What an engine raised and where, as a clause."""
    return f"the engine raised {type(error).__name__}{raised_at(error)}: {first_line(error)}"


def raised_at(error: BaseException) -> str:
    """The line of an engine that raised an exception, such as " at my_engine.py, line 12", even if numpy or scipy raised it; or ""."""
    frames = traceback.extract_tb(error.__traceback__)
    of_engine = [frame for frame in frames if not _BELOW & set(Path(frame.filename).parts)] or frames
    return f" at {Path(of_engine[-1].filename).name}, line {of_engine[-1].lineno}" if of_engine else ""


def check_trajectory(trajectory: Trajectory, duration: float, output_step: float) -> None:
    """Raise `EngineFailure` unless the trajectory is complete, on its grid and finite.

    The time grid may start anywhere; it must have `duration / output_step` steps of `output_step`.
    """
    lengths = {len(values) for values in trajectory.columns.values()}
    if len(lengths) != 1:
        raise EngineFailure(0.0, "the engine returned columns of different lengths", "report this to the author of the engine")
    finite = np.logical_and.reduce([np.isfinite(values) for values in trajectory.columns.values()])
    if not finite.all():
        bad = int(np.argmin(finite))
        name = next(name for name, values in trajectory.columns.items() if not np.isfinite(values[bad]))
        good = float(trajectory["time"][bad - 1]) if bad else 0.0
        head = {name: values[:bad] for name, values in trajectory.columns.items()}
        partial = replace(trajectory, columns=head) if bad else None
        raise EngineFailure(good, f"{name} is no longer a finite number", "try finer settings", partial)
    times, rows = trajectory["time"], round(duration / output_step) + 1
    # A grid built by repeated addition may drift by some rounding errors, never by a thousandth of a step.
    on_grid = np.allclose(np.diff(times), output_step, rtol=1e-3, atol=0.0)
    if len(times) != rows or not on_grid:
        raise EngineFailure(
            float(times[-1]) if len(times) else 0.0,
            f"the engine returned {len(times)} rows that are not the {rows} of the output grid{_wrong_unit_or_step(times, output_step)}",
            "try finer settings",
            trajectory if len(times) and on_grid else None,
        )


def _wrong_unit_or_step(times: Array, output_step: float) -> str:
    """A clause on the unit or the step of a time column; "" if neither is wrong."""
    step = float(np.median(np.diff(times))) if len(times) > 1 else output_step
    if math.isclose(step, 1e3 * output_step, rel_tol=1e-3):
        return "; the time column is in milliseconds, not in s"
    return "" if math.isclose(step, output_step, rel_tol=1e-3) else f"; its time steps are {step:.4g}, not {output_step:.4g} s"


#: What libraries say: MuJoCo, C++, the system, numpy, LLVM.
_NO_MEMORY: Final = re.compile(r"(?:could not|cannot|can't|unable to|failed to) allocate|bad[_ ]alloc|(?:out of|insufficient) memory", re.I)


def lacks_memory(error: BaseException) -> bool:
    """Whether an exception says that memory could not be had: a `MemoryError`, its consequence, or a library's own words for it."""
    each: BaseException | None = error
    while each is not None:
        if isinstance(each, MemoryError) or _NO_MEMORY.search(str(each)):
            return True
        each = each.__cause__ or each.__context__
    return False


def compile_seconds(engine: AnyEngine, scene: Scene, start: Start | None, output_step: float, settings: Settings) -> float:
    """Run one output step, after which all code is loaded; its wall time, s. What fails here fails again in the run itself."""
    progress.tell(engine=engine.name, phase=progress.COMPILING)
    began = time.perf_counter()
    with contextlib.suppress(EngineFailure), _no_garbage_collection():
        run_once(engine, scene, start, output_step, output_step, settings)
    return time.perf_counter() - began


@contextlib.contextmanager
def _no_garbage_collection() -> Iterator[None]:
    """Switches garbage collection off: it takes an eighth of the time of compiling, which makes millions of small objects."""
    was_on = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_on:
            gc.enable()


T = TypeVar("T")


def on_one_thread(function: Callable[..., T]) -> Callable[..., T]:
    """Decorator of a function whose first argument is an engine."""

    @wraps(function)
    def limited(engine: Any, *arguments: Any, **named: Any) -> T:
        if engine.name not in MAIN:  # scipy has a BLAS of its own, and the limit holds for what is loaded; the main engines use numpy's
            import scipy.linalg  # noqa: F401
        with threadpool_limits(limits=1, user_api="blas"):
            return function(engine, *arguments, **named)

    return limited


_QUOTED = 60  # characters of an engine's answer that a message quotes


@on_one_thread
def natural_frequencies(engine: AnyEngine, mechanism: Mechanism, crank_angle: float, count: int, settings: Settings) -> Array:
    """`Engine.natural_frequencies` in Hz, of shape (<= count,): finite, none negative, ascending.

    Raises:
        Refusal: as the engine raises it.
        EngineFailure: the engine returned something else; the cause says what.
    """
    answer: Any = engine.natural_frequencies(mechanism, crank_angle, count, settings)
    try:
        values = np.asarray(answer)
    except ValueError:  # lists of different lengths
        values = np.empty((0, 0))
    wrong = ""
    if values.ndim != 1 or (values.size and values.dtype.kind not in "iuf"):
        wrong = "that are no list of numbers"
    elif not np.isfinite(values).all():
        wrong = "that are not finite"
    elif (values < 0.0).any():
        wrong = "below zero"
    elif (np.diff(values.astype(np.float64)) < 0.0).any():
        wrong = "that do not ascend"
    if wrong:
        shown = " ".join(str(answer).split())
        cause = f"the engine returned natural frequencies {wrong}: {shown if len(shown) <= _QUOTED else f'{shown[:_QUOTED]}...'}"
        raise EngineFailure(0.0, cause, "report this to the author of the engine")
    return np.asarray(values, dtype=np.float64)[:count]
