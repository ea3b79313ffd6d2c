"""Runs with values chosen by tests."""

from dataclasses import replace
from typing import Any

from quickreturn.cases.motion.request import Run


def changed_run(run: Run, **values: Any) -> Run:
    """The run with other values of its fields and of the fields of its parts, by their names."""
    parts = {}
    for part in ("computation", "approach", "measured"):
        of_part = getattr(run, part)
        parts[part] = replace(of_part, **{name: values.pop(name) for name in vars(of_part) if name in values})
    return replace(run, **(parts | values))
