"""Display of progress in a terminal, in place."""

import contextlib
from collections.abc import Callable, Iterator
from typing import Any

from rich.console import Console, Group
from rich.live import Live
from rich.progress_bar import ProgressBar
from rich.table import Table
from rich.text import Text

from quickreturn.cases.jobs.job import Outcome
from quickreturn.cases.jobs.tally import Tally


@contextlib.contextmanager
def in_place(tally: Tally, title: str) -> Iterator[Callable[[Outcome[Any]], None]]:
    """A bar, and below it the jobs at work. The yielded function is called with every outcome."""

    def drawn() -> Group:
        head = Table.grid(padding=(0, 1))
        head.add_row(title, ProgressBar(total=tally.total, completed=tally.done, width=30), str(tally), tally.elapsed)
        return Group(head, *(Text(f"  {line}", no_wrap=True, overflow="ellipsis") for line in tally.at_work()))

    with Live(get_renderable=drawn, console=Console(stderr=True), transient=True, refresh_per_second=8):
        yield lambda outcome: None
