"""Settings of an engine: one frozen dataclass per engine, each field with its default, unit, range and meaning."""

import dataclasses
import math
from dataclasses import dataclass
from typing import Any, Self, get_type_hints


class SettingError(ValueError):
    """A setting that does not exist or lies outside its range; the text is one sentence."""


def setting(
    default: Any, meaning: str, *, unit: str = "", low: float = -math.inf, high: float = math.inf, choices: tuple[str, ...] = ()
) -> Any:
    """A field of a `Settings` class. `low` and `high` are the accepted range, both inclusive."""
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
                raise SettingError(f"engine.{name}: no such setting; accepted: {', '.join(known)}")
            changes[name] = _parse(name, text, hints[name])
        return self.replaced(**changes)

    def as_dict(self) -> dict[str, Any]:
        """Plain values by name, for results and reports."""
        return dataclasses.asdict(self)


def _parse(name: str, text: str, kind: type) -> Any:
    if kind is bool:
        if text not in ("true", "false"):
            raise SettingError(f'engine.{name}: "{text}" is not accepted; give true or false')
        return text == "true"
    if kind is str:
        return text
    try:
        return kind(text)
    except ValueError:
        wanted = "a whole number" if kind is int else "a plain number"
        raise SettingError(f'engine.{name}: "{text}" is not {wanted}') from None


def _check(field: dataclasses.Field[Any], kind: type, value: Any) -> None:
    meta = field.metadata
    if kind is float and isinstance(value, int) and not isinstance(value, bool):
        value = float(value)
    if not isinstance(value, kind) or (isinstance(value, bool) and kind is not bool):
        raise SettingError(f"engine.{field.name}: {value!r} is not of type {kind.__name__}")
    if meta["choices"] and value not in meta["choices"]:
        raise SettingError(f'engine.{field.name}: "{value}" is not accepted; choose one of {", ".join(meta["choices"])}')
    if isinstance(value, (int, float)) and not isinstance(value, bool) and not meta["low"] <= value <= meta["high"]:
        unit = f" {meta['unit']}" if meta["unit"] else ""
        raise SettingError(f"engine.{field.name}: {value!r}{unit} is outside {meta['low']:g} to {meta['high']:g}{unit}")
