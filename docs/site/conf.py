"""The documentation site: `make docs` builds it with Sphinx, without a network, and every warning is an error.

Its source is the checkout itself: README, `docs/`, the derivations beside the code and the docstrings, as they are.
"""

import sys
from importlib.metadata import version as installed_version
from pathlib import Path

from sphinx.application import Sphinx

sys.path.insert(0, str(Path(__file__).parent))  # the extension beside this file

project = "quickreturn"
author = "The quickreturn developers"
copyright = "2026, the quickreturn developers"
version = release = installed_version("quickreturn")

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "extension"]
root_doc = "README"
include_patterns = [
    "README.md",
    "CHANGELOG.md",
    "CONTRIBUTING.md",
    "docs/*.md",
    "docs/site/*.md",
    "reference_model/*.md",
    "reference_model/*/DERIVATION.md",
    "plugins/*/*/DERIVATION.md",
    "engines/LADDERS.md",
    "pack/README.md",
    "pack/*/problem.md",
]
exclude_patterns = ["docs/site/contents.md", ".*", "build", "tests", "cases", "reports", "quickreturn", "examples"]

# Markdown as code hosts read it: dollars for formulas, anchors made of headings. `{rst}` blocks of the API page are the one thing more.
myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 4
myst_dmath_double_inline = True
myst_url_schemes = ["http", "https"]

# Docstrings: sections Args, Raises, Attributes; `name` in single backticks is code.
default_role = "code"
smartquotes = False  # examples are copied from docstrings
napoleon_google_docstring = True
napoleon_numpy_docstring = False
napoleon_use_ivar = True
autodoc_member_order = "bysource"
autodoc_typehints_format = "short"
autodoc_preserve_defaults = True
python_use_unqualified_type_names = True
python_maximum_signature_line_length = 88
add_module_names = False
nitpicky = True
# Signatures name types of other packages, and internals of this one that have no entry on the API page: neither is a broken reference.
nitpick_ignore_regex = [
    ("py:.*", r"(casadi|collections|matplotlib|numpy|os|pandas|pathlib|pd|types|xarray|xr)\..*"),
    ("py:.*", r"quickreturn\.(arguments|cases|derive|descriptions|engines|plugins|reference_model|reports)\..*"),
    ("py:.*", "(About|AnyEngine|AnyEngineOrTable|Document|Limits|Workshop)"),
]

suppress_warnings = ["misc.highlighting_failure"]  # blocks of CSV, which Pygments does not know

html_theme = "furo"
html_title = f"quickreturn {release}"
html_static_path = ["static"]
html_css_files = ["site.css"]
html_extra_path = ["static/index.html"]
html_copy_source = False
html_show_sphinx = False


def add_contents(app: Sphinx, page: str, source: list[str]) -> None:
    """Append the table of contents, which a code host would not render, to the front page as it is read."""
    if page == app.config.root_doc:
        source[0] += "\n" + Path(__file__).with_name("contents.md").read_text("utf-8")


def setup(app: Sphinx) -> None:
    """Have the front page completed."""
    app.connect("source-read", add_contents)
