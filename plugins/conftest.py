"""Fixtures of the plugins' tests: those of commands."""

from tests.quickreturn.conftest import call, own_store

__all__ = ["call", "own_store"]
