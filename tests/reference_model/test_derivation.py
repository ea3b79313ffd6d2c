"""Derivations and the code that cites them belong together: no number without an equation, no equation that nothing implements."""

import re
from pathlib import Path

import pytest

from quickreturn import engines, reference_model
from quickreturn.plugins import methods

PACKAGE = Path(reference_model.__file__).parent
#: Models with a document of their own: their files cite that one, all others the main one.
METHODS = Path(methods.__file__).parent
OWN = (PACKAGE / "thesis", METHODS / "moving_boundaries")
ENGINES = Path(engines.__file__).parent
#: Closed forms of a document that tests alone use.
IN_TESTS = {PACKAGE: "rigid_loads.py", METHODS / "moving_boundaries": "multipliers.py"}
NUMBER = r"(\d+)\.(\d+)"
CITATION = re.compile(rf"(thesis,\s+)?[Ee]quations?\s+((?:{NUMBER}(?:,\s+|\s+and\s+|\s+to\s+)?)+)")
Equation = tuple[int, int]


def document(folder: Path) -> str:
    return (folder / "DERIVATION.md").read_text(encoding="utf-8")


def cited(text: str, within: set[Equation]) -> set[Equation]:
    """Equations cited as "equation 3.2", "equations 4.2 and 4.3" or "equations 4.2 to 4.6"; those that the thesis numbers do not count."""
    found: set[Equation] = set()
    for match in CITATION.finditer(re.sub(r"\s*\n\s*#?:?\s*", " ", text)):
        if match.group(1):
            continue
        for first, last in re.findall(r"(\d+\.\d+)(?:\s+to\s+(\d+\.\d+))?", match.group(2)):
            section, low = map(int, first.split("."))
            end, high = map(int, (last or first).split("."))
            found |= {e for e in within if (section, low) <= e <= (end, high)} | {(section, low), (end, high)}
    return found


def numbered(text: str) -> list[Equation]:
    return [(int(section), int(number)) for section, number in re.findall(rf"\\tag{{{NUMBER}}}", text)]


def files(folder: Path) -> list[Path]:
    """Those that cite the folder's document."""
    in_tests = [Path(__file__).with_name(IN_TESTS[folder])] if folder in IN_TESTS else []
    if folder in OWN:
        return [*sorted(folder.rglob("*.py")), *in_tests]
    product = sorted([*PACKAGE.rglob("*.py"), *ENGINES.rglob("*.py"), *METHODS.glob("rivals/*.py")])
    return [path for path in product if not set(OWN) & set(path.parents)] + in_tests


def everything_cited(folder: Path) -> set[Equation]:
    within = set(numbered(document(folder)))
    return set().union(*(cited(path.read_text(encoding="utf-8"), within) for path in files(folder)))


EACH = pytest.mark.parametrize("folder", [PACKAGE, *OWN], ids=["one beam", *(folder.name for folder in OWN)])


def test_citations_are_read_as_meant() -> None:
    within = {(3, 1), (3, 2), (4, 2), (4, 3), (4, 4), (4, 5)}
    assert cited("see (equations 4.2 to 4.4)", within) == {(4, 2), (4, 3), (4, 4)}
    assert cited("equations 1.1 and 3.1\n    # to 3.2", within) == {(1, 1), (3, 1), (3, 2)}
    assert cited("(thesis, equations 4.2 and 4.3)", within) == set()


@EACH
def test_every_cited_equation_exists(folder: Path) -> None:
    assert everything_cited(folder) - set(numbered(document(folder))) == set()


@EACH
def test_every_equation_is_cited(folder: Path) -> None:
    assert set(numbered(document(folder))) - everything_cited(folder) == set()


@EACH
def test_equations_are_numbered_in_order_and_once(folder: Path) -> None:
    numbers = numbered(document(folder))
    assert numbers == sorted(set(numbers))
    for section in {section for section, _ in numbers}:
        mine = [number for of, number in numbers if of == section]
        assert mine == list(range(1, 1 + len(mine)))


@EACH
def test_references_within_the_documents_exist(folder: Path) -> None:
    texts = [document(folder)] + ([(PACKAGE / "RIVALS.md").read_text(encoding="utf-8")] if folder == PACKAGE else [])
    found = {(int(section), int(number)) for text in texts for section, number in re.findall(rf"\({NUMBER}\)", text)}
    assert found - set(numbered(document(folder))) == set()
