"""How far it is, on standard error, for people only: a bar with the time left, and a line for each job at work."""

import sys
from collections.abc import Generator, Sequence
from contextlib import closing
from types import TracebackType
from typing import Any

from cases.jobs.job import Executor, Job, Outcome, T, Watch
from engines.progress import Progress


def watched(executor: Executor, jobs: Sequence[Job[T]], title: str) -> Generator[Outcome[T], None, None]:
    """Outcomes as they come, while the person who waits sees how far the jobs are; raises as `Executor.run`."""
    with Display(len(jobs), title) as display, closing(executor.run(jobs, display.watch)) as running:
        for outcome in running:
            display.ended(outcome.job)
            yield outcome


def answers(executor: Executor, jobs: Sequence[Job[T]], title: str) -> list[Outcome[T]]:
    """How each of the jobs ended, in their order; their results are good for this moment and not stored. Raises as `Executor.run`."""
    with closing(watched(executor, jobs, title)) as computed:
        found = {id(outcome.job): outcome for outcome in computed}
    return [found[id(job)] for job in jobs]


class Display:
    """Shown while it is entered, where standard error is a terminal.

    Attributes:
        watch: for an executor; None where nobody sees it.
    """

    def __init__(self, total: int, title: str) -> None:
        """`total` jobs, called `title` in all."""
        self.watch: Watch | None = self._at_work if sys.stderr.isatty() else None
        self._total, self._title = total, title
        self._lines: dict[int, Any] = {}

    def __enter__(self) -> "Display":
        if self.watch is not None:
            from rich.console import Console
            from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeElapsedColumn, TimeRemainingColumn
            from rich.progress import Progress as Bar

            columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn(), TextColumn("left"))
            self._bar = Bar(*columns, TimeRemainingColumn(), console=Console(stderr=True), transient=True)
            self._bar.start()
            self._whole = self._bar.add_task(self._title, total=self._total)
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        if self.watch is not None:
            self._bar.stop()

    def ended(self, job: Job[Any]) -> None:
        """One job less."""
        if self.watch is not None:
            self._bar.advance(self._whole)
            if (line := self._lines.pop(id(job), None)) is not None:
                self._bar.remove_task(line)

    def _at_work(self, job: Job[Any], progress: Progress) -> None:
        if id(job) not in self._lines:
            self._lines[id(job)] = self._bar.add_task("", total=1)
        self._bar.update(self._lines[id(job)], description=f"  {job.name}: {progress}")
