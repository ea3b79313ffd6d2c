"""How far a run is, told to whoever listens. A worker listens for the person who waits; else nobody does, and telling costs nothing."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any


@dataclass(frozen=True)
class Progress:
    """What is being done.

    Attributes:
        engine: name, "" before it is known.
        phase: a few words.
        rung: which settings of the engine's ladder are tried, from 1; 0: none.
        cycle: which cycle has been simulated, from 1; 0: none.
    """

    engine: str = ""
    phase: str = ""
    rung: int = 0
    cycle: int = 0

    def __str__(self) -> str:
        numbers = [f"{name} {number}" for name, number in (("rung", self.rung), ("cycle", self.cycle)) if number]
        return ", ".join(part for part in (self.engine, self.phase, *numbers) if part)


_listener: Callable[[Progress], None] | None = None
_present = Progress()


def listen(listener: Callable[[Progress], None] | None) -> None:
    """Have `listener` told from now on; None: nobody."""
    global _listener, _present
    _listener, _present = listener, Progress()


def tell(**changes: Any) -> None:
    """What of a `Progress` has changed; what is not given stays, but a new phase begins without rung and cycle."""
    global _present
    if _listener is None:
        return
    fresh = {"rung": 0, "cycle": 0} if "phase" in changes else {}
    _present = replace(_present, **(fresh | changes))
    _listener(_present)
