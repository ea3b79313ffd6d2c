"""A store with an executor: results come from the store if they are there, otherwise the executor computes them and they are stored.

Outcomes that would repeat are stored (`Job.lasts`): a result, or an exception of the job's own. Outcomes that depend on the machine are
not: a killed process, a limit of time or memory, a full disk, a missing library. Such a job is tried again the next time.
"""

from collections.abc import Sequence
from contextlib import closing
from dataclasses import dataclass, field, replace
from typing import Any, get_type_hints

from quickreturn.cases.running.display import answers, watched
from quickreturn.cases.running.job import Executor, Job, Nobody, Outcome, T
from quickreturn.cases.running.key import key_of
from quickreturn.cases.running.store import Pieces, Record, Store, decoded, encoded


def _processes() -> Executor:
    """Processes of this machine, imported on first use, so that a notebook need not wait."""
    from quickreturn.cases.running.isolation import LocalProcesses

    return LocalProcesses()


@dataclass(frozen=True)
class Workshop:
    """A store and an executor."""

    store: Store
    executor: Executor = field(default_factory=_processes)

    def outcomes(self, jobs: Sequence[Job[T]], title: str) -> list[Outcome[T]]:
        """The outcome of each job, in their order; jobs with equal keys are computed once.

        Raises:
            KeyboardInterrupt: Ctrl-C; what was computed is stored.
            UnknownEngine: a job depends on a name that is no engine's.
        """
        keys = [key_of(job) if job.lasts else f"job {number}" for number, job in enumerate(jobs)]
        wanted = {key: self._with_pieces(job, key) for key, job in zip(reversed(keys), reversed(jobs), strict=True)}
        outcomes = {key: outcome for key in dict.fromkeys(keys) if (outcome := self._stored(wanted[key], key)) is not None}
        missing = {id(wanted[key]): key for key in dict.fromkeys(keys) if key not in outcomes}
        with closing(watched(self.executor, [wanted[key] for key in missing.values()], title)) as computed:
            for outcome in computed:
                key = missing[id(outcome.job)]
                outcomes[key] = self.kept(outcome, key)
        return [replace(outcomes[key], job=job) for key, job in zip(keys, jobs, strict=True)]

    def _with_pieces(self, job: Job[T], key: str) -> Job[T]:
        """The job with the place for its pieces, if it has any; its key is that without them."""
        if not job.pieces or job.lasts is None:
            return job
        return replace(job, arguments=(*job.arguments, Pieces(str(self.store.folder.resolve()), key)))

    @property
    def as_it_is(self) -> "Workshop":
        """The same store without computation: outcomes of jobs that are not stored are `missing`."""
        return replace(self, executor=Nobody())

    @property
    def computes(self) -> bool:
        """Whether anything is computed."""
        return not isinstance(self.executor, Nobody)

    def stored(self, job: Job[T]) -> Outcome[T] | None:
        """The outcome of a job, if it is stored."""
        return self._stored(job, key_of(job))

    def kept(self, outcome: Outcome[T], key: str | None = None) -> Outcome[T]:
        """Store the outcome of a job if it would repeat; return it as it will be read back."""
        if outcome.job.lasts is None or not outcome.job.lasts(outcome):
            return outcome
        key = key or key_of(outcome.job)
        if outcome.completed:
            try:
                record = encoded(outcome.value)
                self.store.put(key, replace(record, document={"value": record.document}))
                return replace(outcome, value=decoded(_type_of(outcome.job), record))
            except (TypeError, ValueError, KeyError) as error:  # a third-party engine may return anything
                return replace(outcome, value=None, failure=f"its result cannot be stored: {error}", output="")
        self.store.put(key, Record({"failure": outcome.explanation}))
        return outcome

    def _stored(self, job: Job[T], key: str) -> Outcome[T] | None:
        record = self.store.get(key) if job.lasts else None
        if record is None:
            return None
        try:
            if "failure" in record.document:
                return Outcome(job, failure=str(record.document["failure"]), stored=True)
            return Outcome(job, decoded(_type_of(job), replace(record, document=record.document["value"])), stored=True)
        except (TypeError, ValueError, KeyError) as error:
            self.store.note_damage(key, f"cannot be read ({error})")
            return None


def outcomes_of(jobs: Sequence[Job[T]], title: str, executor: Executor, store: Store | None) -> list[Outcome[T]]:
    """As `Workshop.outcomes`; without a store everything is computed, and nothing is stored."""
    return answers(executor, jobs, title) if store is None else Workshop(store, executor).outcomes(jobs, title)


def _type_of(job: Job[Any]) -> Any:
    """The annotated return type of the job's function."""
    return get_type_hints(job.function).get("return", Any)
