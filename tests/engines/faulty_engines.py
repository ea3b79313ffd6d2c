"""Engines that do one thing wrong each, once the simulation runs, beside a sound one; their motion is that of the fake engine's kind.

The tip swings as the sine of the crank angle, so that every cycle is like the one before and the runner finds a steady state.

Workers inherit the environment of their fork server, which may be older than the test: what a test has to say to its engines it says
by the module `faults_place`, installed with them.
"""

import ctypes
import os
import signal
import time
from pathlib import Path
from typing import ClassVar, NoReturn

import numpy as np

from quickreturn.engines.base import ModelDescription
from quickreturn.engines.settings import Settings as AnySettings
from quickreturn.engines.start import Start
from quickreturn.engines.trajectory import Trajectory
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.mechanism import Mechanism
from tests.engines.fake_engine import FakeEngine, FakeSettings, FakeSimulation
from tests.engines.fake_package import install

#: File in the test's folder in which every simulation that is begun is noted.
DIARY = "diary"
#: File in the test's folder for which engine `waits` waits.
SIGNAL = "go on"


def install_faulty_engines(folder: Path) -> None:
    """Install them as a third-party package in `folder`/packages; diary and signal are in `folder`."""
    install(folder / "packages", "faults", {"faults_place": f"FOLDER = {str(folder)!r}\n"}, ENTRIES)


def _place() -> Path:
    from faults_place import FOLDER

    return Path(FOLDER)


class Sound(FakeEngine):
    """Does nothing wrong."""

    name = "sound"

    def prepare(self, mechanism: Mechanism, start: Start, settings: AnySettings) -> "Swing":
        assert isinstance(settings, FakeSettings)
        with open(_place() / DIARY, "a", encoding="ascii") as diary:
            diary.write(f"{self.name}\n")
        return Swing(start, settings, self)

    def error(self, step: float) -> float:
        """Relative error of deflection and strain; `comparisons` counts on the second order in the step."""
        return 0.01 * step**2

    def spoil(self, trajectory: Trajectory) -> None:
        """What goes wrong: nothing here."""


class Swing(FakeSimulation):
    def __init__(self, start: Start, settings: FakeSettings, engine: Sound) -> None:
        super().__init__(start, settings)
        self._engine = engine

    def _motion(self, times: Array) -> Trajectory:
        trajectory = super()._motion(times)
        trajectory.columns["crank_speed"] = np.full_like(times, self._start.crank_speed)
        trajectory.columns["tip_deflection"] = np.sin(trajectory["crank_angle"]) * (1.0 + self._engine.error(self._settings.step))
        trajectory.columns["strain_1"] = 0.001 * trajectory["tip_deflection"]
        self._engine.spoil(trajectory)
        return trajectory


class AlsoSound(Sound):
    name = "also-sound"


class Carries(Sound):
    """Models a slider with mass, which the others refuse."""

    name = "carries"

    def check(self, mechanism: Mechanism) -> None:
        """Accept everything."""


class Coarse(Sound):
    """2 % off, and says so."""

    name = "coarse"
    default_accuracy = 5e-2

    def error(self, step: float) -> float:
        return 0.5 * step**2


class Overclaims(Sound):
    """5 % off, which no step cures and no comparison of steps shows."""

    name = "overclaims"

    def error(self, step: float) -> float:
        return 0.05 + 0.01 * step**2


class OfItsOwnEquations(Overclaims):
    """The same, but what it estimates is the error of its integration."""

    name = "own-equations"
    estimates = "integration"


class Waits(Sound):
    """Goes on when it is told to."""

    name = "waits"

    def spoil(self, trajectory: Trajectory) -> None:
        while not (_place() / SIGNAL).exists():
            time.sleep(0.02)


class Raises(Sound):
    name = "raises"

    def spoil(self, trajectory: Trajectory) -> None:
        raise ZeroDivisionError("a bug\non two lines")


class ReturnsNan(Sound):
    name = "returns-nan"

    def spoil(self, trajectory: Trajectory) -> None:
        trajectory.columns["strain_2"][5:] = np.nan


class Hangs(Sound):
    """Sleeps with the interpreter's lock held, as a native solver does that never ends."""

    name = "hangs"

    def spoil(self, trajectory: Trajectory) -> None:
        ctypes.PyDLL(None).sleep(3600)


class Hoards(Sound):
    """Asks for memory without end, in pieces."""

    name = "hoards"
    _hoard: ClassVar[list[bytearray]] = []

    def spoil(self, trajectory: Trajectory) -> NoReturn:
        while True:
            self._hoard.append(bytearray(1 << 26))


class HoardsInC(Sound):
    """The same where a library takes it for granted that memory is there."""

    name = "hoards-in-c"

    def spoil(self, trajectory: Trajectory) -> None:
        library = ctypes.CDLL(None)
        library.malloc.restype, library.malloc.argtypes = ctypes.c_void_p, [ctypes.c_size_t]
        while library.malloc(1 << 26):
            pass
        os.write(2, b"fatal error: cannot allocate memory\n")
        os.abort()


class Segfaults(Sound):
    name = "segfaults"

    def spoil(self, trajectory: Trajectory) -> None:
        ctypes.string_at(0)


class IsKilled(Sound):
    name = "is-killed"

    def spoil(self, trajectory: Trajectory) -> None:
        os.kill(os.getpid(), signal.SIGKILL)


class Quits(Sound):
    name = "quits"

    def spoil(self, trajectory: Trajectory) -> None:
        os._exit(0)


class CutsTheLine(Sound):
    """Closes all files, those of others too, and carries on."""

    name = "cuts-the-line"

    def spoil(self, trajectory: Trajectory) -> None:
        os.closerange(0, 256)
        time.sleep(3600.0)


class FillsTheDisk(Sound):
    name = "fills-the-disk"

    def spoil(self, trajectory: Trajectory) -> None:
        Path("/dev/full").write_bytes(b"results of its own")


class SaysNonsense(Sound):
    """What it says about itself is no number."""

    name = "says-nonsense"

    def describe(self, mechanism: Mechanism, settings: AnySettings) -> ModelDescription:
        return ModelDescription((), (), float("nan"))  # type: ignore[arg-type]


ENGINES = (
    *(
        Sound,
        AlsoSound,
        Carries,
        Coarse,
        Overclaims,
        OfItsOwnEquations,
        Waits,
        Raises,
        ReturnsNan,
        Hangs,
        Hoards,
        HoardsInC,
        Segfaults,
        IsKilled,
        Quits,
        CutsTheLine,
        FillsTheDisk,
    ),
    SaysNonsense,
)
#: Entry points by name; the last one's library is not installed.
ENTRIES = {kind.name: f"{__name__}:{kind.__name__}" for kind in ENGINES} | {"not-installed": "no_such_library.engine:Engine"}
