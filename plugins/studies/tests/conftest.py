"""Fixtures of pages in a browser."""

from tests.reports.page.conftest import opened, pytest_runtest_teardown, tabs

__all__ = ["opened", "pytest_runtest_teardown", "tabs"]
