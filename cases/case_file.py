"""Cases by name: of the library, or of a file that a person wrote."""

import math
import os
from collections.abc import Mapping
from dataclasses import replace
from numbers import Real

from cases.case import Case
from cases.errors import CaseError, as_written, nearest, path_shown
from cases.library import case_names, library_case, library_document
from cases.library.hard import IMPOSSIBLE
from cases.reading import case_of, misfit, parse_case
from cases.text_file import read_text


def load_case(name_or_path: str, overrides: Mapping[str, str] | None = None) -> Case:
    """The case of a library name or of a file.

    A name of the library wins over a file of the same name; write `./name` to mean the file.

    Args:
        name_or_path: e.g. "thesis-24" or "my/scene.toml".
        overrides: dotted key -> text as in the file, e.g. {"crank.length": "5 in"}; see `cases.document.Document.overridden_by`.

    Raises:
        CaseError: no such case, an unreadable file, or a mistake in the file or the overrides.
    """
    if name_or_path in case_names() or name_or_path in IMPOSSIBLE:
        case = library_case(name_or_path)
        if not overrides:
            return case
        changed = case_of(library_document(name_or_path).overridden_by(overrides))
        return replace(changed, notes=tuple(dict.fromkeys((*case.notes, *changed.notes))), source=case.source)
    if not (os.sep in name_or_path or name_or_path.endswith(".toml") or os.path.lexists(name_or_path)):
        shown = as_written(name_or_path)
        near = nearest(name_or_path, case_names())
        accepted = f"the nearest one is {near} (`quickreturn cases` lists all); or give a path"
        raise CaseError(shown, None, None, "no case of the library has this name", accepted)
    return parse_case(read_text(name_or_path), path_shown(name_or_path), overrides)


def with_times(case: Case, duration: float | None = None, output_step: float | None = None) -> Case:
    """The case with other simulation times in s.

    Raises:
        CaseError: not positive, or the duration no whole multiple of the output step.
    """
    for key, value in (("duration", duration), ("output_step", output_step)):
        number = isinstance(value, Real)
        if value is not None and not (number and 0.0 < value < math.inf):
            shown = f"{value:.6g}" if number else as_written(value)
            raise CaseError(case.name, key, shown, "is no positive time in seconds", "such as 2 or 0.001")
    new = replace(case, duration=duration or case.duration, output_step=output_step or case.output_step)
    if problem := misfit(new.duration, new.output_step):
        key, value = ("duration", duration) if duration else ("output_step", new.output_step)
        raise CaseError(case.name, key, f"{value:.9g}", *problem)
    return new
