"""Reports how far a run is, to one listener. Without a listener, `tell` does nothing."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any, Final

#: The phase in which machine code is compiled, or loaded from the disk.
COMPILING: Final = "compiling"


@dataclass(frozen=True)
class Progress:
    """What is being done."""

    engine: str = ""  # name, "" before it is known
    phase: str = ""  # a few words
    rung: int = 0  # number of the settings that are tried, from 1; 0: none
    cycle: int = 0  # number of the last simulated cycle, from 1; 0: none
    most: int = 0  # largest number of cycles; 0: unknown

    def __str__(self) -> str:
        phase = f"{self.phase} at rung {self.rung}" if self.rung else self.phase
        most = f" of at most {self.most}" if self.most else ""
        return ", ".join(part for part in (self.engine, phase, f"cycle {self.cycle}{most}" if self.cycle else "") if part)


_listener: Callable[[Progress], None] | None = None
_present = Progress()


def listen(listener: Callable[[Progress], None] | None) -> None:
    """Call `listener` at every change from now on; None: call nobody."""
    global _listener, _present
    _listener, _present = listener, Progress()


@contextmanager
def heard_by(listener: Callable[[Progress], None]) -> Iterator[None]:
    """Call `listener` at every change within the block, unless there is a listener already, such as that of a worker process."""
    if _listener is not None:
        yield
        return
    listen(listener)
    try:
        yield
    finally:
        listen(None)


def tell(**changes: Any) -> None:
    """Report the fields of a `Progress` that changed. The others stay, but a new phase clears rung and cycle."""
    global _present
    if _listener is None:
        return
    fresh = {"rung": 0, "cycle": 0, "most": 0} if "phase" in changes else {}
    _present = replace(_present, **(fresh | changes))
    _listener(_present)
