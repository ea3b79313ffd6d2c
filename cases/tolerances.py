"""Which deviations from the reference are accepted: read from `data/tolerances.toml`, where each has its reason."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any, Final, Literal, get_args

from cases.data import read_toml
from cases.errors import CaseError, as_written

Kind = Literal["ratio", "relative_difference"]
Half = Literal["pre", "post"]
Quantity = Literal["consensus_frequency", "first_mode_frequency", "minimum", "maximum"]

_SOURCE: Final = "tolerances.toml"
_OTHERS: Final = "others"
_KEYS: Final = frozenset({"case", "tag", "engines", "quantity", "channel", "half", "kind", "low", "high", "measure_uncertainty", "reason"})


@dataclass(frozen=True)
class Tolerance:
    """An accepted deviation from the reference.

    Attributes:
        quantity: which measure.
        channel: trajectory column, or None for each.
        half: "pre" or "post", or None for both.
        low: smallest accepted deviation.
        high: largest accepted deviation.
        kind: how the deviation is formed: engine / reference, or (engine - reference) / scale; the scale is the reference's value
            for a frequency, the channel's largest magnitude in the reference's cycle for an extreme.
        reason: why this much.
        measure_uncertainty: whether the claimed uncertainties of both measures, in quadrature, widen the band.
    """

    quantity: Quantity
    channel: str | None
    half: Half | None
    low: float
    high: float
    kind: Kind
    reason: str
    measure_uncertainty: bool = False

    def deviation(self, value: float, reference: float, scale: float) -> float:
        """The deviation of an engine's `value` from the reference's, of this tolerance's kind. `scale` > 0 as described."""
        return value / reference if self.kind == "ratio" else (value - reference) / scale

    def widened(self, uncertainty: float) -> "Tolerance":
        """The tolerance of a pair of measures whose ratio is uncertain by `uncertainty`, where that counts."""
        return replace(self, low=self.low - uncertainty, high=self.high + uncertainty) if self.measure_uncertainty else self

    def accepts(self, deviation: float) -> bool:
        """Whether a deviation lies within; NaN does not."""
        return self.low <= deviation <= self.high


def tolerances_for(case_name: str, tags: Iterable[str], engine: str, table: Mapping[str, Any] | None = None) -> list[Tolerance]:
    """The tolerances of an engine on a case; where several entries of the table fit, the most specific one.

    Args:
        case_name: the case.
        tags: its tags.
        engine: the engine's name.
        table: content of another tolerance file, for tests; default: the project's.

    Raises:
        CaseError: a mistake in the table.
    """
    entries = (read_toml(_SOURCE) if table is None else table)["tolerance"]
    for entry in entries:
        _check(entry)
    named = {name for entry in entries for name in entry["engines"]}
    key = engine if engine in named else _OTHERS
    chosen: dict[tuple[str, str | None, str | None], tuple[int, Tolerance]] = {}
    for entry in entries:
        rank = _rank(entry, case_name, frozenset(tags))
        if rank is None or key not in entry["engines"]:
            continue
        place = (entry["quantity"], entry.get("channel"), entry.get("half"))
        if place not in chosen or chosen[place][0] < rank:
            chosen[place] = (rank, _tolerance(entry))
    return [tolerance for _, tolerance in chosen.values()]


def _rank(entry: Mapping[str, Any], case_name: str, tags: frozenset[str]) -> int | None:
    """How specific an entry is for a case: 2 by name, 1 by tag, 0 for every case, None if it is for others."""
    if "case" in entry:
        return 2 if entry["case"] == case_name else None
    if "tag" in entry:
        return 1 if entry["tag"] in tags else None
    return 0


def _tolerance(entry: Mapping[str, Any]) -> Tolerance:
    return Tolerance(
        quantity=entry["quantity"],
        channel=entry.get("channel"),
        half=entry.get("half"),
        low=float(entry["low"]),
        high=float(entry["high"]),
        kind=entry["kind"],
        reason=entry["reason"],
        measure_uncertainty=bool(entry.get("measure_uncertainty", False)),
    )


def _check(entry: Mapping[str, Any]) -> None:
    where = f"tolerance of {entry.get('quantity', '?')}"
    missing = (_KEYS - {"case", "tag", "channel", "half", "measure_uncertainty"}) - set(entry)
    if missing or set(entry) - _KEYS:
        key = sorted(missing or set(entry) - _KEYS)[0]
        raise CaseError(
            _SOURCE, where, None, f'the key "{key}" is {"missing" if missing else "unknown"}', f"accepted are {', '.join(sorted(_KEYS))}"
        )
    for key, choices in (("kind", get_args(Kind)), ("quantity", get_args(Quantity)), ("half", get_args(Half))):
        if key in entry and entry[key] not in choices:
            raise CaseError(_SOURCE, f"{where}, {key}", as_written(entry[key]), "is unknown", f"accepted are {', '.join(choices)}")
    if not entry["low"] < entry["high"]:
        raise CaseError(_SOURCE, where, None, f"low = {entry['low']} is not below high = {entry['high']}")
    if not str(entry["reason"]).strip():
        raise CaseError(_SOURCE, where, None, "it has no reason", "each tolerance says why it is as wide as it is")
    if "case" in entry and "tag" in entry:
        raise CaseError(_SOURCE, where, None, "case and tag are both given", "give one of them, or neither for every case")
