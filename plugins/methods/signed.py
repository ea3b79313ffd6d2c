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

    def settings_for(self, mechanism: Mechanism) -> Settings:
        """The settings for a machine."""
        return engine(self.engine).settings_for(LEVELS[0], mechanism).with_texts(as_texts(self.settings))


def read_lines(path: Path = FILE) -> tuple[Line, ...]:
    """The lines of a file. CaseError: a mistake in it, in one sentence."""
    document, lines = toml_of(read_text(str(path), "a file of lines"), str(path)), list[Line]()
    given = document.get("line")
    if set(document) != {"line"} or not isinstance(given, list) or not all(isinstance(each, dict) for each in given):
        raise CaseError(str(path), None, None, f"has {', '.join(map(as_written, document)) or 'no line'}", _LINE)
    for number, settings in enumerate(given, 1):
        name, signed_by = (settings.pop(key, None) for key in ("engine", "signed_by"))
        if not (isinstance(name, str) and isinstance(signed_by, str) and signed_by.strip()):
            raise CaseError(str(path), f"line {number}", None, "lacks its engine, or who signs it", _LINE)
        try:
            engine(name).settings_type().with_texts(as_texts(settings))
        except (UnknownEngine, SettingError) as error:
            raise CaseError(str(path), f"line {number}", None, str(error)) from None
        lines.append(Line(name, signed_by, settings))
    return tuple(lines)
