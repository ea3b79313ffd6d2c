"""Keeps the outcome of a verification for the report: `pytest -m verify --keep-outcome`."""

import gc
import json
import os
import signal
import sys
import time
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

# As the command does: two test processes on two cores have no third and fourth one for their linear algebra.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import hypothesis
import pytest

# A shell that starts the tests in the background has them ignore Ctrl-C, and so would every program that they start.
signal.signal(signal.SIGINT, signal.default_int_handler)

# Workers take over this path, and some are asked to run what stands in the tests. They find the tests there and nothing else of the
# checkout, whose folders at the top are no packages for a user (`import cases` fails).
ROOT = Path(__file__).resolve().parent
TESTS_ALONE = ROOT / "build/tests-alone"
TESTS_ALONE.mkdir(parents=True, exist_ok=True)
for folder in ("tests", "plugins"):
    with suppress(FileExistsError):
        (TESTS_ALONE / folder).symlink_to(ROOT / folder)
sys.path.insert(0, str(TESTS_ALONE))

from tests.ledger import Ledger, Status  # noqa: E402 - found by the path above
from tests.slices import LONGEST, UNREACHED, Portion, Slices, add_options, slice_of  # noqa: E402 - found by the path above

# a busy machine makes no law untrue; other examples are drawn in the next run
hypothesis.settings.register_profile("quickreturn", deadline=None, max_examples=50)
hypothesis.settings.load_profile("quickreturn")


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Iterator[None]:
    """Modules and tests stay to the end: that the collector of garbage looks at them again and again takes a fifth of the collection."""
    gc.disable()
    yield
    gc.freeze()
    gc.enable()


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """The longest files first; with several processes xdist must be told to keep the order (`--no-loadscope-reorder`)."""
    places = {name: place for place, name in enumerate(LONGEST)}
    items.sort(key=lambda item: places.get(item.path.stem, len(places)))


def pytest_addoption(parser: pytest.Parser) -> None:
    add_options(parser)
    parser.addoption("--ledger-status", action="store_true", help="tell which of the tests should run again, and run none")
    parser.addoption("--keep-outcome", action="store_true", help="write the outcome to the store's folder, where the report finds it")


def pytest_configure(config: pytest.Config) -> None:
    config.pluginmanager.register(Slices(config), "slices")
    # with several processes the first one hears of all tests; the others must not write
    if not hasattr(config, "workerinput"):
        if config.getoption("--keep-outcome"):
            config.pluginmanager.register(_Outcome(), "kept outcome")
        if config.getoption("--ledger-status"):
            config.pluginmanager.register(Status(), "status of the ledger")
        elif config.getoption("-m") == "verify":
            config.pluginmanager.register(Ledger(UNREACHED), "ledger")


@pytest.fixture
def portion(request: pytest.FixtureRequest) -> Portion:
    """Chooses what a test computes: everything, or in a slice so many of it, drawn by the slice's number."""
    chosen = slice_of(request.config)
    return lambda everything, count: list(everything) if chosen is None else chosen.drawn(everything, count)


class _Outcome:
    """Collects one row per test, and the chapters that tests hand in by `record_property("chapter", {...})`."""

    def __init__(self) -> None:
        self.rows: list[list[Any]] = []
        self.chapters: list[dict[str, Any]] = []

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        if report.when == "call" or (report.when == "setup" and report.outcome != "passed"):
            file, _, name = report.nodeid.partition("::")
            self.chapters += [dict(value) for key, value in report.user_properties if key == "chapter" and isinstance(value, dict)]
            measured = "; ".join(f"{key} {value}" for key, value in report.user_properties if key != "chapter")
            self.rows.append([file.removeprefix("tests/"), _words(name), report.outcome, round(report.duration, 1), measured or None])

    def pytest_sessionfinish(self) -> None:
        from quickreturn.cases.running.key import code_fingerprint
        from quickreturn.cases.running.store import Store, write_atomically
        from quickreturn.reports.page.content import FILE

        passed = sum(row[2] == "passed" for row in self.rows)
        chapter = {
            "title": "Long checks",
            "text": f"{passed} of {len(self.rows)} checks passed.",
            "columns": ["where", "what", "outcome", "time [s]", "measured"],
            "rows": sorted(self.rows, key=lambda row: (row[0], row[1])),
        }
        date = time.strftime("%Y-%m-%d %H:%M UTC", time.gmtime())
        document = {"code": code_fingerprint(), "date": date, "chapters": [*self.chapters, chapter]}
        write_atomically(Store().folder / FILE, json.dumps(document, indent=1).encode())


def _words(name: str) -> str:
    return name.removeprefix("test_").replace("_", " ")
