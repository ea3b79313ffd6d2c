"""Compiles an engine's machine code, or loads it from the disk, before anything is timed."""

import contextlib
import gc
import time
from collections.abc import Iterator

from quickreturn.engines import progress
from quickreturn.engines.base import AnyEngine, EngineFailure
from quickreturn.engines.one_run import run_once
from quickreturn.engines.settings import Settings
from quickreturn.engines.start import Start
from quickreturn.reference_model.mechanism import Scene


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
