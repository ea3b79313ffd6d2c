r"""What Sphinx needs to know of this project: its docstrings and annotations, and formulas as MathML.

Browsers typeset MathML themselves: no script, no network, and text that can be copied. The numbers of equations (`\tag{5.12}`) become
labels of their own, which links can name: `#equation-5.12`.
"""

import re
from html import escape
from pathlib import Path
from typing import Any

import ziamath
from docutils import nodes
from latex2mathml.converter import convert
from sphinx.application import Sphinx
from sphinx.util.fileutil import copy_asset_file
from sphinx.writers.html5 import HTML5Translator

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


#: STIX Two Math, which comes with ziamath (SIL Open Font License): many machines have no font for formulas.
FONT = Path(ziamath.__file__).parent / "fonts/STIXTwoMath-Regular.ttf"
TAG = re.compile(r"\\tag\{([^}]*)\}")
#: Primes with a power behind them, outside of `\text`.
PRIMES = re.compile(r"\\text\{[^}]*\}|('+)(?:\^(\{[^}]*\}|\\[A-Za-z]+|.))?")
#: What the converter does not know -> what says the same.
SAME = (("{aligned}", "{align*}"), (r"\arg", r"\operatorname{arg}"))
#: What it leaves where it does not know a command, an environment or the end of a row.
LEFT = re.compile(r"\\[A-Za-z]+|<mi>&</mi>|linebreak")


def one_superscript(found: re.Match[str]) -> str:
    """`''^2` as one superscript, which the converter refuses or nests."""
    return "^{" + r"\prime " * len(found[1]) + (found[2] or "") + "}" if found[1] else found[0]


def mathml(formula: str, display: str) -> str:
    """A formula of LaTeX as an element `math`; ValueError: the converter does not know all of it."""
    for ours, known in SAME:
        formula = formula.replace(ours, known)
    found = convert(PRIMES.sub(one_superscript, formula), display=display)
    if left := LEFT.findall(found):
        raise ValueError(f"no MathML for {', '.join(sorted(set(left)))} in {formula!r}")
    return found


def inline(translator: HTML5Translator, node: nodes.math) -> None:
    """Write a formula within a sentence."""
    translator.body.append(mathml(node.astext(), "inline"))
    raise nodes.SkipNode


def displayed(translator: HTML5Translator, node: nodes.math_block) -> None:
    """Write a formula on a line of its own, with its number."""
    text = node.astext()
    number = TAG.search(text)
    label = f'<span class="number">({escape(number[1])})</span>' if number else ""
    anchor = f' id="equation-{escape(number[1])}"' if number else ""
    translator.body.append(f'<div class="formula"{anchor}>{mathml(TAG.sub("", text), "block")}{label}</div>\n')
    raise nodes.SkipNode


def copy_font(app: Sphinx) -> None:
    """The font goes beside the site's style sheet."""
    copy_asset_file(FONT, app.outdir / "_static")


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the extension."""
    app.connect("autodoc-process-docstring", keep_colons, priority=400)  # napoleon: 500
    app.connect("autodoc-process-signature", shorten)
    app.add_html_math_renderer("mathml", (inline, None), (displayed, None))
    app.config.html_math_renderer = "mathml"
    app.connect("build-finished", lambda app, error: None if error else copy_font(app))
    return {"parallel_read_safe": True, "parallel_write_safe": True}
