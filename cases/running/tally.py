"""Counts the jobs of a call: those that are done, those at work, and the remaining time."""

import threading
import time
from collections.abc import Sequence
from typing import Any

from quickreturn.cases.running.job import Job, Outcome
from quickreturn.engines.progress import Progress


class Tally:
    """Number of finished jobs, jobs at work, and the remaining time."""

    def __init__(self, jobs: Sequence[Job[Any]], at_once: int) -> None:
        """`at_once`: how many jobs are computed at a time."""
        self.total, self.done, self._at_once = sum(job.points for job in jobs), 0, at_once
        self._unfinished = {id(job): job for job in jobs}
        self._began = time.monotonic()
        self._at_work: dict[int, tuple[Job[Any], Progress | None, float]] = {}
        self._spent: dict[_Sort, tuple[float, int]] = {}  # seconds and points of the ended jobs of a sort
        self._rows = False  # whether a job has several points
        self._lock = threading.Lock()

    def watch(self, job: Job[Any], progress: Progress | None) -> None:
        """Note the progress of a job; None: it has begun."""
        with self._lock:
            began = self._at_work[id(job)][2] if id(job) in self._at_work else time.monotonic()
            self._at_work[id(job)] = job, progress, began

    def ended(self, outcome: Outcome[Any]) -> None:
        """Note that a job has ended, successfully or not."""
        with self._lock:
            self._at_work.pop(id(outcome.job), None)
            self._unfinished.pop(id(outcome.job), None)
            self.done += outcome.job.points
            seconds, points = self._spent.get(_sort(outcome.job), (0.0, 0))
            self._spent[_sort(outcome.job)] = seconds + outcome.seconds, points + outcome.job.points
            self._rows |= outcome.job.points > 1

    @property
    def elapsed(self) -> str:
        """Time since the beginning, as text."""
        return span(time.monotonic() - self._began)

    @property
    def left(self) -> float | None:
        """Remaining time, s, from the averages so far; None while there is a sort of job of which none has ended.

        A job that takes longer than the average of its sort is assumed to take as long again as it has until now.
        """
        with self._lock:
            if not all(_sort(job) in self._spent for job in self._unfinished.values()):
                return None
            now, each = time.monotonic(), list[float]()
            for key, job in self._unfinished.items():
                seconds, points = self._spent[_sort(job)]
                taken = now - self._at_work[key][2] if key in self._at_work else 0.0
                usual = job.points * seconds / points
                each.append(usual - taken if taken < usual else taken)
            return max(sum(each) / self._at_once, max(each, default=0.0))

    def at_work(self) -> list[str]:
        """A line for each job that is being computed."""
        with self._lock:
            return [_line(job, progress) for job, progress, _ in self._at_work.values()]

    def __str__(self) -> str:
        left = self.left
        ahead = f", about {span(left)} left" if left and left >= 0.5 else ""
        rate = f", {self.done / (time.monotonic() - self._began):.3g} a second" if self._rows else ""
        return f"{self.done} of {self.total} done{rate}{ahead}"


#: Kind, function and engines of a job; the time that it takes depends on them.
_Sort = tuple[str, str, tuple[str, ...]]


def _sort(job: Job[Any]) -> _Sort:
    return job.kind, getattr(job.function, "__qualname__", ""), job.engines


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
