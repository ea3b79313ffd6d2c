"""Settings of an engine: one frozen dataclass per engine, each field with its default, unit, range and meaning."""

import dataclasses
import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final, Self, get_type_hints

from quickreturn.reference_model.errors import ToldError

#: Stands for every engine that runs, in place of an engine's name among settings.
ANY_ENGINE: Final = "engine"
_LONGEST: Final = 60  # characters of a name or value that a message quotes, and of a number that is read
#: Plain numbers as text; what else Python reads as a number ("1_000", digits of other scripts, "nan") is probably a slip.
_NUMBERS: Final = {int: r"[+-]?[0-9]+", float: r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?"}


class SettingError(ToldError, ValueError):
    """A setting that does not exist or lies outside its range; the text is one sentence."""


def setting(
    default: Any, meaning: str, *, unit: str = "", low: float = -math.inf, high: float = math.inf, choices: tuple[str, ...] = ()
) -> Any:
    """A field of a `Settings` class. Values from `low` to `high`, both included, or those in `choices` are accepted."""
    return dataclasses.field(default=default, metadata={"meaning": meaning, "unit": unit, "low": low, "high": high, "choices": choices})


@dataclass(frozen=True, kw_only=True)
class Settings:
    """Base of all settings classes; checks every value against its field's type and range.

    Raises:
        SettingError: a value of the wrong type or out of range.
    """

    def __post_init__(self) -> None:
        hints = get_type_hints(type(self))
        for field in dataclasses.fields(self):
            _check(field, hints[field.name], getattr(self, field.name))

    def replaced(self, **changes: Any) -> Self:
        """A copy with some values changed."""
        return dataclasses.replace(self, **changes)

    def with_texts(self, texts: dict[str, str]) -> Self:
        """A copy with values given as text, as on the command line.

        Raises:
            SettingError: unknown name, unreadable or unacceptable value.
        """
        known = {field.name: field for field in dataclasses.fields(self)}
        hints = get_type_hints(type(self))
        changes: dict[str, Any] = {}
        for name, text in texts.items():
            if name not in known:
                accepted = ", ".join(f"engine.{setting_name}" for setting_name in known) or "none"
                raise SettingError(f"engine.{name[:_LONGEST]}: no such setting of this engine; accepted: {accepted}")
            changes[name] = _parse(known[name], text, hints[name])
        return self.replaced(**changes)

    def as_dict(self) -> dict[str, Any]:
        """Plain values by name, for results and reports."""
        return dataclasses.asdict(self)


def as_texts(values: Mapping[str, Any], called: str = "settings") -> dict[str, str]:
    """Values by name, as `Settings.as_dict` gives them, as texts that `Settings.with_texts` takes.

    Raises:
        SettingError: `values` is no dictionary; the message names it `called`.
    """
    if not isinstance(values, Mapping):
        raise SettingError(f'{called}: {values!r} is no dictionary by name, such as {{"tolerance": 1e-6}}')
    return {name.removeprefix("engine."): str(value).lower() if isinstance(value, bool) else str(value) for name, value in values.items()}


def _parse(field: dataclasses.Field[Any], text: str, kind: type) -> Any:
    """The value of a setting from its text. Raises SettingError: it is none of the setting's type."""
    if kind is str:
        return text
    if kind is bool and text in ("true", "false"):
        return text == "true"
    if kind in _NUMBERS and len(text) <= _LONGEST and re.fullmatch(_NUMBERS[kind], text):
        return kind(text)
    given = text if len(text) <= _LONGEST else f"{text[:_LONGEST]}..."
    number = f"{'a whole number' if kind is int else 'a plain number'} from {_range(field)}"
    raise SettingError(f'engine.{field.name}: "{given}" is not accepted; give {"true or false" if kind is bool else number}')


def _range(field: dataclasses.Field[Any]) -> str:
    unit = f" {field.metadata['unit']}" if field.metadata["unit"] else ""
    return f"{field.metadata['low']:g} to {field.metadata['high']:g}{unit}"


def _check(field: dataclasses.Field[Any], kind: type, value: Any) -> None:
    """Raise SettingError unless a value has the setting's type and is accepted."""
    meta = field.metadata
    if kind is float and isinstance(value, int) and not isinstance(value, bool):
        value = float(value)
    if not isinstance(value, kind) or (isinstance(value, bool) and kind is not bool):
        raise SettingError(f"engine.{field.name}: {value!r} is not of type {kind.__name__}")
    if meta["choices"] and value not in meta["choices"]:
        raise SettingError(f'engine.{field.name}: "{value}" is not accepted; choose one of {", ".join(meta["choices"])}')
    if isinstance(value, (int, float)) and not isinstance(value, bool) and not meta["low"] <= value <= meta["high"]:
        unit = f" {meta['unit']}" if meta["unit"] else ""
        raise SettingError(f"engine.{field.name}: {value!r}{unit} is outside {_range(field)}")
