"""Fixtures of the plugins' tests: those of commands, and of pages in a browser."""

from tests.quickreturn.conftest import call, own_store
from tests.reports.page.conftest import opened, pytest_runtest_teardown, tabs

__all__ = ["call", "opened", "own_store", "pytest_runtest_teardown", "tabs"]
