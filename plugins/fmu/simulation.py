"""An FMU with what is declared of it, and its simulation by fmpy.

An FMU is loaded into this process, which it may end: jobs run in processes of their own.
"""

import contextlib
import math
import secrets
import sys
import time
import weakref
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np

from quickreturn.engines.base import EngineFailure, Simulation
from quickreturn.engines.trajectory import FollowerTrajectory, Trajectory
from quickreturn.reference_model.native import cache_folder

#: Relative difference up to which values are the same: the rounding of a unit.
SAME: Final = 1e-9
_ADVICE: Final = "try a smaller engine.step, or ask the author of the FMU"
_FATAL: Final = 4  # status in FMI 2 and 3 after which nothing of the instance may be called, not even what frees it
_LONGEST: Final = 200  # characters of an FMU's message that a sentence quotes

#: Paths of FMUs of which a process can hold one instance -> the simulation that holds it; others begin anew when they are continued.
_only: Final[weakref.WeakValueDictionary[str, "FmuSimulation"]] = weakref.WeakValueDictionary()


@dataclass(frozen=True)
class Variable:
    """A variable of an FMU: SI value = factor x value of the variable + offset."""

    name: str
    reference: int  # FMI's value reference
    kind: str  # its type as FMI calls it, as do the functions that get it: Real, Float64, Float32
    factor: float
    offset: float


@dataclass(frozen=True)
class Fmu:
    """An FMU, and what the file beside it declares; keys are those of a case file."""

    path: str  # of the FMU
    about: Any  # an `fmpy.model_description.ModelDescription` with co-simulation
    digest: str  # hash of the FMU
    fingerprint: str  # hash of the FMU and of the declarations
    method: str
    parameters: Mapping[str, tuple[Variable, ...]]  # by key, one for each number of its value
    fixed: Mapping[str, float | tuple[float, ...]]  # values that are built in, SI
    constants: Mapping[str, Any]  # values of the FMU's own parameters by their names
    outputs: Mapping[str, Variable]  # by column
    steps: tuple[float, ...]  # s, coarse to fine

    @property
    def fmi(self) -> str:
        """The first digit of its version of FMI."""
        return str(self.about.fmiVersion[0])


def steps_within(output_step: float, step: float) -> int:
    """Number of communication steps in an output step."""
    return max(1, math.ceil(output_step / step * (1.0 - SAME)))


class FmuSimulation(Simulation):
    """An instance of an FMU; `release` frees it.

    Args:
        fmu: the FMU with its declarations.
        values: its parameters by their names, in its units.
        step: largest communication step, s.
        length: of the follower, m, which the slider must not leave; infinite without a slider.

    Raises:
        OSError: the library cannot be loaded, or makes no instance: due to the machine, and so no result that is stored.
        EngineFailure: the FMU does not take the parameters, or cannot begin with them.
    """

    release: "weakref.finalize[Any, FmuSimulation]"

    def __init__(self, fmu: Fmu, values: Mapping[str, Any], step: float, length: float) -> None:
        began = time.perf_counter()
        self._fmu, self._values, self._step, self._length = fmu, values, step, length
        self.time, self._said = 0.0, list[str]()
        self._past: list[tuple[float, float, int]] = []  # stretches so far: where each begins, its output step, number of output steps
        self._begin()
        self.setup_seconds = time.perf_counter() - began

    def _begin(self) -> None:
        """Make an instance at time 0."""
        from fmpy.simulation import apply_start_values, instantiate_fmu

        said = self._said  # the instance must not hold the simulation, whose end frees it

        def hear(*call: Any) -> None:  # FMI 2 and 3 give the message last
            said[:] = [" ".join(call[-1].decode(errors="replace").split())[-_LONGEST:]]

        once = self._fmu.about.coSimulation.canBeInstantiatedOnlyOncePerProcess
        if once and (other := _only.get(self._fmu.path)) is not None:
            other.release()
        try:
            with contextlib.redirect_stdout(sys.stderr):  # where fmpy says that messages keep the marks of their numbers
                self._instance = instantiate_fmu(str(_folder(self._fmu)), self._fmu.about, "CoSimulation", logger=hear)
        except Exception as error:  # fmpy raises exceptions of several kinds, and plain ones
            raise OSError(self._failure(error).cause) from error
        self.release = weakref.finalize(self, _free, self._instance, self._fmu.fmi)
        self.release.atexit = False
        if once:
            _only[self._fmu.path] = self
        try:
            apply_start_values(self._instance, self._fmu.about, self._values)
            if self._fmu.fmi == "2":
                self._instance.setupExperiment(startTime=0.0)
            self._instance.enterInitializationMode()
            self._instance.exitInitializationMode()
        except Exception as error:
            raise self._failure(error) from error

    def advance(self, duration: float, output_step: float) -> Trajectory | FollowerTrajectory:
        """See `Simulation.advance`."""
        origin, count = self.time, round(duration / output_step)
        rows: list[list[float]] = []
        began = time.perf_counter()
        try:
            self._check_step(output_step / steps_within(output_step, self._step))
            if not self.release.alive:  # come to the present again, with another instance, by the same steps
                self._begin()
                for past_origin, past_step, past_count in self._past:
                    for k in range(past_count):
                        self._do_output_step(past_origin, past_step, k)
                began = time.perf_counter()
            rows.append(self._row(origin))
            for k in range(count):
                self._do_output_step(origin, output_step, k)
                rows.append(self._row(origin + (k + 1) * output_step))
        except Exception as error:
            failure = self._failure(error)
            failure.partial = self._table(rows, began) if rows else None
            raise failure from error
        self._past.append((origin, output_step, count))
        return self._table(rows, began)

    def _table(self, rows: list[list[float]], began: float) -> Trajectory | FollowerTrajectory:
        columns = dict(zip(("time", *self._fmu.outputs), np.array(rows).T.copy(), strict=True))
        kind = FollowerTrajectory if math.isinf(self._length) else Trajectory
        return kind(columns, time.perf_counter() - began)

    def _row(self, at: float) -> list[float]:
        """Time and columns now. EngineFailure: some are no numbers, or the slider is beyond the follower's end."""
        row = [at]
        for name, variable in self._fmu.outputs.items():
            [value] = getattr(self._instance, f"get{variable.kind}")([variable.reference])
            row.append(variable.factor * value + variable.offset)
            if not math.isfinite(value):
                raise EngineFailure(self.time, f"{variable.name} of the FMU is {value}", _ADVICE)
            if name == "slider_position" and row[-1] > self._length:
                raise EngineFailure(self.time, "the slider has left the follower's end", _ADVICE)
        self.time = at
        return row

    def _check_step(self, step: float) -> None:
        """EngineFailure: the FMU's description excludes a communication step (s)."""
        able, accepted = self._fmu.about.coSimulation, ""
        _, first, _ = self._past[0] if self._past else (0.0, step, 0)
        first /= steps_within(first, self._step)
        whole = float(able.fixedInternalStepSize or step)
        if not math.isclose(step, max(1, round(step / whole)) * whole, rel_tol=SAME):
            accepted = f"whole multiples of {whole:.6g} s"
        elif not able.canHandleVariableCommunicationStepSize and not math.isclose(step, first, rel_tol=SAME):
            accepted = f"steps as long as the first, {first:.6g} s"
        if accepted:
            cause = f"the FMU takes no step of {step:.6g} s, but {accepted}"
            raise EngineFailure(self.time, cause, "choose the output step and engine.step by what the FMU takes")

    def _do_output_step(self, origin: float, output_step: float, number: int) -> None:
        """Make the communication steps of an output step, counted from `origin` (s)."""
        within = steps_within(output_step, self._step)
        for i in range(within):
            at = origin + (number + i / within) * output_step
            _, ended, early, _ = self._instance.doStep(at, output_step / within) or (False, False, False, at)
            if ended or early:
                raise EngineFailure(self.time, "the FMU ended the simulation", _ADVICE)

    def _failure(self, error: Exception) -> EngineFailure:
        """What an exception says. An instance that is lost is left as it is: to free it may corrupt the memory of the process."""
        if isinstance(error, EngineFailure):
            return error
        if getattr(error, "status", None) == _FATAL:
            self.release.detach()
        last = f' (its last words: "{self._said[-1]}")' if self._said else ""
        return EngineFailure(self.time, f"in the FMU, {str(error).rstrip('.') or type(error).__name__}{last}", _ADVICE)


def _free(instance: Any, fmi: str) -> None:
    """Free an instance. Its library stays: some do not bear to be unloaded."""
    with contextlib.suppress(Exception):
        getattr(instance, f"fmi{fmi}FreeInstance")(instance.component)


def _folder(fmu: Fmu) -> Path:
    """The FMU's files, unpacked once beside compiled code."""
    folder = cache_folder.folder() / f"fmu-{fmu.digest}"
    if not folder.is_dir():
        from fmpy import extract

        temporary = folder.with_name(f"{folder.name}.{secrets.token_hex(4)}")
        extract(fmu.path, temporary)
        with contextlib.suppress(OSError):  # another process has made it meanwhile
            temporary.rename(folder)
    return folder
