"""Which cases and engines there are, and cases by name, by pattern, or as they are."""

import fnmatch
import glob
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, TypeVar

from cases.case import Case
from cases.case_file import load_case, with_times
from cases.errors import CaseError, as_written
from cases.library import CatalogueLine, case_names, catalogue

if TYPE_CHECKING:
    from engines.base import AnyEngine
    from quickreturn.questions import About

T = TypeVar("T")


class Listing(tuple[T, ...]):
    """Things that show themselves as a small table, one to a row."""

    columns: Mapping[str, Callable[[T], str]]

    @classmethod
    def of(cls, things: Iterable[T], **columns: Callable[[T], str]) -> "Listing[T]":
        """`columns`: head -> what a row has there."""
        found = cls(things)
        found.columns = columns
        return found

    def __repr__(self) -> str:
        from reports.output import table_text

        return table_text([[text(each) for text in self.columns.values()] for each in self], list(self.columns))


def case(name: str, overrides: Mapping[str, str] | None = None, *, duration: float | None = None, output_step: float | None = None) -> Case:
    """A case of the library or of a file.

    Args:
        name: e.g. "thesis-24" or "my/scene.toml".
        overrides: other values, as a case file has them, by dotted key: {"crank.length": "5 in"}.
        duration: s, where not that of the case.
        output_step: s, likewise.

    Raises:
        CaseError: no such case, or a mistake in the file or the overrides; the sentence names the nearest that is known.
    """
    return with_times(load_case(os.fspath(name), overrides), duration, output_step)


def cases(tag: str | None = None) -> Listing[CatalogueLine]:
    """The cases of the library, or those with a tag.

    Raises:
        CaseError: no case has this tag.
    """
    known = {each for line in catalogue() for each in line.tags}
    if tag is not None and tag not in known:
        raise CaseError(f"--tag {as_written(tag)}", None, None, "no case has this tag", f"accepted: {', '.join(sorted(known))}")
    return Listing.of(catalogue(tag), NAME=lambda line: line.name, TAGS=lambda line: ", ".join(line.tags), TITLE=lambda line: line.title)


def engines() -> "Listing[About]":
    """All engines: name, version, what their estimates are of, method, whether they can be used here or why not."""
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
    """The cases that a name with *, ? or [...] stands for: those of the library, or else files; any other name stands for itself.

    Raises:
        CaseError: nothing matches.
    """
    if not glob.has_magic(name) or os.path.lexists(name):
        return (name,)
    found = fnmatch.filter(case_names(), name) or sorted(path for path in glob.glob(name) if path.endswith(".toml"))
    if not found:
        raise CaseError(as_written(name), None, None, "no case of the library and no case file matches", "such as thesis-2* or my/*.toml")
    return found


def loaded(
    names: "str | Case | CatalogueLine | Iterable[str | Case | CatalogueLine]", overrides: Mapping[str, str] | None = None
) -> list[Case]:
    """Cases by names, patterns or as objects, one or several, each once.

    Raises:
        CaseError: see `case` and `matching`; or two different cases have one name, so that nobody could tell them apart in what comes out.
    """
    each = [names] if isinstance(names, (str, Case, CatalogueLine)) else list(names)
    wanted = [one.name if isinstance(one, CatalogueLine) else one for one in each]
    texts = dict.fromkeys(found for one in wanted if not isinstance(one, Case) for found in matching(one))
    chosen = [*(one for one in wanted if isinstance(one, Case)), *(load_case(text, overrides) for text in texts)]
    called = [one.name for one in chosen]
    for one in called:
        if called.count(one) > 1:
            raise CaseError(one, None, None, "two cases have this name", "give each a name of its own")
    return chosen


def apart(engines: "str | AnyEngine | Iterable[str | AnyEngine]") -> tuple[list[str], list[str]]:
    """Names of engines, and paths of recorded tables that stand among them; the four main engines where there are tables alone.

    Raises:
        UnknownEngine: there is none of this name; also of an engine that no other process could find.
    """
    from cases.recorded import is_table
    from engines.base import Engine
    from engines.registry import MAIN, engine

    each = [engines] if isinstance(engines, (str, Engine)) else list(engines)
    paths = list(dict.fromkeys(one for one in each if isinstance(one, str) and is_table(one)))
    names = [one.name if isinstance(one, Engine) else one for one in each if one not in paths]
    for name in names:
        engine(name)
    return list(dict.fromkeys(names or MAIN)), paths
