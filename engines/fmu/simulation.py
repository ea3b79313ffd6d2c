"""Runs an FMU by fmpy. It is loaded into this process, which it may end: jobs run in processes of their own."""

import contextlib
import math
import os
import secrets
import sys
import time
import weakref
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np

from quickreturn.engines.base import EngineFailure, Simulation
from quickreturn.engines.fmu.description import SAME, Fmu, Variable, steps_within
from quickreturn.engines.trajectory import FollowerTrajectory, Trajectory
from quickreturn.reference_model.native import cache_folder

_ADVICE: Final = "try a smaller engine.step, or ask the author of the FMU"
_OTHER_STEPS: Final = "choose the output step and engine.step by what the FMU takes"
_TERMINATED: Final = 3  # FMI 2's question whether the FMU wants to end the simulation
_FATAL: Final = 4  # status in FMI 2 and 3 after which nothing of the instance may be called, not even what frees it
_LONGEST: Final = 200  # characters of an FMU's message that a sentence quotes

#: Paths of FMUs of which a process can hold one instance -> the simulation that holds it; others begin anew when they are continued.
_only: Final[weakref.WeakValueDictionary[str, "FmuSimulation"]] = weakref.WeakValueDictionary()


class FmuSimulation(Simulation):
    """An instance of an FMU; `release` frees it.

    Args:
        fmu: the file.
        parameters: its parameters with their values, as it takes them.
        outputs: column -> variable.
        step: largest communication step, s.
        length: of the follower, m, which the slider must not leave; infinite without a slider.
    """

    release: "weakref.finalize[Any, FmuSimulation]"

    def __init__(
        self, fmu: Fmu, parameters: Sequence[tuple[Variable, Any]], outputs: Mapping[str, Variable], step: float, length: float
    ) -> None:
        began = time.perf_counter()
        self._fmu, self._parameters, self._outputs, self._step, self._length = fmu, parameters, outputs, step, length
        self.time, self._said = 0.0, list[str]()
        self._past: list[tuple[float, float, int]] = []  # stretches so far: where each begins, its output step, number of output steps
        self._begin()
        self.setup_seconds = time.perf_counter() - began

    def _begin(self) -> None:
        """Make an instance at time 0.

        Raises:
            OSError: the library cannot be loaded, or makes none: due to the machine, and so no result that is stored.
            EngineFailure: the FMU does not take the parameters, or cannot begin with them.
        """
        once = self._fmu.about.coSimulation.canBeInstantiatedOnlyOncePerProcess
        if once and (other := _only.get(self._fmu.path)) is not None:
            other.release()
        try:
            self._instance = instance = _instance(self._fmu, self._said)
        except Exception as error:  # fmpy raises exceptions of several kinds, and plain ones
            raise OSError(f"the FMU cannot begin: {self._words(error)}") from error
        try:
            self.release = weakref.finalize(self, _free, instance, self._fmu.fmi)
            self.release.atexit = False
            if once:
                _only[self._fmu.path] = self
            for variable, value in self._parameters:
                getattr(instance, f"set{variable.kind}")([variable.reference], [value])
            if self._fmu.fmi == "2":
                instance.setupExperiment(startTime=0.0)
            instance.enterInitializationMode()
            instance.exitInitializationMode()
        except Exception as error:  # fmpy raises exceptions of several kinds, and plain ones
            raise EngineFailure(0.0, f"the FMU cannot begin: {self._words(error)}", "see what the FMU needs") from error

    def _continue(self) -> None:
        """Come to the present again, with another instance, by the same steps. EngineFailure, _Ended: the FMU fails this time."""
        self._begin()
        for origin, output_step, count in self._past:
            for k in range(count):
                self._do_output_step(origin, output_step, k)

    def advance(self, duration: float, output_step: float) -> Trajectory | FollowerTrajectory:
        """See `Simulation.advance`."""
        origin, count = self.time, round(duration / output_step)
        rows: list[dict[str, float]] = []
        began = time.perf_counter()
        try:
            if not self.release.alive:
                self._continue()
                began = time.perf_counter()
            rows.append(self._row(origin))
            for k in range(count):
                self._do_output_step(origin, output_step, k)
                rows.append(self._row(origin + (k + 1) * output_step))
        except _Ended as end:
            table = self._table(rows, began) if rows else None
            raise EngineFailure(self.time, end.cause, end.advice, table) from end
        self._past.append((origin, output_step, count))
        return self._table(rows, began)

    def _table(self, rows: Sequence[Mapping[str, float]], began: float) -> Trajectory | FollowerTrajectory:
        columns = {name: np.array([row[name] for row in rows]) for name in rows[0]}
        kind = FollowerTrajectory if math.isinf(self._length) else Trajectory
        return kind(columns, time.perf_counter() - began)

    def _row(self, at: float) -> dict[str, float]:
        """The columns now. _Ended: they cannot be read, are no numbers, or the slider is beyond the follower's end."""
        row = {"time": at}
        for name, variable in self._outputs.items():
            try:
                [value] = getattr(self._instance, f"get{variable.kind}")([variable.reference])
            except Exception as error:
                raise _Ended(f"{variable.name} cannot be read from the FMU: {self._words(error)}") from error
            row[name] = variable.factor * value + variable.offset
            if not math.isfinite(row[name]):
                raise _Ended(f"{variable.name} of the FMU is {value}")
        if row.get("slider_position", 0.0) > self._length:
            raise _Ended("the slider has left the follower's end")
        self.time = at
        return row

    def _do_output_step(self, origin: float, output_step: float, number: int) -> None:
        """Make the communication steps of an output step, counted from `origin` (s). _Ended: see `_do_step`."""
        within, able = steps_within(output_step, self._step), self._fmu.about.coSimulation
        step, whole = output_step / within, float(able.fixedInternalStepSize or 0.0)
        if whole and not math.isclose(step, max(1, round(step / whole)) * whole, rel_tol=SAME):
            raise _Ended(f"the FMU takes no step of {step:.6g} s, but whole multiples of {whole:.6g} s", _OTHER_STEPS)
        _, first, _ = self._past[0] if self._past else (0.0, output_step, 0)
        first /= steps_within(first, self._step)
        if not able.canHandleVariableCommunicationStepSize and not math.isclose(step, first, rel_tol=SAME):
            raise _Ended(f"the FMU takes no step of {step:.6g} s: all must be as long as the first, {first:.6g} s", _OTHER_STEPS)
        for i in range(within):
            self._do_step(origin + (number + i / within) * output_step, step)

    def _do_step(self, at: float, step: float) -> None:
        """Make a communication step. _Ended: the FMU does not make it, or wants to end the simulation."""
        try:
            _, ended, early, _ = self._instance.doStep(at, step) or (False, False, False, 0.0)
        except Exception as error:
            ended, early = self._wants_to_end(error), False
            if not ended:
                raise _Ended(f"a step from {at:.6g} s failed in the FMU: {self._words(error)}") from error
        if ended or early:
            raise _Ended(f"the FMU ended the simulation in the step from {at:.6g} s{self._last_words()}")

    def _wants_to_end(self, error: Exception) -> bool:
        if self._fmu.fmi == "2" and getattr(error, "status", None) != _FATAL:
            with contextlib.suppress(Exception):
                return bool(self._instance.getBooleanStatus(_TERMINATED))
        return False

    def _words(self, error: Exception) -> str:
        """What failed, as a clause. An instance that is lost is left as it is: to free it may corrupt the memory of the process."""
        if getattr(error, "status", None) == _FATAL:
            self.release.detach()
        return f"{str(error).rstrip('.') or type(error).__name__}{self._last_words()}"

    def _last_words(self) -> str:
        return f' (its last words: "{self._said[-1]}")' if self._said else ""


class _Ended(Exception):
    """The motion ends: why, and what to try, as clauses."""

    def __init__(self, cause: str, advice: str = _ADVICE) -> None:
        super().__init__(cause)
        self.cause, self.advice = cause, advice


def _instance(fmu: Fmu, said: list[str]) -> Any:
    """An instance of the FMU; the last line of what it says is kept in `said`."""
    from fmpy.simulation import instantiate_fmu

    def hear(*call: Any) -> None:  # FMI 2 and 3 give the message last
        said[:] = [" ".join(call[-1].decode(errors="replace").split())[-_LONGEST:]]

    with contextlib.redirect_stdout(sys.stderr):  # where fmpy says that messages keep the marks of their numbers
        return instantiate_fmu(str(_folder(fmu)), fmu.about, "CoSimulation", logger=hear)


def _free(instance: Any, fmi: str) -> None:
    """Free an instance. Its library stays: some do not bear to be unloaded."""
    with contextlib.suppress(Exception):
        getattr(instance, f"fmi{fmi}FreeInstance")(instance.component)


def _folder(fmu: Fmu) -> Path:
    """The FMU's files, unpacked once beside compiled code."""
    folder = Path(os.environ[cache_folder.VARIABLE]) / f"fmu-{fmu.digest}"
    if not folder.is_dir():
        from fmpy import extract

        temporary = folder.with_name(f"{folder.name}.{secrets.token_hex(4)}")
        extract(fmu.path, temporary)
        with contextlib.suppress(OSError):  # another process has made it meanwhile
            temporary.rename(folder)
    return folder
