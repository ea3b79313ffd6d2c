"""Lists of cases and engines, and cases by name, by pattern or as objects."""

import fnmatch
import glob
import os
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, TypeVar

from quickreturn.cases.case import Case
from quickreturn.cases.case_file import load_case, with_times
from quickreturn.cases.document import check_mapping
from quickreturn.cases.errors import CaseError, as_written
from quickreturn.cases.library import CatalogueLine, case_names, catalogue
from quickreturn.cases.shown import Cell, Rows, Shown

if TYPE_CHECKING:
    from quickreturn.cases.recorded import RecordedTable
    from quickreturn.engines.base import AnyEngine
    from quickreturn.questions import About

    AnyEngineOrTable = str | os.PathLike[str] | AnyEngine

T = TypeVar("T")
AnyCase = str | os.PathLike[str] | Case | CatalogueLine


class Listing(Shown, tuple[T, ...]):
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
    loaded = load_case(_name(name), check_mapping(overrides or {}), "overrides")
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


def list_engines() -> "Listing[About]":
    """All engines: name, version, what their error estimates cover, method, and whether they can be used on this machine or why not."""
    from quickreturn.questions import about_all

    return Listing.of(
        about_all(),
        NAME=lambda each: each.name,
        VERSION=lambda each: each.version or "-",
        ESTIMATES=lambda each: each.estimate,
        METHOD=lambda each: each.method,
        STATE=lambda each: "available" if each.available else f"not available: {each.reason}",
    )


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
    singles = [single for given in _several(names) for single in ([given] if isinstance(given, Case) else matching(_name(given)))]
    cases = [single if isinstance(single, Case) else load(single) for single in dict.fromkeys(singles)]
    if not cases:
        raise CaseError("cases", None, None, "none is given", 'give one, such as "thesis-24"')
    counts = Counter(case.name for case in cases)
    for name, count in counts.items():
        if count > 1:
            raise CaseError(name, None, None, "two cases have this name", "give each a name of its own: case.with_(..., name=...)")
    return cases


def _several(given: Any) -> list[Any]:
    """One item or several, as a list."""
    return [given] if isinstance(given, (str, os.PathLike, Case, CatalogueLine)) or not isinstance(given, Iterable) else list(given)


def engine_given(engine: "str | AnyEngine") -> "str | AnyEngine":
    """The argument itself. UnknownEngine: it is neither a name nor an engine."""
    from quickreturn.engines.base import Engine
    from quickreturn.engines.registry import UnknownEngine

    if isinstance(engine, (str, Engine)):
        return engine
    if isinstance(engine, type):
        raise UnknownEngine(f"{engine.__name__}: this is a class; give an engine, {engine.__name__}()")
    raise UnknownEngine(f'{as_written(engine)}: no engine; give a name, such as "reference", or an engine')


def prepared(
    cases: Sequence[Case], engines: "AnyEngineOrTable | Iterable[AnyEngineOrTable]", settings: Mapping[str, Mapping[str, str]]
) -> "tuple[list[str], dict[str, dict[str, str]], dict[str, list[RecordedTable]]]":
    """Names of engines, settings of each as texts, and recorded tables by case, all checked before anything runs.

    Args:
        cases: the cases on which the engines run.
        engines: with paths of recorded tables among them; the four main engines where no engine is among them.
        settings: see `questions.settings_of`.

    Raises:
        UnknownEngine: there is no engine of this name, or another process could not find it.
        SettingError, CaseError: an invalid setting or table, or a case without a cycle, such as a follower alone.
    """
    from quickreturn.cases.recorded import is_table, tables_of
    from quickreturn.engines.base import Engine
    from quickreturn.engines.registry import MAIN, engine
    from quickreturn.questions import check_settings, settings_of

    _ = [case.mechanism for case in cases]  # raises CaseError for a follower alone
    given = [os.fspath(one) if isinstance(one, os.PathLike) else engine_given(one) for one in _several(engines)]
    paths = list(dict.fromkeys(one for one in given if isinstance(one, str) and is_table(one)))
    names = list(dict.fromkeys(one.name if isinstance(one, Engine) else one for one in given if one not in paths) or MAIN)
    for name in names:
        engine(name)
    texts = settings_of(settings, names)
    check_settings(cases, texts)
    return names, texts, tables_of(paths, [case.name for case in cases])
