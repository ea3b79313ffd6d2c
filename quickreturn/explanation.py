"""What happens in a turn of a machine, in sentences with numbers."""

import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from quickreturn.cases.case import Case
from quickreturn.cases.displayed import Cell, Displayed
from quickreturn.cases.runs.request import Run
from quickreturn.catalogue import AnyCase, one_case
from quickreturn.computing import Computing
from quickreturn.cross_validation import given_settings, validated
from quickreturn.reports.results.turn import Statement, statements


@dataclass(frozen=True, repr=False)
class Explanation(Displayed):
    """What happens in a turn of a machine in its steady state.

    Attributes:
        case: name of the machine.
        title: its title.
        run: the run of the engine from which the sentences are read.
        statements: sentences with topic and numbers (SI); none if the run has no settled turn.
    """

    case: str
    title: str
    run: Run
    statements: tuple[Statement, ...]

    def _parts(self) -> Iterator[Cell]:
        yield f"{self.case}: {self.title}"
        yield from (f"- {each.sentence}" for each in self.statements)


def explain(
    case: AnyCase,
    engine: str | os.PathLike[str] = "reference",
    *,
    accuracy: float | None = None,
    settings: Mapping[str, Any] | None = None,
    quiet: bool = False,
) -> Explanation:
    """Say what happens in a turn of a machine in its steady state; the run is that of `qr.run`, from the store if it is there.

    Args:
        case: a name, a path or a `Case`.
        engine: name, or path of a file that declares one.
        accuracy: relative error of the tip deflection asked for; None: the engine's default.
        settings: settings of the engine, by name.
        quiet: whether progress on standard error is left out.

    Raises:
        CaseError, UnknownEngine, Refusal, SettingError, StoreError, KeyboardInterrupt: as `run`.
    """
    engine = os.fspath(engine)
    return explanation(one_case(case), engine, given_settings({engine: settings or {}}), accuracy, Computing(quiet=quiet))


def explanation(
    case: Case, engine: str, settings: Mapping[str, Mapping[str, str]], accuracy: float | None, computing: Computing
) -> Explanation:
    """The explanation of a loaded case, with settings by engine as texts."""
    (result,) = validated([case], [engine], settings, accuracy, computing).results
    return Explanation(case.name, case.title, result.runs[engine], tuple(statements(case, result.runs[engine])))
