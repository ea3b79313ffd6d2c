"""Records results of the long studies as the tables of `reports.long_studies`: `python -m quickreturn.record`.

Missing results are computed, which takes hours; `--stored` takes only stored results.
Names of studies, as in `studies`, choose among them: `python -m quickreturn.record classes`.
"""

import dataclasses
import subprocess
import sys
import time
from collections.abc import Sequence
from contextlib import suppress
from importlib.metadata import version
from typing import Any

from quickreturn.cases.running.key import LIBRARIES
from quickreturn.cases.running.store import Store, write_atomically
from quickreturn.cases.running.workshop import Workshop
from quickreturn.engines.registry import engine
from quickreturn.reports.long_studies import FOLDER, About, about, studies, text_of


def main(arguments: Sequence[str]) -> int:
    """Write the tables of all studies, or of the named ones; exit code 2 for an unknown argument."""
    names = [each for each in arguments if each != "--stored"]
    if unknown := sorted(set(names) - set(studies())):
        print(f"python -m quickreturn.record: {' '.join(unknown)}: accepted: --stored, {', '.join(studies())}", file=sys.stderr)
        return 2
    workshop, lines = Workshop(Store()), list[str]()
    if "--stored" in arguments:
        workshop = workshop.as_it_is
    for study in names or studies():
        tables = studies()[study](workshop)
        if all(tables.values()):
            for table, rows in tables.items():
                _write(table, rows)
            lines.append(f"{study} ({', '.join(f'{len(rows)} rows of {table}' for table, rows in tables.items())})")
            _write("about", [_about_now(each) if each == study else old for each in studies() if (old := about(each)) or each == study])
            about.cache_clear()
    print(", ".join(lines) or "nothing is stored")
    return 0


def _about_now(study: str) -> About:
    versions = [f"{name} {version(name)}" for name in LIBRARIES] + [str(engine(name).version()) for name in ("exudyn", "mujoco")]
    return About(study, time.strftime("%Y-%m-%d", time.gmtime()), ", ".join(versions), commit())


def commit() -> str:
    """The commit of the checkout that holds the tables, abbreviated; "" without git."""
    with suppress(FileNotFoundError):
        found = subprocess.run(["git", "rev-parse", "--short", "HEAD"], cwd=FOLDER, capture_output=True, text=True, check=False)
        return found.stdout.strip()
    return ""


def confirm(study: str) -> None:
    """Note that cells of a recorded study came out alike at the checkout's commit."""
    _write("about", [dataclasses.replace(old, confirmed=commit()) if each == study else old for each in studies() if (old := about(each))])
    about.cache_clear()


def _write(table: str, rows: Sequence[Any]) -> None:
    write_atomically(FOLDER / f"{table}.csv", text_of(rows).encode())


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
