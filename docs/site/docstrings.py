"""What Sphinx needs to know of this project's docstrings and annotations."""

import re
from typing import Any

from docutils import nodes
from sphinx.addnodes import pending_xref
from sphinx.application import Sphinx
from sphinx.environment import BuildEnvironment
from sphinx.util.nodes import make_refnode

#: Long forms of types in signatures -> how numpy's own documentation writes them.
SHORT = (
    (re.compile(r"~?numpy\.ndarray\[tuple\[~?typing\.Any, \.\.\.\], ~?numpy\.dtype\[.*?\]\]"), "~numpy.ndarray"),
    (re.compile(r"<factory>"), "..."),
    (re.compile(r"~?numpy\._typing\._array_like\._Buffer \| .*?NestedSequence\[complex \| bytes \| str\]"), "~numpy.typing.ArrayLike"),
)


def keep_colons(app: Sphinx, what: str, name: str, value: object, options: object, lines: list[str]) -> None:
    """A property's first sentence may have a colon, before which napoleon would read a type; in a second line it does not look."""
    if what in ("property", "attribute"):
        lines.insert(0, "\\ ")


def shorten(app: Sphinx, what: str, name: str, value: object, options: object, signature: str | None, returned: str | None) -> Any:
    """Types of arrays by their short names."""
    for long, short in SHORT:
        signature, returned = (text and long.sub(short, text) for text in (signature, returned))
    return signature, returned


def resolve(app: Sphinx, env: BuildEnvironment, node: pending_xref, shown: nodes.Element) -> nodes.Element | None:
    """A class named alone, as annotations of names that are imported for the type checker are; None: the name is unknown or of several."""
    if node.get("refdomain") != "py":
        return None
    ending = "." + node["reftarget"].rpartition(".")[2]
    places = {(each.docname, each.node_id) for name, each in env.domains.python_domain.objects.items() if name.endswith(ending)}
    if len(places) != 1:
        return None
    ((page, anchor),) = places
    return make_refnode(app.builder, node["refdoc"], page, anchor, shown)


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the extension."""
    app.connect("autodoc-process-docstring", keep_colons, priority=400)  # napoleon: 500
    app.connect("autodoc-process-signature", shorten)
    app.connect("missing-reference", resolve)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
