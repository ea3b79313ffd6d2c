"""Answers of engines for commands that keep no workshop."""

from collections.abc import Sequence
from dataclasses import replace

import click

from quickreturn.cases.jobs import fork_server
from quickreturn.cases.jobs.job import Job, Outcome, T
from quickreturn.cases.jobs.processes import LocalProcesses
from quickreturn.cases.jobs.store import Store
from quickreturn.cases.jobs.workshop import outcomes_of
from quickreturn.commands import console, options
from quickreturn.engines.registry import OWN
from quickreturn.solution import opened_store


def answered(jobs: Sequence[Job[T]], title: str) -> tuple[list[Outcome[T]], Store | None]:
    """The outcomes of jobs under the options of `limited` and `stored`, and the store, if there is one; a message names stored results."""
    meta = click.get_current_context().meta
    # another's engine: its version and code, which the key contains, would load its library here
    jobs = [job if OWN.issuperset(job.engines) else replace(job, lasts=None) for job in jobs]
    store = None if meta.get(options.NO_STORE) or not any(job.lasts for job in jobs) else opened_store(console.tell)
    meta[console.STORE] = store
    executor = LocalProcesses(limits=options.limits(), preload=fork_server.COMPUTING, quiet=console.quiet())
    outcomes = outcomes_of(jobs, title, executor, store)
    if store is not None and (known := [outcome.job.name for outcome in outcomes if outcome.stored]):
        console.begin(f"{', '.join(known)}: computed before and kept in {store.folder}; {options.NO_STORE} computes anew")
    if all(outcome.stored for outcome in outcomes):
        fork_server.not_needed()
    return outcomes, store
