"""Recognises common mistakes in a quantity, so that messages can name them: arithmetic, other characters, units as on paper."""

import re
from collections.abc import Iterator
from typing import Final

#: A plain decimal number.
NUMBER: Final = r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?"

#: Pattern -> the mistake, as a clause; "" if there is none before the unit. The first pattern that matches the beginning of a text counts.
_IN_QUANTITIES: Final = (
    (r"$", "is empty"),
    (r".{101}", "is longer than 100 characters"),
    (r"\s|.*\s$", "begins or ends with white space"),
    (rf"{NUMBER}$", "has no unit"),
    (rf"{NUMBER} \s", "has more than one space between number and unit"),
    (rf"{NUMBER} ", ""),
    (r"[+-]?\s*inf", "is infinite"),
    (r"[+-]?\s*nan", "is not a number"),
    (r"\S*[^\D0-9]", "has other digits than 0 to 9"),
    (r"[−–—]", 'has another minus sign than "-"'),
    (r"[+-]?[0-9.]*,[0-9]", "has a comma in its number (the decimal sign is a point)"),
    (r"[+-]?[0-9.]+[^\S ]", "has white space other than one plain space after its number"),
    (r"[(]?[+-]?[0-9.]+(?:e[+-]?[0-9]+)?[*/^+-]{1,2}[(]?[0-9]", "has arithmetic in its number (give the result)"),
    (r"0x|[+-]?[0-9.]+(?:_|e[^0-9+-]|e$)", "does not begin with a plain decimal number"),
    (r"[+-]?[0-9.]+(?:e[+-]?[0-9]+)?[^\W\d]|[+-]?[0-9.]+[°\"'′″%]", "has no space between number and unit"),
    (r"[+-]?[0-9.]", "does not begin with a plain decimal number and a space"),
    (r"", "does not begin with a number"),
)

#: How a unit may look on paper, and how it is written here.
_ON_PAPER: Final = (
    (r"\.$", ""),
    (r"\s*[·⋅×]\s*|\.|\s+", "*"),
    (r"(?<=[A-Za-z2-9])-(?=[A-Za-z])", "*"),
    (r"\blbm\b", "lb"),
    (r"(?<=[A-Za-z])([2-9])\b", r"^\1"),
    (r"²", "^2"),
    (r"³", "^3"),
    (r"⁴", "^4"),
    (r"°", "deg"),
    (r"[\"″]", "in"),
)

#: Names of units that are written as one word on paper: "Nms", "inlb", "kgm^2".
_JOINED: Final = re.compile(r"\b(?:[kMm]?N|kg|Pa|lbf|lb|ft|in|mm|cm|m|s){2,}(?=[\^*/]|$)")
_PART: Final = re.compile(r"[kMm]?N|kg|Pa|lbf|lb|ft|in|mm|cm|m|s")

#: Turns in a time as on paper, "1/min", "rev/min", "U/min" or "revolutions per minute"; the group is the time.
_TURNS_IN: Final = re.compile(r"(?:1|[ru]|tr|revs?|revolutions?|rot|rotations?)?\s*(?:/|\bper\b)\s*([a-z]+)", re.IGNORECASE)


def in_quantity(text: str) -> str:
    """The mistake in a quantity that is not one plain number, one space and a unit, as a clause; "" if there is none."""
    return next(problem for pattern, problem in _IN_QUANTITIES if re.match(pattern, text, re.IGNORECASE | re.DOTALL))


def frequency_meant(unit: str) -> str:
    """The unit without a counted noun: "1/min" and "rev/min" as "min^-1"; other units unchanged."""
    match = _TURNS_IN.fullmatch(unit)
    return f"{match[1].lower()}^-1" if match else unit


def units_meant(unit: str) -> Iterator[str]:
    """Unit expressions that may be meant by an invalid one; they may also be invalid."""
    plain = unit
    for on_paper, here in _ON_PAPER:
        plain = re.sub(on_paper, here, plain)
    apart = _JOINED.sub(lambda joined: "*".join(_PART.findall(joined[0])), plain)
    for meant in (plain, apart, plain.lower(), *(re.sub(r"\b(lb|pound)s?\b", "lbf", each) for each in (plain, apart))):
        if meant != unit:
            yield meant
