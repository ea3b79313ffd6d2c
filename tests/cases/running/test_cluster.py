"""Jobs on a cluster of two workers on this machine: a process that can be killed, and a thread of the test's own process.

The work is done by functions of the standard library, so that every worker can import them.
"""

import contextlib
import os
import re
import signal
import subprocess
import sys
import textwrap
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

import quickreturn as qr
from quickreturn.cases.running import cluster as module
from quickreturn.cases.running.cluster import Cluster, cluster
from quickreturn.cases.running.isolation import LocalProcesses
from quickreturn.cases.running.job import ExecutorError, Job, Limits
from quickreturn.cases.running.store import Store
from quickreturn.cases.running.workshop import Workshop
from quickreturn.reference_model.errors import EngineTrouble, ToldError
from tests.cases.running.jobs import gone
from tests.package_copy import copied_package

if TYPE_CHECKING:
    from distributed import LocalCluster

ROOT = Path(__file__).resolve().parents[3]
#: How long anything here may take on a busy machine, s.
LONG = 60.0


def here(workers: int) -> "LocalCluster":
    """A scheduler in this process, with workers that are threads of it."""
    from distributed import LocalCluster  # takes half a second, which every process of the tests would spend at the head of the file

    return LocalCluster(
        n_workers=workers,
        threads_per_worker=1,
        processes=False,
        protocol="tcp",
        host="127.0.0.1",
        dashboard_address="127.0.0.1:0",
        worker_dashboard_address=None,
    )


def started(address: str, folder: Path = ROOT, may: str = "False", nanny: bool = True) -> "subprocess.Popen[bytes]":
    """A worker in a process of its own, with the code that is in the folder; a nanny starts another one when it dies."""
    command = [sys.executable, "-m", "dask", "worker", address, "--nthreads", "1", "--no-dashboard", "--nanny" if nanny else "--no-nanny"]
    environment = {**os.environ, "DASK_DISTRIBUTED__WORKER__DAEMON": may}
    return subprocess.Popen(command, cwd=folder, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


@contextlib.contextmanager
def ended(process: "subprocess.Popen[bytes]") -> Iterator["subprocess.Popen[bytes]"]:
    """The process, which is ended afterwards."""
    try:
        yield process
    finally:
        process.terminate()
        process.wait(LONG)


@pytest.fixture(scope="module")
def scheduler() -> "Iterator[LocalCluster]":
    with here(1) as scheduler:
        yield scheduler


def until(condition: Any) -> None:
    end = time.monotonic() + LONG
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.05)


def sleeper(folder: Path) -> str:
    """Code that writes its process id to the file `pid` in the folder and then sleeps."""
    mark = str(folder / "pid")
    write = f"open({mark + '.part'!r}, 'w').write(str(os.getpid())); os.rename({mark + '.part'!r}, {mark!r})"
    return f"import os, time; {write}; time.sleep(3600)"


@pytest.fixture
def executor(scheduler: "LocalCluster") -> Iterator[Cluster]:
    with cluster(scheduler.scheduler_address, Limits(seconds=LONG, memory=2**30)) as executor:
        yield executor


def test_what_a_job_does_to_itself_is_named_and_costs_that_job(executor: Cluster) -> None:
    jobs = [Job("good", eval, ("6 * 7",)), Job("dies", os.abort), Job("greedy", eval, ("len(bytearray(2 ** 31))",))]
    jobs += [Job("hangs", time.sleep, (3600.0,), limits=Limits(seconds=0.3)), Job("says", print, ("hello",))]
    outcomes = {outcome.job.name: outcome for outcome in executor.run(jobs)}
    assert {name: outcome.failure for name, outcome in outcomes.items()} == {
        "good": "",
        "dies": "killed by SIGABRT",
        "greedy": "ran out of memory (memory limit of 1 GiB)",
        "hangs": "stopped at the time limit of 0.3 s",
        "says": "",
    }
    assert (outcomes["good"].value, outcomes["says"].output) == (42, "hello")
    assert all(outcomes[job.name].job is job for job in jobs)


def test_what_is_not_wanted_any_more_ends_on_its_worker(executor: Cluster, tmp_path: Path) -> None:
    mark = tmp_path / "pid"
    outcomes = executor.run([Job("first", len, ((),)), Job("sleeper", exec, (sleeper(tmp_path),))])
    assert next(outcomes).job.name == "first"
    until(mark.exists)
    outcomes.close()
    until(lambda: gone(int(mark.read_text())))


@pytest.mark.parametrize(
    ("address", "reason"),
    [
        ("tcp://127.0.0.1:9", "Timed out trying to connect to tcp://127.0.0.1:9 after 0.2 s"),
        ("carrier-pigeon", "missing port number in address 'carrier-pigeon'"),
        ("", "missing port number in address ''"),
    ],
)
def test_a_bad_address_is_bad_input(address: str, reason: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "PATIENCE", 0.2)
    with pytest.raises(ExecutorError) as raised:
        cluster(address)
    assert str(raised.value) == f"cluster {address}: no scheduler answers there ({reason}); start one with `dask scheduler`"
    assert isinstance(raised.value, ToldError)  # which a command answers with exit code 2, unless it is the engine's trouble
    assert not isinstance(raised.value, EngineTrouble)


def test_a_scheduler_without_workers_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "PATIENCE", 1.0)
    with here(0) as empty, pytest.raises(ExecutorError, match=r"it has no worker; start one with `dask worker tcp://127.0.0.1:\d+`$"):
        cluster(empty.scheduler_address)


def test_a_job_is_refused_by_a_worker_with_other_code_than_the_machine_that_asks(
    executor: Cluster, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "_on_worker", _of_other_code)
    with pytest.raises(ExecutorError, match=r"^worker tcp://127.0.0.1:\d+ has other code or libraries than the machine that asks for job$"):
        list(executor.run([Job("job", len, ((),))]))


@pytest.mark.verify
def test_a_study_is_the_same_bit_for_bit_where_a_worker_is_killed_in_the_middle(tmp_path: Path) -> None:
    grid = {"tip.mass": "0 g; 20 g; 40 g; 60 g; 80 g; 100 g", "crank.prescribed_speed": "100 rpm .. 200 rpm : 5"}
    stores = {name: Store(tmp_path / name) for name in ("there", "here")}

    def results(name: str) -> dict[str, bytes]:
        return {file.name: file.read_bytes() for file in stores[name].folder.glob("*.result")}

    def kill() -> None:
        until(lambda: results("there"))
        worker.kill()

    with (
        here(0) as scheduler,
        ended(started(scheduler.scheduler_address, nanny=False)) as worker,
        ended(started(scheduler.scheduler_address)),
        cluster(scheduler.scheduler_address) as executor,
    ):
        until(lambda: len(executor._client.nthreads()) == 2)
        killer = threading.Thread(target=kill)
        killer.start()
        there = qr.sweep("thesis-24", grid, workshop=Workshop(stores["there"], executor), quiet=True)
        killer.join()
    local = qr.sweep("thesis-24", grid, workshop=Workshop(stores["here"], LocalProcesses(2)), quiet=True)
    assert set(np.unique(there["status"])) == {"settled"}
    assert there.equals(local)
    assert len(results("there")) == 6
    assert results("there") == results("here")


@pytest.mark.verify
def test_a_worker_with_other_code_is_refused(tmp_path: Path) -> None:
    package = copied_package(tmp_path, "reference_model", "engines", "cases")
    with (package / "engines/base.py").open("a") as file:
        file.write("# one line more\n")
    assert re.fullmatch(
        r"has code of quickreturn [0-9a-f]{12}, this machine [0-9a-f]{12}; both must have the same", refusal(folder=tmp_path)
    )


def refusal(**worker: Any) -> str:
    """Why a cluster with this worker is refused."""
    with (
        here(0) as scheduler,
        ended(started(scheduler.scheduler_address, **worker)),
        pytest.raises(ExecutorError, match=r"^cluster tcp://\S+: worker tcp://\S+ ") as raised,
    ):
        cluster(scheduler.scheduler_address)
    return str(raised.value).split(maxsplit=4)[4]


@pytest.mark.verify
@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGKILL, -9)])
def test_who_asked_and_is_gone_leaves_nothing_at_work(scheduler: "LocalCluster", number: int, code: int, tmp_path: Path) -> None:
    mark, script = tmp_path / "pid", tmp_path / "asks.py"
    script.write_text(
        textwrap.dedent(
            f"""
            import sys
            from quickreturn.cases.running.cluster import cluster
            from quickreturn.cases.running.job import Job
            with cluster({scheduler.scheduler_address!r}) as executor:
                try:
                    list(executor.run([Job("sleeper", exec, ({sleeper(tmp_path)!r},))]))
                except KeyboardInterrupt:
                    sys.exit(130)
            """
        )
    )
    asks = subprocess.Popen([sys.executable, script], stderr=subprocess.PIPE)
    until(mark.exists)
    asks.send_signal(number)
    assert asks.communicate(timeout=LONG) == (None, b"")
    assert asks.returncode == code
    until(lambda: gone(int(mark.read_text())))


def _of_other_code(job: Job[Any], key: str, limits: Limits, on_worker: Any = module._on_worker) -> Any:
    return on_worker(job, f"other than {key}", limits)
