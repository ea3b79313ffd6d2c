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
    """What a plugin adds to the program. A *place* is a text "module:name".

    Attributes:
        engines: name of an engine -> the place of its class, or of an instance.
        engine_files: ending of a file, without its point -> the place of the function that makes an engine of the file's path.
        measures: place of a sequence of measures of a settled motion, each an `OfTurn` or a `Measure` (`cases.motion`); "" if it has none.
        readings: name -> place of what it reads off results under that name, a `quickreturn.readings.Reading`.
        commands: name of a command -> its place, and the first sentence of its help.
        page: place of what it adds to the page of a report, a `reports.page.part.Part`; "" if it adds nothing.
        leads: place of a function of a case and a recorded table of it that gives what quantities of the scene would explain of the table,
            some `cases.comparison.causes.Explanation`; "" if it has none.
        records: name of a long study -> the place of the function that gives the rows of its recorded tables.
    """

    engines: Mapping[str, str] = field(default_factory=dict)
    engine_files: Mapping[str, str] = field(default_factory=dict)
    measures: str = ""
    readings: Mapping[str, str] = field(default_factory=dict)
    commands: Mapping[str, tuple[str, str]] = field(default_factory=dict)
    page: str = ""
    leads: str = ""
    records: Mapping[str, str] = field(default_factory=dict)


@cache
def plugins() -> Mapping[str, Plugin]:
    """The installed plugins by name."""
    return {entry.name: entry.load() for entry in sorted(entry_points(group=GROUP), key=lambda entry: entry.name)}


def entries(of: str) -> dict[str, Any]:
    """The entries of one of the mappings of all plugins, such as "commands"."""
    return {name: entry for plugin in plugins().values() for name, entry in getattr(plugin, of).items()}


def places(of: str) -> list[str]:
    """The places that plugins name by one of their attributes, such as "page"."""
    return [place for plugin in plugins().values() if (place := getattr(plugin, of))]


def found(place: str) -> Any:
    """What a place stands for."""
    module, _, name = place.partition(":")
    return getattr(import_module(module), name)
