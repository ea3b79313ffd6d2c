"""Plugins: parts of the program in folders of their own, `plugins/NAME/`, which can be deleted.

The entry-point group `quickreturn.plugins` names a `Plugin` for each. It says what the plugin adds, in texts "module:name" that are
imported on their first use. So listing commands or engines imports nothing of them, and nothing below a plugin imports it.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from importlib import import_module
from importlib.metadata import entry_points
from typing import Any, Final

GROUP: Final = "quickreturn.plugins"


@dataclass(frozen=True, kw_only=True)
class Plugin:
    """What a plugin adds to the program. Each value is a text "module:name", if nothing else is said.

    Attributes:
        engines: name of an engine -> its class, or an instance.
        engine_files: ending of a file, without its point -> the function that makes an engine of the file's path.
    """

    engines: Mapping[str, str] = field(default_factory=dict)
    engine_files: Mapping[str, str] = field(default_factory=dict)


@cache
def plugins() -> Mapping[str, Plugin]:
    """The installed plugins by name."""
    return {entry.name: entry.load() for entry in sorted(entry_points(group=GROUP), key=lambda entry: entry.name)}


def found(place: str) -> Any:
    """What a text "module:name" stands for."""
    module, _, name = place.partition(":")
    return getattr(import_module(module), name)
