"""Display of progress on standard error: jobs at work, their progress, finished jobs, and the remaining time.

A terminal shows it in one line that changes; a pipe or a file gets a line every few seconds and one for each result.
"""

import contextlib
import functools
import shutil
import sys
import threading
import time
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import closing
from typing import Any, Final

from quickreturn.cases.running.job import Executor, Job, Outcome, T
from quickreturn.engines import progress as progress_of_engines
from quickreturn.engines.progress import Progress
from quickreturn.reference_model.native import cache_folder
from quickreturn.reference_model.native.cache_folder import waits_for


class Tally:
    """Number of finished jobs, jobs at work, and the remaining time."""

    def __init__(self, jobs: Sequence[Job[Any]]) -> None:
        self.total, self.done = sum(job.points for job in jobs), 0
        self._began, self._rows = time.monotonic(), any(job.points > 1 for job in jobs)
        self._at_work: dict[int, tuple[Job[Any], Progress | None]] = {}
        self._lock = threading.Lock()

    def watch(self, job: Job[Any], progress: Progress | None) -> None:
        """Note the progress of a job; None: it has begun."""
        with self._lock:
            self._at_work[id(job)] = job, progress

    def ended(self, outcome: Outcome[Any]) -> None:
        """Note that a job has ended, successfully or not."""
        with self._lock:
            self._at_work.pop(id(outcome.job), None)
            self.done += outcome.job.points

    @property
    def elapsed(self) -> float:
        """Time since the beginning, s."""
        return time.monotonic() - self._began

    def at_work(self) -> list[str]:
        """A line for each job that is being computed."""
        with self._lock:
            return [_line(job, progress) for job, progress in self._at_work.values()]

    def __str__(self) -> str:
        """The numbers, and the remaining time if the others take as long as those that have ended."""
        left = self.elapsed * (self.total - self.done) / self.done if self.done else 0.0
        ahead = f", about {span(left)} left" if left >= 0.5 else ""
        rate = f", {self.done / self.elapsed:.3g} a second" if self._rows and self.done else ""
        return f"{self.done} of {self.total} done{rate}{ahead}"


#: Time until the first line of progress, and between lines in a pipe and in a terminal, s.
FIRST_LINE_AFTER: Final = 0.3
LINE_INTERVAL: Final = 5.0
CHANGES_AFTER: Final = 0.5
#: What returns a terminal to the beginning of its line, and clears it.
_ANEW: Final = "\r\x1b[2K"
#: Processor time, s, after which a message says that code is being compiled: loading compiled code takes one second, compilation 15 to 40.
COMPILING_AFTER: Final = 2.0
#: Interval of the checks of this time, s.
LOOK_INTERVAL: Final = 0.2
#: Largest number of jobs that a line names.
_MOST_AT_WORK: Final = 4


def watched(executor: Executor, jobs: Sequence[Job[T]], title: str) -> Generator[Outcome[T], None, None]:
    """Outcomes as they come; progress is shown meanwhile unless the executor is quiet. Raises as `Executor.run`."""
    if executor.quiet or not jobs:
        yield from executor.run(jobs)
        return
    _say_what_is_forgotten()
    tally = Tally(jobs)
    with _shown(tally, title) as done, closing(executor.run(jobs, tally.watch)) as running:
        for outcome in running:
            tally.ended(outcome)
            done(outcome)
            yield outcome


def answers(executor: Executor, jobs: Sequence[Job[T]], title: str) -> list[Outcome[T]]:
    """The outcome of each job, in their order; these results are not stored. Raises as `Executor.run`."""
    with closing(watched(executor, jobs, title)) as computed:
        by_job = {id(outcome.job): outcome for outcome in computed}
    return [by_job[id(job)] for job in jobs]


@contextlib.contextmanager
def _shown(tally: Tally, title: str) -> Iterator[Callable[[Outcome[Any]], None]]:
    """At intervals a line from a thread, because the caller waits. The function that it yields is called with every outcome.

    In a pipe or a file each outcome has a line, except for points of a study that are jobs of their own.
    """
    ended, in_place = threading.Event(), sys.stderr.isatty()

    def tell() -> None:
        wait = FIRST_LINE_AFTER
        while not ended.wait(wait):
            at_work = tally.at_work()
            more = [f"{len(at_work) - _MOST_AT_WORK} more"] if len(at_work) > _MOST_AT_WORK else []
            line = "; ".join([f"{title}: {tally} after {span(tally.elapsed)}", *at_work[:_MOST_AT_WORK], *more])
            if in_place:
                _write(f"{_ANEW}  {line[: shutil.get_terminal_size().columns - 3]}")
            else:
                _say(line)
            wait = CHANGES_AFTER if in_place else LINE_INTERVAL

    def done(outcome: Outcome[Any]) -> None:
        if tally.total > 1 and not in_place and not (outcome.job.brief and outcome.job.points == 1 and outcome.completed):
            _say(f"{outcome.job.name}: {outcome.failure or f'done in {span(outcome.seconds)}'}; {tally}")

    thread = threading.Thread(target=tell, daemon=True)
    thread.start()
    try:
        yield done
    finally:
        ended.set()
        thread.join()
        if in_place:
            _write(_ANEW)


@contextlib.contextmanager
def compilation_announced(quiet: bool) -> Iterator[None]:
    """Print one line if this process waits for compilation; nothing if compiled code exists, or if quiet.

    Processor time decides, not the clock: on a busy machine loading also takes long.
    """
    ended: list[threading.Event] = []

    def hear(progress: progress_of_engines.Progress) -> None:
        while ended:
            ended.pop().set()
        if progress.phase == progress_of_engines.COMPILING and not quiet:
            ended.append(threading.Event())
            threading.Thread(target=_tell_of_compiling, args=(progress.engine, ended[0], time.process_time()), daemon=True).start()

    with progress_of_engines.heard_by(hear):
        try:
            yield
        finally:
            while ended:
                ended.pop().set()


def _tell_of_compiling(engine: str, ended: threading.Event, began: float) -> None:
    while not ended.wait(LOOK_INTERVAL):
        if process := waits_for():
            _say(f"{engine}: waits for process {process}, which compiles its equations, once for this machine ...")
            return
        if time.process_time() - began > COMPILING_AFTER:
            _say(f"{engine}: compiling its equations, once for this machine; that takes some fifteen seconds ...")
            return


@functools.cache
def _say_what_is_forgotten() -> None:
    """Print, once in a process, the warning that compiled code is not kept, if there is one."""
    if sentence := cache_folder.warning_if_not_kept():
        _say(sentence)


def _say(line: str) -> None:
    _write(f"  {line}\n")


def _write(text: str) -> None:
    with contextlib.suppress(OSError, ValueError):  # nobody listens
        print(text, end="", file=sys.stderr, flush=True)


def _line(job: Job[Any], progress: Progress | None) -> str:
    told = str(progress or "beginning")
    engine = progress.engine if progress else ""
    return f"{job.name}: {told.removeprefix(f'{engine}, ') if engine and engine in job.name else told}"


def span(seconds: float) -> str:
    """A time span as text: "4 s", "3 min 20 s", "1 h 20 min"."""
    whole = round(max(seconds, 0.0))
    if whole < 60:
        return f"{whole} s"
    minutes = whole // 60
    return f"{minutes} min {whole % 60} s" if minutes < 60 else f"{minutes // 60} h {minutes % 60} min"
