"""Mistakes that people make in case files and on command lines, made on purpose: one small generator for each kind."""

import random
from collections.abc import Iterator
from typing import NamedTuple

from quickreturn.cases.files.keys import PATHS, SECTIONS, dimension_of
from tests.cases.files.scene_texts import SCENE

Scene = dict[str, dict[str, str]]  # section -> key -> value as TOML text; the header is the section ""


class Mistake(NamedTuple):
    """A case file with one mistake, and words that the answer must hold: where it is, and what was given."""

    what: str
    text: str
    words: tuple[str, ...]


def scene() -> Scene:
    """A scene with every key, which every engine of these tests can model."""
    sections: Scene = {"": {}}
    for line in SCENE.replace('mass = "0.01 lbf*s^2/in"', 'mass = "0 kg"').splitlines():
        if line.startswith("["):
            sections[line.strip("[]")] = {}
        elif line:
            key, _, value = line.partition(" = ")
            sections[list(sections)[-1]][key] = value
    return sections


def written(sections: Scene) -> str:
    """The text of a case file."""
    parts = [
        (f"[{name}]\n" if name else "") + "".join(f"{key} = {value}\n" for key, value in keys.items()) for name, keys in sections.items()
    ]
    return "\n".join(parts)


def paths() -> list[str]:
    """Dotted paths of all quantities in the scene."""
    return [f"{section}.{key}" for section, keys in scene().items() if section for key in keys]


def with_value(path: str, value: str) -> str:
    """The case file with another value, given as TOML text, for one quantity; in a list it takes the last place."""
    section, _, key = path.partition(".")
    sections = scene()
    if PATHS[path].count:
        value = f"{sections[section][key].rpartition(',')[0]}, {value}]"
    sections[section][key] = value
    return written(sections)


#: Values that no quantity accepts, as TOML text: U is a unit of the right dimension, a tilde a blank.
NO_QUANTITIES = {
    "no string": r"4 -4.5 0 0x10 1_000 1e5 nan inf -inf true 2026-01-01 07:32:00 {} {a=1} [] [4] [['4~U']]",
    "a part missing": r""" "" "~" "U" "4" "4~" "." "+" "-" """,
    "white space": r""" "~4~U" "4~~U" "4U" "4~U~" "4\tU" "4\nU" "4\u00a0U" "4\u2009U" "4\u200bU" "4\u0000" "4\u0000U" """,
    "a comma": r""" "4,5~U" "1,000.5~U" "1.000,5~U" "1,000,000~U" "4,~U" ",5~U" """,
    "no plain number": r""" "1_000~U" "0x10~U" "4e~U" "e4~U" ".~U" "4..5~U" "4.5.6~U" "++4~U" "four~U" "'4'~U" "$4~U" "#4~U" "4'~U" """,
    "other signs and digits": r""" "٤~U" "４~U" "½~U" "4½~U" "−4~U" "±4~U" "≈4~U" "4±1~U" "Ⅳ~U" "∞~U" """,
    "arithmetic": r""" "2*2~U" "9**9**9~U" "1/4~U" "(4)~U" "2+2~U" "2^2~U" "sqrt(4)~U" "pi~U" "4~+~1~U" "4~1/2~U" """,
    "no finite number": r""" "nan~U" "NaN" "-nan~U" "inf~U" "-inf" "Infinity" "1e400~U" "-1e400~U" "1e999999999999~U" """,
    "out of range": r""" "1e-400~U" "5e-324~U" "1e-999999999999~U" "1e80~U" "-1e-70~U" """,
    "a broken unit": r""" "4~foo" "4~U*foo" "4~U^" "4~U*" "4~/U" "4~U**2**2" "4~U^0.5" "4~U^99999999" "4~(U)" "4~1/U" "4~U;" "4~%" """,
    "another dimension": r""" "4~U~U" "4~U*m^2" "4~U/s" "4~U*rad^2" "4~U/U" "4~degC" "4~dB" "4~K" "4~A" "4~mol" """,
    "an attack": r""" "\u001b[31m4~U" "4~\u202eU" "__import__('os')" "%s%n~U" "{0}~U" "$(ls)" "4~U`ls`" """,
}


def wrong_quantities(path: str) -> Iterator[Mistake]:
    """Every value of the list above in one place, overlong ones, and those of a wrong sign."""
    key, unit = PATHS[path], dimension_of(path).examples[0]
    values = [value.replace("~", " ").replace("U", unit) for values in NO_QUANTITIES.values() for value in values.split()]
    values += [f'"{digits} {unit}"' for digits in ("1" * 200, "0." + "0" * 90 + "1", "1" * 70)]
    values += [f'"-1 {unit}"'] * (key.sign != "any") + [f'"{zero} {unit}"' for zero in ("0", "-0.0", "0e5")] * (key.sign == "positive")
    for value in values:
        given = value[:50] if value.startswith('"') and value.isascii() and "\\" not in value else ""  # others are shown with escapes
        yield Mistake(f"{path} = {value[:80]}", with_value(path, value), (f": {path}: ", given))


def wrong_keys(path: str) -> Iterator[Mistake]:
    """One key misspelt, in the wrong place, twice, as a section, and left out."""
    section, _, key = path.partition(".")
    for misspelt in (key[:-1] + "_", key.upper(), key[1:], key + "s", key.replace("_", "-") + "-", f'"{key} "', f'"{key}\\u0000"'):
        sections = scene()
        sections[section] = {misspelt if each == key else each: value for each, value in sections[section].items()}
        yield Mistake(f"{path} as {misspelt}", written(sections), (f": {section}.",))
    for other in scene():
        if not other:
            continue
        sections = scene()
        value = sections[section].pop(key)
        if key not in SECTIONS[other]:
            sections[other][key] = value
            yield Mistake(f"{path} in {other}", written(sections), (f": {other}.{key}: ", " belongs to an unknown key", f".{key}"))
    text, line = written(scene()), f"{key} = {scene()[section][key]}\n"
    place = text.index(line, text.index(f"[{section}]"))
    for what, repeated in (("twice", f"{line}{line}"), ("as a section", f"{line}[{path}]\n")):
        yield Mistake(
            f"{path} {what}", text[:place] + repeated + text[place + len(line) :], (": line ", "repeats an earlier key or section")
        )
    if not PATHS[path].optional:
        yield Mistake(f"no {path}", text[:place] + text[place + len(line) :], (f": {path}: this key is missing",))


def rewritten(chance: random.Random) -> str:
    """The scene as somebody else may have written it: the same values in another order, layout, notation and unit."""
    sections = scene()
    names = [name for name in sections if name]
    chance.shuffle(names)
    lines = [f"{key} = {value}" for key, value in sections[""].items()]
    for name in names:
        lines += ["", chance.choice([f"[{name}]", f"  [ {name} ]   # the {name}", f'["{name}"]'])]
        for key in chance.sample(list(sections[name]), len(sections[name])):
            value = sections[name][key]
            if not PATHS[f"{name}.{key}"].count:
                value = _same_quantity(value.strip('"'), chance)
            lines.append(chance.choice([f"{key} = {value}", f"  {key}={value}  # a note", f"'{key}'\t=\t{value}"]))
    return chance.choice(["\n", "\r\n"]).join(lines) + chance.choice(["", "\n", "\n\n# the end"])


def _same_quantity(quantity: str, chance: random.Random) -> str:
    """The same decimal number and unit in another notation, as TOML text."""
    number, _, unit = quantity.partition(" ")
    mantissa, _, exponent = number.partition("e")
    whole, _, fraction = mantissa.partition(".")
    shifted = f"{whole}{fraction}e{int(exponent or 0) - len(fraction)}"
    sign = "" if number.startswith("-") else "+"
    number = chance.choice([number, shifted, shifted.upper(), f"{sign}{number}"])
    unit = chance.choice([unit, unit.replace("^", "**"), unit.replace("in", "inch"), f"{unit}*kg/kg"])
    return chance.choice([f'"{number} {unit}"', f"'{number} {unit}'", f'"""{number} {unit}"""'])
