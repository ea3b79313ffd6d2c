"""Reads a text file that the user names, and the TOML in it, or says in one sentence why it cannot be read."""

import codecs
import contextlib
import io
import json
import os
import re
import stat
import tomllib
from collections.abc import Sequence
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from quickreturn.cases.files.errors import CaseError, as_written, path_shown, similar_name

if TYPE_CHECKING:
    import pandas as pd

#: Endings of files of columns that are no text tables: what pandas and xarray write.
OF_COLUMNS: Final = (".parquet", ".nc", ".json")
#: Largest number of entries of a folder that are searched; a user's own folder has fewer.
_MOST_ENTRIES: Final = 10_000


def read_text(
    path: str, what: str = "a case file or the name of a library case", largest: int = 64_000, library: Sequence[str] = ()
) -> str:
    """The text of a file, without byte order mark and with plain line ends.

    Args:
        path: of the file.
        what: kind of file, for messages.
        largest: size in bytes.
        library: names of the library; one of them may be meant.

    Raises:
        CaseError: the file is missing, not a regular file, unreadable, too large or not in UTF-8.
    """
    content = _content(path, what, largest, library)
    try:
        return content.decode("utf-8-sig").replace("\r\n", "\n")
    except UnicodeDecodeError as wrong:
        line = content.count(b"\n", 0, wrong.start) + 1
        raise CaseError(path_shown(path), None, None, f"is not in UTF-8 (line {line})", "save it as plain text in UTF-8") from None


def read_table_text(path: str, what: str, largest: int) -> str:
    """The text of a table of any program: in UTF-8, UTF-16 with its byte order mark, or Windows-1252. CaseError: as of `read_text`.

    A file of columns (`OF_COLUMNS`) is given as the text of a CSV table with all digits.
    """
    content = _content(path, what, largest)
    if (ending := Path(path).suffix.lower()) in OF_COLUMNS:
        try:
            return str(_frame(io.BytesIO(content), ending).to_csv(index=False))
        except ImportError as missing:
            raise CaseError(path_shown(path), None, None, f"cannot be read ({missing})", "install quickreturn[tables]") from None
        except Exception as wrong:  # of any of the libraries
            problem = f"is no {ending} of columns ({str(wrong).partition(chr(10))[0]})"
            raise CaseError(path_shown(path), None, None, problem, "write the columns of one rate, time among them, to a file") from None
    is_wide = content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE))
    for encoding in ("utf-16",) if is_wide else ("utf-8-sig", "cp1252"):
        with contextlib.suppress(UnicodeDecodeError):
            text = content.decode(encoding)
            if "\0" not in text:
                return text
    raise CaseError(path_shown(path), None, None, "is no text, but a program's own binary form", "export it as plain text, such as CSV")


def _frame(file: io.BytesIO, ending: str) -> "pd.DataFrame":
    """The columns of a parquet file, a JSON document, or a netCDF file of one dimension, whose units come into the headings."""
    import pandas as pd

    if ending == ".parquet":
        frame = pd.read_parquet(file)
        return frame if frame.index.name is None else frame.reset_index()
    if ending == ".json":
        return pd.DataFrame(json.load(file))
    import xarray as xr

    with xr.open_dataset(file, engine="h5netcdf", decode_timedelta=False) as data:
        if len(data.sizes) != 1:
            raise ValueError(f"its dimensions are {', '.join(map(str, data.sizes))}")
        units = {name: f"{name} [{each.attrs['units']}]" for name, each in data.variables.items() if "units" in each.attrs}
        return data.to_dataframe().reset_index().rename(columns=units)


def _content(path: str, what: str, largest: int, library: Sequence[str] = ()) -> bytes:
    """The bytes of a file. CaseError: as of `read_text`, but for the encoding."""
    shown, instead = path_shown(path), f"give the path of {what}"
    try:
        if not stat.S_ISREG(os.stat(path).st_mode):  # opening a pipe would wait for ever
            raise CaseError(shown, None, None, "is no regular file", instead)
        with open(path, "rb") as file:
            content = file.read(largest + 1)
    except FileNotFoundError:
        known = similar_name(Path(path).stem, library)
        near = similar_file(path) or (known and f"the library case {known}")
        raise CaseError(shown, None, None, "there is no such file", f"did you mean {near}?" if near else instead) from None
    except (OSError, ValueError) as trouble:  # ValueError: a null character in the path
        reason = trouble.strerror if isinstance(trouble, OSError) else trouble
        raise CaseError(shown, None, None, f"cannot be read ({reason})", instead) from None
    if len(content) > largest:
        raise CaseError(shown, None, None, f"is larger than {largest // 1000} kB", instead)
    if content.startswith(b"PK\x03\x04"):
        raise CaseError(shown, None, None, "is an Excel workbook or another archive", "save it as plain text in UTF-8, such as CSV")
    return content


def similar_file(path: str) -> str:
    """The file in the same folder, with the same ending, whose name resembles that of a path most; "" if there is none."""
    folder, (stem, ending) = os.path.dirname(path), os.path.splitext(os.path.basename(path))
    try:
        with os.scandir(folder or ".") as entries:
            names = [entry.name for entry in islice(entries, _MOST_ENTRIES) if os.path.isfile(entry)]
    except (OSError, ValueError):  # no such folder
        return ""
    near = similar_name(stem, sorted(name.removesuffix(ending) for name in names if ending and name.endswith(ending)))
    return near and path_shown(os.path.join(folder, near + ending))


#: Lines are limited, because one long dotted key costs the TOML parser quadratic time and memory.
LONGEST_LINE: Final = 1_000
_ACCEPTED: Final = 'write [section] or key = "number unit", such as length = "4 in"'
#: The parser's message at the end of a text -> the quote that is not closed: the last one in the text.
_NEVER_CLOSED: Final = {"Unterminated string": '"""', 'Expected "\'"': "'", "Expected \"'''\"": "'''"}
_TYPOGRAPHIC: Final = re.compile(r"[“”„‟‘’‚‛«»]")


def toml_of(text: str, source: str) -> dict[str, Any]:
    """The content of a TOML text. CaseError, which names `source`: it is none, or has a line that is too long."""
    for number, line in enumerate(text.split("\n"), start=1):
        if len(line) > LONGEST_LINE:
            raise CaseError(source, None, None, f"line {number} has {len(line)} characters", f"at most {LONGEST_LINE} are accepted")
    try:
        return tomllib.loads(text)
    except RecursionError:
        raise CaseError(source, None, None, "is nested too deeply", "sections with strings and lists of strings are accepted") from None
    except ValueError as broken:
        raise broken_toml(source, text, str(broken)) from None


def broken_toml(source: str, text: str, complaint: str) -> CaseError:
    """The CaseError for a complaint of Python's parser, with its line.

    Args:
        source: name of the text in messages.
        text: text of the file.
        complaint: the parser's sentence, which ends in "(at line 3, column 7)" or "(at end of document)".
    """
    words, place = re.fullmatch(r"(.*?)(?: \(at (?:line (\d+), column \d+|end of document)\))?", complaint, re.DOTALL).groups()  # type: ignore[union-attr]
    number = int(place) if place else _line_of_the_end(text, words)
    line = text.split("\n")[number - 1].strip()
    key, value = f"line {number}", as_written(line)
    if re.match(r"Cannot (overwrite|declare|mutate)", words):
        return CaseError(source, key, value, "repeats an earlier key or section", "give each of them once")
    if _TYPOGRAPHIC.search(line):
        return CaseError(source, key, value, "is no valid TOML: it has typographic quotes", _ACCEPTED)
    return CaseError(source, key, value, f"is no valid TOML: {words[:1].lower()}{words[1:]}", _ACCEPTED)


def _line_of_the_end(text: str, words: str) -> int:
    """The line of the mistake in a text that ends too early: the line of an unclosed quote, otherwise the last line that is not blank."""
    place = text.rfind(_NEVER_CLOSED[words]) if words in _NEVER_CLOSED else -1
    return text.count("\n", 0, place if place >= 0 else len(text.rstrip())) + 1
