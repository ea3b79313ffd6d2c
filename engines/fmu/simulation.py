"""Runs an FMU by fmpy. It is loaded into this process, which it may end: jobs run in processes of their own."""

import contextlib
import ctypes
import math
import os
import secrets
import time
import weakref
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np

from quickreturn.engines.base import EngineFailure, Simulation
from quickreturn.engines.fmu.description import Fmu, Variable, steps_within
from quickreturn.engines.trajectory import FollowerTrajectory, Trajectory
from quickreturn.reference_model.native import cache_folder

_ADVICE: Final = "try a smaller engine.step, or ask the author of the FMU"
_TERMINATED: Final = 3  # FMI 2's question whether the FMU wants to end the simulation
_FATAL: Final = 4  # status in FMI 2 and 3 after which nothing of the instance may be called, not even what frees it
_LONGEST: Final = 200  # characters of an FMU's message that a sentence quotes

#: Paths of FMUs of which a process can hold one instance -> the simulation that holds it.
_only: Final[weakref.WeakValueDictionary[str, "FmuSimulation"]] = weakref.WeakValueDictionary()


class FmuSimulation(Simulation):
    """An instance of an FMU; `release` frees it.

    Args:
        fmu: the file.
        parameters: its parameters with their values in its units.
        outputs: column -> variable.
        step: largest communication step, s.
        length: of the follower, m, which the slider must not leave; infinite without a slider.
    """

    release: "weakref.finalize[Any, FmuSimulation]"

    def __init__(
        self, fmu: Fmu, parameters: Sequence[tuple[Variable, float]], outputs: Mapping[str, Variable], step: float, length: float
    ) -> None:
        began = time.perf_counter()
        self._fmu, self._outputs, self._step, self._length, self.time = fmu, outputs, step, length, 0.0
        self._said: list[str] = []
        if fmu.once and (other := _only.get(fmu.path)) is not None:
            other.release()
        try:
            self._instance = instance = _instance(fmu, self._said)
            self.release = weakref.finalize(self, _free, instance, fmu.fmi)
            self.release.atexit = False
            if fmu.once:
                _only[fmu.path] = self
            for variable, value in parameters:
                setter = getattr(instance, f"set{variable.kind}")
                setter([variable.reference], [round(value) if "Int" in variable.kind else value])
            if fmu.fmi == "2":
                instance.setupExperiment(startTime=0.0)
            instance.enterInitializationMode()
            instance.exitInitializationMode()
        except Exception as error:  # fmpy raises exceptions of several kinds, and plain ones
            raise EngineFailure(0.0, f"the FMU cannot begin: {self._words(error)}", "see what the FMU needs") from error
        self.setup_seconds = time.perf_counter() - began

    def advance(self, duration: float, output_step: float) -> Trajectory | FollowerTrajectory:
        """See `Simulation.advance`."""
        began, origin, count = time.perf_counter(), self.time, round(duration / output_step)
        within = steps_within(output_step, self._step)
        rows: list[dict[str, float]] = []
        try:
            rows.append(self._row(origin))
            for k in range(1, count + 1):
                for i in range(within):
                    self._do_step(origin + ((k - 1) + i / within) * output_step, output_step / within)
                rows.append(self._row(origin + k * output_step))
        except _Ended as end:
            table = self._table(rows, began) if rows else None
            raise EngineFailure(self.time, str(end), _ADVICE, table) from end
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

    def _do_step(self, at: float, step: float) -> None:
        """Make a communication step. _Ended: the FMU does not make it, or wants to end the simulation."""
        if not self.release.alive:
            raise _Ended("the FMU allows one instance in a process, and another simulation has begun since")
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
    """The motion ends: why, as a clause."""


def _instance(fmu: Fmu, said: list[str]) -> Any:
    """An instance of the FMU; the last line of what it says is kept in `said`."""
    from fmpy import fmi2, fmi3

    def hear(message: bytes) -> None:
        said[:] = [" ".join(message.decode(errors="replace").split())[-_LONGEST:]]

    kind = fmi2.FMU2Slave if fmu.fmi == "2" else fmi3.FMU3Slave
    instance = kind(guid=fmu.token, modelIdentifier=fmu.identifier, unzipDirectory=str(_folder(fmu)), instanceName=fmu.identifier)
    if fmu.fmi == "2":
        callbacks = fmi2.fmi2CallbackFunctions()
        callbacks.logger = fmi2.fmi2CallbackLoggerTYPE(lambda _, __, ___, ____, message: hear(message))
        callbacks.allocateMemory, callbacks.freeMemory = fmi2.defaultCallbacks.allocateMemory, fmi2.defaultCallbacks.freeMemory
        with contextlib.suppress(Exception):  # without it messages keep the marks of their numbers
            fmi2.addLoggerProxy(ctypes.byref(callbacks))
        instance.instantiate(callbacks=callbacks)
    else:
        instance.instantiate(logMessage=lambda _, __, ___, message: hear(message))
    return instance


def _free(instance: Any, fmi: str) -> None:
    """Free an instance. Its library stays: some do not bear to be unloaded."""
    with contextlib.suppress(Exception):
        getattr(instance, f"fmi{fmi}FreeInstance")(instance.component)


def _folder(fmu: Fmu) -> Path:
    """The FMU's files, unpacked once beside compiled code."""
    folder = Path(os.environ[cache_folder.VARIABLE]) / f"fmu-{fmu.fingerprint}"
    if not folder.is_dir():
        from fmpy import extract

        temporary = folder.with_name(f"{folder.name}.{secrets.token_hex(4)}")
        extract(fmu.path, temporary)
        with contextlib.suppress(OSError):  # another process has made it meanwhile
            temporary.rename(folder)
    return folder
