"""A job whose runner, or whose fork server, dies or is interrupted."""

import operator
import os
import signal
import subprocess
import sys
import textwrap
import threading
import time
from collections.abc import Iterator
from multiprocessing import forkserver
from pathlib import Path
from typing import Any

import pytest

from quickreturn.cases.running import fork_server
from quickreturn.cases.running.isolation import LocalProcesses, end_waiting
from quickreturn.cases.running.job import Job, Limits, Outcome
from tests.cases.running.jobs import done, gone

PRELOAD = ("quickreturn.cases.running.worker",)  # servers that die soon need nothing slow


@pytest.fixture(scope="module", autouse=True)
def a_warm_server_left_behind() -> Iterator[None]:
    """The tests after these get a fork server that has imported what their jobs need; otherwise each job would import it."""
    yield
    end_waiting()
    forkserver._forkserver._stop()  # type: ignore[attr-defined]
    done(len, (), preload=fork_server.PRELOAD)


def test_folders_where_the_user_stands_are_not_taken_for_packages(tmp_path: Path) -> None:
    (tmp_path / "quickreturn").mkdir()
    (tmp_path / "quickreturn/__init__.py").write_text("raise SystemError('a folder where the user stands')")
    (tmp_path / "elsewhere").mkdir()
    script = tmp_path / "elsewhere/runner.py"
    script.write_text(
        textwrap.dedent(
            f"""
            import pkgutil
            from quickreturn.cases.running.job import Job
            from quickreturn.cases.running.isolation import LocalProcesses
            if __name__ == "__main__":
                job = Job("job", pkgutil.resolve_name, ("quickreturn.cases.library.thesis:run_name",))
                (outcome,) = LocalProcesses(preload={PRELOAD!r}).run([job])
                print(outcome.failure or outcome.value(24))
            """
        )
    )
    told = subprocess.run([sys.executable, str(script)], cwd=tmp_path, capture_output=True, text=True, check=True)
    assert told.stdout == "thesis-24\n", told.stderr


def sleeper(folder: Path) -> Job[Any]:
    """A job that writes its process id to the file `pid` in the folder and then sleeps with the GIL held, as a native solver does."""
    file = str(folder / "pid")
    write = f"open({file + '.part'!r}, 'w').write(str(os.getpid())); os.rename({file + '.part'!r}, {file!r})"
    code = f"import ctypes, os; {write}; ctypes.PyDLL(None).sleep(3600)"
    return Job("sleeper", exec, (code,))


def test_killed_fork_server_costs_nothing(tmp_path: Path) -> None:
    """The worker that it leaves behind delivers, and the next job gets a new server."""
    begun, go = tmp_path / "begun", tmp_path / "go"
    wait = f"import os, time\nopen({str(begun)!r}, 'w')\nwhile not os.path.exists({str(go)!r}): time.sleep(0.02)\nprint('done')"
    jobs = [Job("tells its parent", os.getppid), Job("waits", exec, (wait,)), Job("next", operator.add, (2, 3))]
    outcomes: list[Outcome[Any]] = []

    def kill_the_server() -> None:
        while not begun.exists():
            time.sleep(0.02)
        os.kill(outcomes[0].value, signal.SIGKILL)
        go.touch()

    for outcome in LocalProcesses(1, preload=PRELOAD).run(jobs):
        outcomes.append(outcome)
        if outcome.job.name == "tells its parent":
            threading.Thread(target=kill_the_server).start()
    assert [(outcome.job.name, outcome.failure) for outcome in outcomes[1:]] == [("waits", ""), ("next", "")]
    assert outcomes[1].output == "done"
    assert outcomes[2].value == 5
    assert done(os.getppid, preload=PRELOAD).value != outcomes[0].value


def test_worker_without_its_fork_server_is_limited_too() -> None:
    code = "import os, signal, time; os.kill(os.getppid(), signal.SIGKILL); time.sleep(3600)"
    assert done(exec, code, limits=Limits(seconds=0.3), preload=PRELOAD).failure == "stopped at the time limit of 0.3 s"
    code = "import os, signal, time; os.kill(os.getppid(), signal.SIGKILL); time.sleep(0.2); os.abort()"
    assert done(exec, code, preload=PRELOAD).failure == "ended without a result"


def test_closing_the_iterator_kills_the_workers(tmp_path: Path) -> None:
    def wait_for_the_sleeper() -> str:
        return f"import os, time\nwhile not os.path.exists({str(tmp_path / 'pid')!r}): time.sleep(0.02)"

    outcomes = LocalProcesses(2, preload=PRELOAD).run([sleeper(tmp_path), Job("waits", exec, (wait_for_the_sleeper(),))])
    assert next(outcomes).job.name == "waits"
    outcomes.close()
    assert gone(int((tmp_path / "pid").read_text()))
