"""`--set KEY=VALUE` as typed: which of them change the case, and which the engine's settings."""

from collections.abc import Iterable

from cases.document import OVERRIDE
from cases.errors import CaseError, as_written

_ENGINE = "engine."


def split_overrides(texts: Iterable[str]) -> tuple[dict[str, str], dict[str, str]]:
    """Sort `KEY=VALUE` texts.

    Returns:
        (dotted key of the case -> text, name of the engine's setting without "engine." -> text).

    Raises:
        CaseError: no "=", an empty key or value, a key given twice.
    """
    of_case: dict[str, str] = {}
    of_engine: dict[str, str] = {}
    for text in texts:
        key, equals, value = text.partition("=")
        key, value = key.strip(), value.strip()
        if not equals or not key or not value:
            raise CaseError(
                OVERRIDE, None, None, f"{as_written(text)} is not KEY=VALUE", 'such as crank.length="5 in" or engine.elements=32'
            )
        home, name = (of_engine, key.removeprefix(_ENGINE)) if key.startswith(_ENGINE) else (of_case, key)
        if name in home:
            raise CaseError(OVERRIDE, key, as_written(value), "is a second value for this key", "each key can be set once")
        home[name] = value
    return of_case, of_engine
