"""What takes long to prepare for the page is kept in the store, under a key made of everything that it is made from."""

from collections.abc import Callable, Mapping, Sequence
from functools import cache
from importlib import metadata
from typing import Any, Final

from cases.comparison import CaseResult
from cases.experiment import MeasuredCurve
from cases.fingerprint import code_fingerprint
from cases.store import Store, key_of

#: Everything in the project may leave its mark on a page.
PARTS: Final = ("reference_model", "engines", "cases", "reports")
LIBRARIES: Final = ("matplotlib", "pandas")


@cache
def page_code() -> str:
    """Fingerprint of the code and the libraries that make pages and pictures."""
    return key_of({"code": code_fingerprint(PARTS), "libraries": [f"{name} {metadata.version(name)}" for name in LIBRARIES]})


def page_key(kind: str, inputs: Mapping[str, Any]) -> str:
    """Key of a part of the page. Raises TypeError where the inputs have no canonical form (see `cases.store.key_of`)."""
    return key_of({"kind": f"page: {kind}", "inputs": inputs, "code": page_code()})


def kept(store: Store, kind: str, inputs: Mapping[str, Any], compute: Callable[[], dict[str, Any]]) -> dict[str, Any]:
    """A JSON document from the store, or computed and stored."""
    key = page_key(kind, inputs)
    entry = store.get(key)
    if entry is not None:
        return entry.document
    document = compute()
    store.put(key, document)
    return document


def content_of(result: CaseResult) -> dict[str, Any]:
    """All that a page can show of a case, in a form that a key can be made of."""
    return {
        "case": result.case,
        "runs": {name: {"document": run.document, "cycle": run.cycle} for name, run in result.runs.items()},
        "checks": [check.as_dict() for check in result.checks],
    }


def content_of_curves(curves: Sequence[MeasuredCurve]) -> list[dict[str, Any]]:
    """The same for measured curves."""
    return [{"values": curve.values, "angle": curve.crank_angle, "declared": dict(curve.declared)} for curve in curves]
