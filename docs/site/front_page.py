"""README is the front page; the table of contents, which a code host would not render, is added to it here."""

from pathlib import Path

from sphinx.application import Sphinx

CONTENTS = Path(__file__).with_name("contents.md")


def add_contents(app: Sphinx, page: str, source: list[str]) -> None:
    """Append the table of contents to the front page as it is read."""
    if page == app.config.root_doc:
        source[0] += "\n" + CONTENTS.read_text("utf-8")


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the extension."""
    app.connect("source-read", add_contents)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
