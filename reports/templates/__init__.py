"""Templates of the report, its style and script, and the functions that write numbers in them."""

from collections.abc import Sequence
from typing import Final

from jinja2 import ChoiceLoader, Environment, PackageLoader, StrictUndefined

from quickreturn.reports import words

WORDS: Final = (
    "number", "percent", "percents", "size", "span", "times", "duration", "counted", "listed", "in_words", "case_label", "place",
    "channel_name", "HALF", "QUANTITY", "quantity", "off_by", "degrees",
)  # fmt: skip


def environment(escaped: bool = True, packages: Sequence[str] = ()) -> Environment:
    """The Jinja environment of these templates and those of other packages; `escaped`: inserted values are plain text to a browser.

    A template in a package's folder `templates` goes by its name there, any other one by its path in the package: `chapters/ID.html`.
    """
    folders = [PackageLoader(package, folder) for package in ("quickreturn.reports", *packages) for folder in ("templates", "")]
    loader = ChoiceLoader(folders)
    jinja = Environment(loader=loader, autoescape=escaped, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    jinja.globals |= {name: getattr(words, name) for name in WORDS}
    return jinja
