"""The engines: the four main ones, those of plugins, and third-party ones from the entry-point group `quickreturn.engines`.

An engine's module is imported only when the engine is used, so that a missing or broken library disables its own engine and no
other. An entry point maps the engine's name, which the class has as `name`, to its class:

    [project.entry-points."quickreturn.engines"]
    my-engine = "my_package.my_module:MyEngine"

In place of a name stands the path of a file that makes an engine, if a plugin reads files with its ending (`Plugin.engine_files`).
"""

import difflib
import os
from collections.abc import Callable, Mapping
from importlib.metadata import EntryPoint, entry_points
from pathlib import PurePath
from typing import Any, Final, NoReturn, cast

from quickreturn.engines.base import ESTIMATES, INTERFACE, AnyEngine, Engine, Refusal, first_line
from quickreturn.engines.plugins import entries as of_plugins
from quickreturn.engines.plugins import found
from quickreturn.engines.settings import Settings as AnySettings
from quickreturn.reference_model.errors import ToldError

MAIN: Final = ("thesis", "reference", "exudyn", "mujoco")
#: The main engine whose discretization is its model: its distance to the others is a model error, and reported as such.
MODEL: Final = "thesis"
GROUP: Final = "quickreturn.engines"
_LONGEST_NAME: Final = 60  # characters of an unknown name that a message quotes

_MODULES: Final = {
    "thesis": "quickreturn.engines.own.thesis:ThesisEngine",
    "reference": "quickreturn.engines.own.reference:ReferenceEngine",
    "exudyn": "quickreturn.engines.exudyn.engine:ExudynEngine",
    "mujoco": "quickreturn.engines.mujoco.engine:MujocoEngine",
}


class UnknownEngine(ToldError, ValueError):
    """No engine has this name; the text is one sentence with the nearest known names."""


def own_engines() -> Mapping[str, str]:
    """Engines of this package and its plugins, each with the place of its class.

    They load no library but numpy until a model is built, so that they can be asked about themselves anywhere.
    """
    return _MODULES | of_plugins("engines")


def engine_names() -> tuple[str, ...]:
    """Names of all engines, whether usable here or not: the main ones in their order, those of plugins, then others by name."""
    return (*own_engines(), *sorted(_third_party()))


def is_engine(name: str) -> bool:
    """Whether an engine may have this name: one that is known, or the path of a file of a kind that makes an engine."""
    return name in engine_names() or _reader_of_file(name) is not None


def is_foreign(name: str) -> bool:
    """Whether an engine is of another package, whose library is loaded where the engine is asked about itself."""
    return name in _third_party()


def _reader_of_file(name: str) -> str | None:
    """The place of the function that makes an engine of a file with this name's ending."""
    place: str | None = of_plugins("engine_files").get(PurePath(name).suffix.removeprefix(".").lower())
    return place


def engine(name: str | os.PathLike[str]) -> AnyEngine:
    """The engine of this name, or of a path that ends in ".toml".

    If its code cannot be loaded, it is one whose `unavailable()` says so and that refuses everything.

    Mistakes in an engine's file, whose path the name may be, raise what reads that file.

    Raises:
        UnknownEngine: no engine has this name.
    """
    name = os.fspath(name)
    if place := own_engines().get(name):
        return _loaded(name, lambda: found(place))
    entries = _third_party().get(name)
    if entries is None and (reader := _reader_of_file(name)):
        made: AnyEngine = found(reader)(name)
        return made
    if entries is None:
        raise UnknownEngine(_unknown(name))
    if len(entries) > 1:
        return Missing(name, f"{len(entries)} packages provide an engine of this name: {', '.join(map(_origin, entries))}")
    return _loaded(name, entries[0].load)


def usable_engine(name: str | os.PathLike[str]) -> AnyEngine:
    """The engine of this name, which can be used on this machine.

    Raises:
        UnknownEngine: no engine has this name.
        Refusal: the engine cannot be used here; the sentence says why.
    """
    named = engine(name)
    reason = named.unavailable()
    if reason is not None:
        raise Refusal(f"engine {name} is not available: {reason}")
    return named


def _third_party() -> dict[str, list[EntryPoint]]:
    """Entry points by engine name, without those that have the name of an engine of this project: no package can replace one."""
    entries: dict[str, list[EntryPoint]] = {}
    for entry in entry_points(group=GROUP):
        if entry.name not in own_engines():
            entries.setdefault(entry.name, []).append(entry)
    return entries


def _loaded(name: str, load: Callable[[], object]) -> AnyEngine:
    """An instance of the class that `load` returns, or the instance; a `Missing` if that is no engine of this name and interface."""
    try:
        loaded = load()
        if isinstance(loaded, type) and issubclass(loaded, Engine):
            loaded = loaded()
        if not isinstance(loaded, Engine):
            return Missing(name, f"{loaded!r} is not a class derived from engines.base.Engine")
        if loaded.name != name:
            return Missing(name, f'its class calls itself "{loaded.name}"')
        if loaded.interface != INTERFACE:
            return Missing(name, f"it is written for version {loaded.interface} of the engines' interface, this is version {INTERFACE}")
        if loaded.estimates not in ESTIMATES:
            return Missing(name, f'its class states estimates = "{loaded.estimates}"; accepted: {", ".join(ESTIMATES)}')
    except Exception as error:  # whatever a foreign module does on import must not disable the other engines
        return Missing(name, f"it cannot be loaded ({type(error).__name__}: {first_line(error)})")
    return loaded


def _origin(entry: EntryPoint) -> str:
    return f"{entry.dist.name if entry.dist else 'unknown package'} ({entry.value})"


def _unknown(name: str) -> str:
    names = engine_names()
    near = difflib.get_close_matches(name, names, n=2)
    hint = f" (perhaps {' or '.join(near)} is meant)" if near else ""
    endings = ", ".join(f".{ending}" for ending in of_plugins("engine_files"))
    known = ", ".join(names) + (f", or the path of a file that declares one ({endings})" if endings else "")
    return f'"{name[:_LONGEST_NAME]}": no such engine{hint}; accepted: {known}'


class Missing(Engine[AnySettings]):
    """Stands in for an engine whose code cannot be loaded; `reason` says why."""

    method = "unknown"
    default_accuracy = 1e-3
    settings_type = AnySettings

    def __init__(self, name: str, reason: str) -> None:
        self.name, self.reason = name, reason

    def version(self) -> str:
        return "not available"

    def unavailable(self) -> str:
        return self.reason

    def _refuse(self, *arguments: Any) -> NoReturn:
        raise Refusal(f"engine {self.name} is not available: {self.reason}")

    check = describe = settings_for = comparisons = finer = prepare = natural_frequencies = cast(Any, _refuse)
