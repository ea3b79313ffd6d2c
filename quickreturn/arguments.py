"""Arguments that public functions and commands share, checked before anything runs: cases, engines, settings, recorded tables."""

import fnmatch
import glob
import os
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, TypeVar

from quickreturn.cases.files.case import Case
from quickreturn.cases.files.document import check_mapping
from quickreturn.cases.files.errors import CaseError, as_written, shortened
from quickreturn.cases.files.shown import Cell, Printable, Rows
from quickreturn.cases.library import CatalogueLine, case_names, catalogue, load_case, with_times
from quickreturn.engines.accurate import check_scene
from quickreturn.engines.base import AnyEngine, Engine
from quickreturn.engines.registry import MAIN, UnknownEngine, engine, is_foreign
from quickreturn.engines.settings import ANY_ENGINE, SettingError, as_texts
from quickreturn.reference_model.mechanism import Scene

if TYPE_CHECKING:
    from quickreturn.cases.files.recorded import RecordedTable

T = TypeVar("T")
AnyCase = str | os.PathLike[str] | Case | CatalogueLine
AnyEngineOrTable = str | os.PathLike[str] | AnyEngine


class Listing(Printable, tuple[T, ...]):
    """A list that a terminal or notebook shows as a small table, one item to a row."""

    columns: Mapping[str, Callable[[T], str]]

    @classmethod
    def of(cls, things: Iterable[T], **columns: Callable[[T], str]) -> "Listing[T]":
        """A list of things; `columns`: heading -> function that gives a thing's text in that column."""
        listing = cls(things)
        listing.columns = columns
        return listing

    def _parts(self) -> Iterator[Cell]:
        yield Rows([[text(each) for text in self.columns.values()] for each in self], list(self.columns))


def case(
    name: str | os.PathLike[str] | CatalogueLine,
    overrides: Mapping[str, str] | None = None,
    *,
    duration: float | None = None,
    output_step: float | None = None,
) -> Case:
    """A case of the library or of a file.

    Args:
        name: e.g. "thesis-24" or "my/scene.toml".
        overrides: other values, as in a case file, by dotted key: {"crank.length": "5 in"}. The case keeps its name, as with `--set`, and
            its results are found under it; the title states the changes. `Case.with_` makes a copy with another name.
        duration: s; None: that of the case.
        output_step: s, the time between two rows of a result; None: that of the case.

    Raises:
        CaseError: no such case, or a mistake in the file or the overrides; the sentence names the nearest known name.
    """
    if isinstance(name, Case):
        raise CaseError(name.name, None, None, "this is a case already", "change it by its method with_")
    loaded = load_case(_name(name), check_mapping(overrides or {}))
    return with_times(loaded, duration, output_step)


def one_case(given: AnyCase) -> Case:
    """The case of a name or path; a `Case` is returned as it is. CaseError: there is none."""
    return given if isinstance(given, Case) else load_case(_name(given))


def _name(given: str | os.PathLike[str] | CatalogueLine) -> str:
    if isinstance(given, CatalogueLine):
        return given.name
    if isinstance(given, (str, os.PathLike)):
        return os.fspath(given)
    raise CaseError(as_written(given), None, None, "this is no case", 'give a name, such as "thesis-24", a path or a `Case`')


def list_cases(tag: str | None = None) -> Listing[CatalogueLine]:
    """The cases of the library, or those with a tag. CaseError: no case has this tag."""
    tags = {name for line in catalogue() for name in line.tags}
    if tag is not None and tag not in tags:
        raise CaseError(f"tag {as_written(tag)}", None, None, "no case has this tag", f"accepted: {', '.join(sorted(tags))}")
    return Listing.of(catalogue(tag), NAME=lambda line: line.name, TAGS=lambda line: ", ".join(line.tags), TITLE=lambda line: line.title)


def matching(name: str) -> Sequence[str]:
    """Cases of the library, or else files, that match a name with *, ? or [...] (CaseError: none does); any other name for itself."""
    if not glob.has_magic(name) or os.path.lexists(name):
        return (name,)
    matches = fnmatch.filter(case_names(), name) or sorted(path for path in glob.glob(name) if path.endswith(".toml"))
    if not matches:
        raise CaseError(as_written(name), None, None, "no case of the library and no case file matches", "such as thesis-2* or my/*.toml")
    return matches


def loaded(names: AnyCase | Iterable[AnyCase], load: Callable[[str], Case] = load_case) -> list[Case]:
    """Cases by names, patterns or as objects, one or several, without duplicates; `load` makes the case of a name.

    CaseError: see `load` and `matching`; none is given; or two have the same name, so that their results could not be distinguished.
    """
    singles = [single for given in several(names) for single in ([given] if isinstance(given, Case) else matching(_name(given)))]
    cases = [single if isinstance(single, Case) else load(single) for single in dict.fromkeys(singles)]
    if not cases:
        raise CaseError("cases", None, None, "none is given", 'give one, such as "thesis-24"')
    counts = Counter(case.name for case in cases)
    for name, count in counts.items():
        if count > 1:
            raise CaseError(name, None, None, "two cases have this name", "give each a name of its own: case.with_(..., name=...)")
    return cases


def several(given: Any) -> list[Any]:
    """One item or several, as a list."""
    return [given] if isinstance(given, (str, os.PathLike, Case, CatalogueLine)) or not isinstance(given, Iterable) else list(given)


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
    from quickreturn.cases.files.recorded import is_table, tables_of  # a simulation needs none of it

    _ = [case.mechanism for case in cases]  # raises CaseError for a follower alone
    given = [engine_given(one) for one in several(engines)]
    paths = list(dict.fromkeys(one for one in given if isinstance(one, str) and is_table(one)))
    names = list(dict.fromkeys(one.name if isinstance(one, Engine) else one for one in given if one not in paths) or MAIN)
    for name in names:
        engine(name)
    texts = settings_of(settings, names)
    check_settings(cases, texts)
    return names, texts, tables_of(paths, [case.name for case in cases])


def given_settings(settings: Mapping[str, Mapping[str, Any]] | None) -> dict[str, dict[str, str]]:
    """Settings by engine, as texts. SettingError: `settings` is not such a dictionary."""
    if not isinstance(settings or {}, Mapping):
        raise SettingError(f'settings: {settings!r} is no dictionary by engine, such as {{"mujoco": {{"links": 16}}}}')
    return {name: as_texts(values, f'settings["{name}"]') for name, values in (settings or {}).items()}
