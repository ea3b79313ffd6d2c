from typing import Any

import pytest

from cases.data import read_toml
from cases.errors import CaseError
from cases.tolerances import tolerances_for

BASE: dict[str, Any] = {
    "engines": ["exudyn"],
    "quantity": "minimum",
    "kind": "relative_difference",
    "low": -0.02,
    "high": 0.02,
    "reason": "because",
}


def chosen(entries: list[dict[str, Any]], engine: str = "exudyn") -> list[float]:
    return sorted(tolerance.high for tolerance in tolerances_for("thesis-24", ("thesis",), engine, {"tolerance": entries}))


def test_the_thesis_is_judged_by_its_known_model_error() -> None:
    found = {tolerance.quantity: tolerance for tolerance in tolerances_for("thesis-10", ("thesis",), "thesis")}
    assert set(found) == {"consensus_frequency", "first_mode_frequency"}
    # frozen-crank frequencies of run 24 at 180 and 90 deg, one cubic against converged, lie inside; equal frequencies do not
    for cubic, converged in ((22.94, 20.354), (19.76, 17.779)):
        tolerance = found["consensus_frequency"]
        assert tolerance.accepts(tolerance.deviation(cubic, converged, converged))
    assert not tolerance.accepts(tolerance.deviation(20.0, 20.0, 20.0))
    assert tolerances_for("mine", (), "thesis") == []


@pytest.mark.parametrize("engine", ["exudyn", "mujoco", "somebodys_engine"])
@pytest.mark.parametrize("tags", [("thesis",), ()])
def test_every_other_engine_must_agree_with_the_reference(engine: str, tags: tuple[str, ...]) -> None:
    tolerances = tolerances_for("thesis-10", tags, engine)
    found = {tolerance.quantity: tolerance for tolerance in tolerances if tolerance.channel is None}
    # Exudyn's elements round off a kink at one gauge
    own = {(tolerance.quantity, tolerance.channel, tolerance.high) for tolerance in tolerances if tolerance.channel}
    assert own == ({("minimum", "strain_3", 0.03), ("maximum", "strain_3", 0.03)} if engine == "exudyn" else set())
    assert {quantity: tolerance.high for quantity, tolerance in found.items()} == {
        "consensus_frequency": 0.01,
        "first_mode_frequency": 0.01,
        "minimum": 0.02,
        "maximum": 0.02,
    }
    minimum = found["minimum"]
    assert minimum.accepts(minimum.deviation(-101.0, -100.0, 110.0))
    assert not minimum.accepts(minimum.deviation(-103.0, -100.0, 110.0))
    assert not minimum.accepts(float("nan"))


def test_the_most_specific_entry_wins() -> None:
    of_all, of_tag, of_case = BASE | {"high": 0.1}, BASE | {"high": 0.2, "tag": "thesis"}, BASE | {"high": 0.3, "case": "thesis-24"}
    assert chosen([of_all, of_tag, of_case]) == chosen([of_case, of_tag, of_all]) == [0.3]
    assert chosen([of_tag, of_all]) == [0.2]
    assert chosen([of_all, BASE | {"high": 0.5, "case": "thesis-23"}]) == [0.1]
    assert chosen([of_all, of_tag | {"half": "post"}]) == [0.1, 0.2]
    assert chosen([of_all], engine="mujoco") == []
    assert chosen([of_all, BASE | {"engines": ["others"], "high": 0.7}], engine="mujoco") == [0.7]


def test_every_tolerance_has_a_reason() -> None:
    assert all(len(entry["reason"].split()) >= 4 for entry in read_toml("tolerances.toml")["tolerance"])


@pytest.mark.parametrize(
    ("entry", "told"),
    [
        (BASE | {"reason": " "}, "it has no reason"),
        (BASE | {"low": 0.02}, "low = 0.02 is not below high = 0.02"),
        (BASE | {"kind": "absolute"}, '"absolute" is unknown; accepted are ratio, relative_difference'),
        (BASE | {"quantity": "phase"}, '"phase" is unknown; accepted are consensus_frequency'),
        (BASE | {"halves": "pre"}, 'the key "halves" is unknown'),
        ({key: value for key, value in BASE.items() if key != "low"}, 'the key "low" is missing'),
        (BASE | {"case": "a", "tag": "b"}, "case and tag are both given"),
    ],
)
def test_a_mistake_in_the_table_is_told(entry: dict[str, Any], told: str) -> None:
    with pytest.raises(CaseError) as refused:
        chosen([entry])
    assert told in str(refused.value)
