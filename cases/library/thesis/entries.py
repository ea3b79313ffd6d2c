"""The 24 runs as entries of the case library."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Final

from quickreturn.cases.files.document import Document
from quickreturn.cases.library.thesis.inconsistencies import inconsistencies
from quickreturn.cases.library.thesis.runs import RUNS, TAG, run_document, run_name, run_title


@dataclass(frozen=True, kw_only=True)
class Entry:
    """A generated case."""

    title: str
    tags: tuple[str, ...]
    document: Callable[[], Document]  # its values as in a case file
    notes: Callable[[], tuple[str, ...]]  # sentences on where its values come from; the values are not doubted
    number: str  # by which tables call it: "run 24"
    group: str  # heading of those that the page lists together


def _notes(number: int) -> tuple[str, ...]:
    """Sentences on the published inconsistencies of a run."""
    return tuple(each.sentence for each in inconsistencies() if number in each.runs)


#: Name -> entry of a run.
ENTRIES: Final[Mapping[str, Entry]] = {
    run_name(number): Entry(
        title=run_title(number),
        tags=(TAG,),
        document=partial(run_document, number),
        notes=partial(_notes, number),
        number=str(number),
        group=f"crank {run.crank_length} in",
    )
    for number, run in RUNS.items()
}
