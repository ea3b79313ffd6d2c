"""Lines that somebody chose: settings of an engine with the name of who stands for them. Anybody's line enters the race by such a file.

The file `SIGNED.toml` beside this module has this project's lines. A file of one's own is written alike:

    [[line]]
    engine = "exudyn"
    signed_by = "N. N., author of the package"
    elements = 12
    step = 5e-4

All other keys are settings of the engine; those that are left out are what the engine takes for an error of 1 %.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

from quickreturn.cases.files.errors import CaseError, as_written
from quickreturn.cases.files.text_file import read_text, toml_of
from quickreturn.engines.registry import UnknownEngine, engine
from quickreturn.engines.settings import SettingError, Settings, as_texts
from quickreturn.plugins.methods.row import LEVELS
from quickreturn.reference_model.mechanism import Mechanism

#: This project's lines.
FILE: Final = Path(__file__).with_name("SIGNED.toml")
_LINE: Final = 'give [[line]] with engine = "NAME", signed_by = "WHO", and settings of that engine'


@dataclass(frozen=True)
class Line:
    """Settings of an engine, and who signs them."""

    engine: str
    signed_by: str
    settings: Mapping[str, Any] = field(default_factory=dict)


def read_lines(path: Path = FILE) -> tuple[Line, ...]:
    """The lines of a file. CaseError: a mistake in it, in one sentence."""
    document = toml_of(read_text(str(path), "a file of lines"), str(path))
    given = document.get("line")
    if set(document) != {"line"} or not isinstance(given, list) or not all(isinstance(each, dict) for each in given):
        raise CaseError(str(path), None, None, f"has {', '.join(map(as_written, document)) or 'no line'}", _LINE)
    return tuple(_line(each, f"line {number}", str(path)) for number, each in enumerate(given, 1))


def _line(given: Mapping[str, Any], place: str, source: str) -> Line:
    name, signed_by = (given.get(key) for key in ("engine", "signed_by"))
    if not (isinstance(name, str) and isinstance(signed_by, str) and signed_by.strip()):
        raise CaseError(source, place, None, "lacks its engine, or who signs it", _LINE)
    settings = {key: value for key, value in given.items() if key not in ("engine", "signed_by")}
    try:
        engine(name).settings_type().with_texts(as_texts(settings))
    except (UnknownEngine, SettingError) as error:
        raise CaseError(source, place, None, str(error)) from None
    return Line(name, signed_by, settings)


def settings_for(line: Line, mechanism: Mechanism) -> Settings:
    """The settings of a line for a machine."""
    return engine(line.engine).settings_for(LEVELS[0], mechanism).with_texts(as_texts(line.settings))
