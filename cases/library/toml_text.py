"""Case files written from values, for cases that are generated instead of kept as files."""

from collections.abc import Mapping
from typing import Final

#: Section -> key -> text with unit, or list of such texts.
Sections = Mapping[str, Mapping[str, str | list[str]]]

_BETWEEN: Final = "\n\n"


def toml_text(header: Mapping[str, str | list[str]], sections: Sections) -> str:
    """A case file: name, title and tags, then the sections in their order. No text in it may need an escape."""
    blocks = [_lines(header), *(["[" + name + "]", *_lines(keys)] for name, keys in sections.items())]
    return _BETWEEN.join("\n".join(block) for block in blocks) + "\n"


def _lines(keys: Mapping[str, str | list[str]]) -> list[str]:
    return [f"{key} = {_toml(value)}" for key, value in keys.items()]


def _toml(value: str | list[str]) -> str:
    return f'"{value}"' if isinstance(value, str) else "[" + ", ".join(_toml(item) for item in value) + "]"
