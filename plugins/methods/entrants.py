"""What distinguishes the methods of the race: shapes, constraint, integrator and implementation; and pairs that differ in one of them."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import astuple, dataclass, replace
from itertools import combinations
from typing import Final

from quickreturn.plugins.methods.row import Row

DOP853, RADAU = "DOP853", "Radau IIA"
COMPILED: Final = "this project’s, compiled for this mechanism"
#: Order of the integrators: a tenth of the error takes 10^(1/order) times as many steps.
ORDERS: Final[Mapping[str, int]] = {DOP853: 8, RADAU: 5, "generalized-alpha": 2, "leapfrog": 2}
#: The factors, in the order of the fields of an `Entrant`.
FACTORS: Final = ("shapes", "constraint", "integrator", "implementation")


@dataclass(frozen=True)
class Entrant:
    """The four factors of a method."""

    shapes: str
    constraint: str
    integrator: str = DOP853
    implementation: str = COMPILED
    note: str = ""  # what the name does not tell

    @property
    def order(self) -> int | None:
        """The order of its integrator; None: it changes, or is unknown."""
        return ORDERS.get(self.integrator)

    @property
    def is_own(self) -> bool:
        """Whether it is code of this project, written for the one mechanism."""
        return self.implementation.startswith("this project’s")


_FIXED: Final = "clamped-free modes, which stay"
_ENTRANTS: Final[Mapping[str, Entrant]] = {
    "thesis": Entrant(
        "elements, second-order geometry", "eliminated", "LSODA", "this project’s, scipy’s loop", "one element is the thesis as published"
    ),
    "reference": Entrant("modes that follow the slider", "eliminated"),
    "fixed-shapes": Entrant(_FIXED, "eliminated", RADAU),
    "multiplier": Entrant(_FIXED, "multiplier", RADAU),
    "stiff-spring": Entrant(_FIXED, "stiff spring", RADAU, note="errors are good to some 30 %: steps of Radau IIA follow rounding"),
    "nodal-load": Entrant("elements", "force on two nodes, lever rule", RADAU),
    "moving-boundaries": Entrant("modes that follow the slider", "known place on a line", note="linear, at a prescribed speed"),
    "exudyn": Entrant("ANCF cable elements", "ALE joint", "generalized-alpha", "Exudyn", "Exudyn’s own joint, solver and time integration"),
    "mujoco": Entrant("links", "multiplier", "leapfrog", "MuJoCo’s dynamics", "our chain, multiplier and time loop on MuJoCo"),
}
#: Choice of an engine's setting -> the factor that it replaces.
_CHOICES: Final[Mapping[str, Mapping[str, str]]] = {
    "hermite": {"shapes": "elements"},
    "consistent": {"constraint": "multiplier"},
    "both linear": {"constraint": "force on two nodes, slider on the chords"},
    "sliding": {"constraint": "sliding joint"},
    "exact": {"shapes": "elements", "note": "exact geometry"},
    "implicit": {"integrator": RADAU},
    "explicit": {"integrator": DOP853},
}


def entrant(row: Row) -> Entrant:
    """The factors of a row's method; those of an engine of another package are unknown."""
    found = _ENTRANTS.get(row.engine, Entrant("unknown", "unknown", "unknown", "another package’s"))
    for choice in row.variant.split(", "):
        found = replace(found, **_CHOICES.get(choice, {}))
    return found


def pairs(rows: Sequence[Row]) -> Iterator[tuple[str, str, str]]:
    """The methods, each with one row, that differ in one factor alone: the factor, and the two methods in their order."""
    for one, other in combinations(rows, 2):
        both = zip(FACTORS, astuple(entrant(one)), astuple(entrant(other)), strict=False)
        if len(different := [factor for factor, *values in both if values[0] != values[1]]) == 1:
            yield different[0], one.method, other.method
