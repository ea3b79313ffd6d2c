"""Jobs in processes of their own, as tests of them need them."""

import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from quickreturn.cases.running import fork_server
from quickreturn.cases.running.isolation import isolated
from quickreturn.cases.running.job import Job, Limits, Outcome

PRELOAD = ("quickreturn.cases.running.worker",)

GIB = 2**30


def done(
    function: Callable[..., Any], *arguments: Any, limits: Limits | None = None, preload: Sequence[str] = fork_server.PRELOAD
) -> Outcome[Any]:
    return isolated(Job("job", function, arguments), limits, preload=preload)


def gone(process: int) -> bool:
    """Whether a process has ended, waiting up to ten seconds for that; a zombie that nobody has collected counts as ended."""
    for _ in range(500):
        try:
            state = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0]
        except (FileNotFoundError, ProcessLookupError):
            return True
        if state == "Z":
            return True
        time.sleep(0.02)
    return False
