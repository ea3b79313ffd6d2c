"""The 24 runs as entries of the case library."""

from functools import partial
from typing import Final

from quickreturn.cases.library import Entry
from quickreturn.cases.thesis.inconsistencies import inconsistencies
from quickreturn.cases.thesis.runs import RUNS, TAG, run_document, run_name, run_title


def _notes(number: int) -> tuple[str, ...]:
    """Sentences on the published inconsistencies of a run."""
    return tuple(each.sentence for each in inconsistencies() if number in each.runs)


#: Name -> entry of a run.
ENTRIES: Final = {
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
