"""Recorded verdicts on engines, and the rows that record them (`reports.long_studies`)."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from quickreturn.cases.running.job import Outcome
from quickreturn.cases.running.workshop import Workshop
from quickreturn.engines.registry import engine, own_engines
from quickreturn.plugins.conform.contract import Conformance, conform
from quickreturn.plugins.conform.contract import job as job_of
from quickreturn.reports.long_studies import about, table
from quickreturn.reports.page.content import Content
from quickreturn.reports.page.part import Part


@dataclass(frozen=True)
class ConformanceRow:
    """The verdict of `quickreturn conform` on a version of an engine, and the number of checks behind it."""

    engine: str
    version: str
    verdict: str
    passed: int
    failed: int
    not_judged: int

    @classmethod
    def of(cls, conformance: Conformance, version: str) -> "ConformanceRow":
        """The outcome for a version of an engine."""
        counts = Counter(check.status for check in conformance.checks)
        return cls(conformance.engine, version, conformance.verdict, counts["passed"], counts["failed"], counts["not judged"])

    @property
    def words(self) -> str:
        """The verdict and the number of checks behind it."""
        unjudged = f", {self.not_judged} could not be judged" if self.not_judged else ""
        return f"{self.verdict}; {self.passed} checks passed{unjudged}"


def rows(workshop: Workshop) -> dict[str, Sequence[Any]]:
    """Rows of the verdicts on the engines of this project."""
    found = list[ConformanceRow]()
    for name in own_engines():
        job = job_of(name)
        outcome = workshop.stored(job)
        if outcome is None and workshop.computes:
            outcome = workshop.kept(Outcome(job, conform(name, workshop.executor)))
        if outcome is not None and outcome.value is not None:
            found.append(ConformanceRow.of(outcome.value, engine(name).version()))
    return {"conformance": found}


def verdicts(content: Content) -> Mapping[str, str]:
    """Engine -> verdict on whether it does what it says: the user's stored one, else the recorded one, else how to get one."""
    words, record = {name: f"not tested: run quickreturn conform {name}" for name in content.engines}, about("conformance")
    if record is not None:
        words |= {row.engine: f"{row.words} (recorded on {record.words})" for row in table("conformance", ConformanceRow)}
    for name in content.engines:
        outcome = content.workshop.stored(job_of(name)) if content.workshop else None
        if outcome is not None and outcome.value is not None:
            words[name] = ConformanceRow.of(outcome.value, engine(name).version()).words
    return words


PAGE = Part(of_engines={"does what it says": verdicts})
