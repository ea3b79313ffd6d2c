"""The derivation and the code that cites it belong together: no number without an equation, no equation that nothing implements."""

import re
from pathlib import Path

import pytest

import reference_model

PACKAGE = Path(reference_model.__file__).parent
DOCUMENT = (PACKAGE / "DERIVATION.md").read_text(encoding="utf-8")
NUMBER = r"(\d+)\.(\d+)"
CITATION = re.compile(rf"(thesis,\s+)?[Ee]quations?\s+((?:{NUMBER}(?:,\s+|\s+and\s+|\s+to\s+)?)+)")
Equation = tuple[int, int]


def cited(text: str) -> set[Equation]:
    """Equations cited as "equation 3.2", "equations 4.2 and 4.3" or "equations 4.2 to 4.6"; those of the thesis do not count."""
    found: set[Equation] = set()
    for match in CITATION.finditer(re.sub(r"\s*\n\s*#?\s*", " ", text)):
        if match.group(1):
            continue
        for first, last in re.findall(r"(\d+\.\d+)(?:\s+to\s+(\d+\.\d+))?", match.group(2)):
            section, low = map(int, first.split("."))
            end, high = map(int, (last or first).split("."))
            everything = defined(DOCUMENT)
            found |= {e for e in everything if (section, low) <= e <= (end, high)} | {(section, low), (end, high)}
    return found


def defined(text: str) -> set[Equation]:
    return {(int(section), int(number)) for section, number in re.findall(rf"\\tag{{{NUMBER}}}", text)}


def everything_cited() -> set[Equation]:
    return set().union(*(cited(path.read_text(encoding="utf-8")) for path in PACKAGE.glob("*.py")))


def test_citations_are_read_as_meant() -> None:
    assert cited("see (equations 4.2 to 4.4)") == {(4, 2), (4, 3), (4, 4)}
    assert cited("equations 1.1 and 3.1\n    # to 3.2") == {(1, 1), (3, 1), (3, 2)}
    assert cited("(thesis, equations 4.2 and 4.3)") == set()


def test_every_cited_equation_exists() -> None:
    assert everything_cited() - defined(DOCUMENT) == set()


def test_every_equation_is_cited() -> None:
    assert defined(DOCUMENT) - everything_cited() == set()


def test_equations_are_numbered_in_order_and_once() -> None:
    numbers = [(int(a), int(b)) for a, b in re.findall(rf"\\tag{{{NUMBER}}}", DOCUMENT)]
    assert numbers == sorted(set(numbers))
    for section in {a for a, _ in numbers}:
        assert [b for a, b in numbers if a == section] == list(range(1, 1 + max(b for a, b in numbers if a == section)))


@pytest.mark.parametrize("reference", sorted(set(re.findall(rf"\({NUMBER}\)", DOCUMENT))))
def test_references_within_the_document_exist(reference: tuple[str, str]) -> None:
    assert (int(reference[0]), int(reference[1])) in defined(DOCUMENT)
