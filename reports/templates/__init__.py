"""Templates of the report, its style and script, and the functions that write numbers in them."""

from functools import cache
from typing import Final

from jinja2 import ChoiceLoader, Environment, PackageLoader, StrictUndefined

from quickreturn.reports import words
from quickreturn.reports.tables.table import csv_text

#: Functions of `reports.words` that templates call.
WORDS: Final = ("number", "percent", "counted", "listed", "case_label")


@cache
def environment(packages: tuple[str, ...] = ()) -> Environment:
    """The Jinja environment of these templates and those of other packages; inserted values are plain text to a browser.

    Each template is compiled once in a process.
    A template of the page goes by its name in `templates`, any other one by its path in its package: `chapters/ID.html`.
    """
    loader = ChoiceLoader([PackageLoader("quickreturn.reports"), *(PackageLoader(each, "") for each in ("quickreturn.reports", *packages))])
    jinja = Environment(loader=loader, autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    jinja.globals |= {name: getattr(words, name) for name in WORDS}
    jinja.filters["csv"] = csv_text
    jinja.policies["json.dumps_kwargs"] = {"allow_nan": False, "separators": (",", ":")}
    return jinja
