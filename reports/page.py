"""Chapters into one HTML page that needs nothing but itself."""

from collections.abc import Sequence

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from reports.pages.blocks import Chapter
from reports.tables.table import csv_text


def page(chapters: Sequence[Chapter], date: str) -> str:
    """The page: style and pictures inline, no script, no reference to anywhere but the CSV files beside it."""
    environment = Environment(
        loader=PackageLoader("reports"), autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    environment.filters["csv"] = csv_text
    style = Markup(environment.get_template("style.css").render())
    return environment.get_template("report.html").render(chapters=chapters, date=date, style=style)
