"""Texts of numbers and names in the report."""

import math
from collections.abc import Mapping, Sequence
from typing import Any, Final

from quickreturn.cases.files.shown import Unit
from quickreturn.cases.files.units import in_si
from quickreturn.cases.library import ENTRIES

MINUS: Final = "−"
#: A space at which no line breaks.
TIED: Final = "\N{NO-BREAK SPACE}"
#: Least and greatest power of ten with which a number is written without an exponent.
LEAST, GREATEST = -3, 6
RAISED: Final = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
HALF: Final = {"pre": "pre-return", "post": "post-return"}
QUANTITY: Final = {
    "consensus_frequency": "first-mode frequency, consensus",
    "first_mode_frequency": "first-mode frequency",
    "first_mode_amplitude": "first-mode amplitude",
    "second_mode_frequency": "second-mode frequency",
    "minimum": "minimum",
    "maximum": "maximum",
    "waveform": "waveform, RMS",
    "largest_difference": "waveform, largest",
}

#: What an engine's error estimate covers (`engines.base.EstimateOf`): its name, and the remark beside the number.
ESTIMATE: Final = {
    "total": ("error estimate", ""),
    "integration": ("integration error", "model error not estimated, see `run`"),
    "unverified": ("error estimate", "estimate not verified"),
}


def number(value: float, form: str) -> str:
    """A number in the page: true minus sign, no negative zero, words for NaN and infinity, powers of ten in superscript."""
    if math.isnan(value):
        return "–"
    if math.isinf(value):
        return "∞" if value > 0 else f"{MINUS}∞"
    text = _without_exponent(format(value, form))
    if text[0] in "+-" and not any(digit in text for digit in "123456789"):
        text = text[1:]  # -0.00 and +0.00 are 0.00
    return text.replace("-", MINUS)


def _without_exponent(text: str) -> str:
    """1.2e+02 as 120, 1e-07 as 10⁻⁷, 1.4e-05 as 1.4·10⁻⁵; other texts as they are."""
    digits, mark, power = text.partition("e")
    if not mark:
        return text
    if LEAST <= int(power) <= GREATEST:
        decimals = max(0, len(digits.partition(".")[2]) - int(power))
        return format(float(text), f"{'+' if text.startswith('+') else ''}.{decimals}f")
    of_ten = f"10{str(int(power)).translate(RAISED)}"
    return f"{digits.removesuffix('1')}{of_ten}" if digits in ("1", "+1", "-1") else f"{digits}·{of_ten}"


def within_turn(degrees: float) -> float:
    """A crank angle within one turn, from 0 to 360 degrees: 451 is 91."""
    return degrees if 0.0 <= degrees <= 360.0 else degrees % 360.0


def angle_text(degrees: float) -> str:
    """A crank angle, in degrees, within one turn: "91°"."""
    return f"{number(within_turn(degrees), 'g')}°"


def settings_words(settings: Mapping[str, Any]) -> str:
    """Settings as "modes 5, tolerance 1e-7", with numbers as in a command."""
    texts = {name: f"{value:g}".replace("e-0", "e-") if isinstance(value, float) else str(value) for name, value in settings.items()}
    return ", ".join(f"{name.replace('_', ' ')} {text}" for name, text in texts.items())


def duration(seconds: float) -> str:
    """A time span to two figures, in ms below a second."""
    value, unit = (seconds / in_si("ms"), "ms") if seconds < 0.9995 else (seconds, "s")
    return f"{number(value, '.0f' if value >= 9.95 else '.1f' if value >= 0.995 else '.2f')}{TIED}{unit}"


def cost(value: float | None) -> str:
    """Seconds, or seconds per simulated second: with two decimals, below one with two significant figures."""
    return "–" if value is None else number(value, ".2g" if value < 1.0 else ".2f")


def times(factor: float) -> str:
    """A ratio: "3.4 times", "34 times"."""
    return f"{number(factor, '.0f' if factor >= 9.95 else '.1f')} times"


def percent(share: float, form: str = ".2f") -> str:
    """A fraction in percent."""
    return f"{number(100.0 * share, form)}{TIED}%"


def percents(low: float, high: float, form: str) -> str:
    """A range of fractions in percent."""
    return f"{span(100.0 * low, 100.0 * high, form)}{TIED}%"


def size(share: float) -> str:
    """A relative difference in percent, without its sign, to two figures."""
    value = abs(100.0 * share)
    return f"{number(value, '.0f' if value >= 10.0 else '.1f' if value >= 1.0 else '.2g')}{TIED}%"


#: Unit as the page writes it -> the same unit as `in_si` reads it, where they differ.
_READ: Final = {"": "1", "%": "percent", "10⁻⁶": "microstrain", "µε": "microstrain", "µs": "us", "°": "deg", "N m": "N*m", "m/s²": "m/s^2"}


def per_unit(unit: str) -> float:
    """Factor from SI units to a unit of the page: 1000 for "mm"."""
    return 1.0 / in_si(_READ.get(unit, unit))


def quantity(value: float, unit: Unit) -> str:
    """A number in SI units written in a unit, to four figures: "35.70 MPa"."""
    scaled = value / unit.size
    places = max(0, 3 - math.floor(math.log10(abs(scaled)))) if scaled else 0
    return f"{number(scaled, f'.{places}f' if places <= 6 else '.4g')}{TIED}{unit.sign}".removesuffix(f"{TIED}1").rstrip()


def off_by(error: float, value: float) -> str:
    """The relative error of a number: "± 0.2 %", or "off by less than 0.01 %"."""
    share = abs(error / value) if value else 0.0
    return f"±{TIED}{size(share)}" if share >= 1e-4 else f"off by less than 0.01{TIED}%"


def degrees(angle: float) -> str:
    """An angle in whole degrees from 0 to 359."""
    return f"{round(math.degrees(angle)) % 360}°"


def span(low: float, high: float, form: str) -> str:
    """A range of numbers: "2 to 3"."""
    return f"{number(low, form)} to {number(high, form)}"


def channel_name(column: str | None) -> str:
    """A trajectory column in words; None is the consensus of all."""
    return "all channels" if column is None else column.replace("_", " ")


def short_name(column: str) -> str:
    """A trajectory column in words that fit the head of a narrow column."""
    return {"tip_acceleration": "tip acc.", "tip_deflection": "deflection", "slider_force": "force"}.get(column, column.replace("_", " "))


def case_label(name: str) -> str:
    """The text "run 24" for a registered case of the library, the case's name otherwise."""
    entry = ENTRIES.get(name)
    return name if entry is None else f"run{TIED}{entry.number}"


def place(case: str, half: str, channel: str | None) -> str:
    """The origin of a number: "run 24, pre-return, strain 2"."""
    return f"{case_label(case)}, {HALF[half]}, {channel_name(channel)}"


def listed(words: Sequence[str], last: str = "and") -> str:
    """Words as "a, b and c"; "none" if there are none."""
    if len(words) < 2:
        return words[0] if words else "none"
    return f"{', '.join(words[:-1])} {last} {words[-1]}"


def won(counts: Mapping[str, int]) -> str:
    """Winners and how often each wins: "a in 3, b in 1"; "" if there are none."""
    return ", ".join(f"{name} in {count}" for name, count in counts.items())


def counted(count: int, one: str, many: str = "") -> str:
    """A number with its noun: "1 case", "3 cases"."""
    return f"{count}{TIED}{one if count == 1 else many or one + 's'}"


_NUMBERS: Final = ("no", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten", "eleven", "twelve")


def in_words(count: int) -> str:
    """A small number as a word."""
    return _NUMBERS[count] if 0 <= count < len(_NUMBERS) else str(count)
