"""Linear algebra on one thread: the eigenproblems of the shapes are small.

A second thread makes them use up to thirty times the processor time, and saves none.
"""

from collections.abc import Callable
from functools import wraps
from typing import Any, TypeVar

from threadpoolctl import threadpool_limits

from quickreturn.engines.registry import MAIN

T = TypeVar("T")


def on_one_thread(function: Callable[..., T]) -> Callable[..., T]:
    """Decorator of a function whose first argument is an engine."""

    @wraps(function)
    def limited(engine: Any, *arguments: Any, **named: Any) -> T:
        if engine.name not in MAIN:  # scipy has a BLAS of its own, and the limit holds for what is loaded; the main engines use numpy's
            import scipy.linalg  # noqa: F401
        with threadpool_limits(limits=1, user_api="blas"):
            return function(engine, *arguments, **named)

    return limited
