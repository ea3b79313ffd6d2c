"""Engines that a call names, with their settings and recorded tables, checked before anything runs."""

import os
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING

from quickreturn.cases.case import Case
from quickreturn.cases.errors import as_written, shortened
from quickreturn.catalogue import several
from quickreturn.engines.base import AnyEngine, Engine
from quickreturn.engines.registry import MAIN, UnknownEngine, engine, is_foreign
from quickreturn.engines.scene import check_scene
from quickreturn.engines.settings import ANY_ENGINE, SettingError
from quickreturn.reference_model.mechanism import Scene

if TYPE_CHECKING:
    from quickreturn.cases.recorded import RecordedTable

AnyEngineOrTable = str | os.PathLike[str] | AnyEngine


def engine_given(engine: AnyEngineOrTable) -> str | AnyEngine:
    """The argument itself, a path as text. UnknownEngine: it is neither a name nor a path nor an engine."""
    if isinstance(engine, os.PathLike):
        return os.fspath(engine)
    if isinstance(engine, (str, Engine)):
        return engine
    if isinstance(engine, type):
        raise UnknownEngine(f"{engine.__name__}: this is a class; give an engine, {engine.__name__}()")
    raise UnknownEngine(f'{as_written(engine)}: no engine; give a name, such as "reference", or an engine')


def settings_of(settings: Mapping[str, Mapping[str, str]], names: Sequence[str]) -> dict[str, dict[str, str]]:
    """Settings by engine: those for `ANY_ENGINE`, overridden by its own. SettingError: there are some for an engine that does not run."""
    for name, texts in settings.items():
        if name != ANY_ENGINE and name not in names:
            key = next(iter(texts), "")
            raise SettingError(f"{name}.{shortened(key)}: engine {name} does not run here; those that do are {', '.join(names)}")
    return {name: {**settings.get(ANY_ENGINE, {}), **settings.get(name, {})} for name in names}


def check(name: str, scene: Scene, settings: Mapping[str, str]) -> None:
    """Check an engine before anything runs. Raises UnknownEngine, or Refusal or SettingError of one of this project's engines."""
    if is_foreign(name):  # it would load its library here
        return
    chosen = engine(name)
    chosen.settings_type().with_texts(dict(settings))
    check_scene(chosen, scene)


def check_settings(cases: Sequence[Case], settings: Mapping[str, Mapping[str, str]]) -> None:
    """Check settings before anything runs. SettingError: an engine does not have a setting, or does not accept its value."""
    for name, texts in settings.items():
        for case in cases if texts else ():
            chosen = engine(name)
            try:
                chosen.settings_for(chosen.default_accuracy, case.mechanism).with_texts(dict(texts))
            except SettingError as error:  # several engines may share the settings, and one of them may lack one
                raise SettingError(f"{error} (engine {name})" if len(settings) > 1 else str(error)) from error


def prepared(
    cases: Sequence[Case], engines: AnyEngineOrTable | Iterable[AnyEngineOrTable], settings: Mapping[str, Mapping[str, str]]
) -> "tuple[list[str], dict[str, dict[str, str]], dict[str, list[RecordedTable]]]":
    """Names of engines, settings of each as texts, and recorded tables by case, all checked.

    Args:
        cases: the cases on which the engines run.
        engines: with paths of recorded tables among them; the four main engines where no engine is among them.
        settings: see `settings_of`.

    Raises:
        UnknownEngine: there is no engine of this name, or another process could not find it.
        SettingError, CaseError: an invalid setting or table, or a case without a cycle, such as a follower alone.
    """
    from quickreturn.cases.recorded import is_table, tables_of  # a simulation needs none of it

    _ = [case.mechanism for case in cases]  # raises CaseError for a follower alone
    given = [engine_given(one) for one in several(engines)]
    paths = list(dict.fromkeys(one for one in given if isinstance(one, str) and is_table(one)))
    names = list(dict.fromkeys(one.name if isinstance(one, Engine) else one for one in given if one not in paths) or MAIN)
    for name in names:
        engine(name)
    texts = settings_of(settings, names)
    check_settings(cases, texts)
    return names, texts, tables_of(paths, [case.name for case in cases])
