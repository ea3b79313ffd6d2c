"""Parameters of a scene that are not known exactly, and the distributions that describe them, written as text with units."""

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from scipy import stats
from scipy.special import eval_hermitenorm, eval_legendre, factorial

from quickreturn.cases.files.errors import CaseError, as_written, nearest_or_all
from quickreturn.cases.files.keys import PATHS, PLUS_MINUS, si_value, toleranced
from quickreturn.cases.files.units import QuantityError, plain_number
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.mechanism import Mechanism
from quickreturn.reference_model.quantities import Quantity
from quickreturn.reference_model.scene_values import Value, values_of

_KEY: Final = re.compile(r"([a-z_.]+)(?:\[([1-9])\])?")
_EXAMPLES: Final = (
    'write such as "uniform 0 kg .. 1 kg", "log-uniform 1 kg .. 4 kg", "normal 2128 lbf*in^2 +- 4 %", or a tolerance, "2 in +- 0.1 in"'
)


@dataclass(frozen=True)
class Parameter:
    """A number of a scene by its key in a case file, such as `tip.mass`; for a vector with its index: `mechanism.gravity[2]`."""

    path: str  # dotted key
    place: int | None = None  # index in the vector, from 0; None for a single number

    @classmethod
    def of_key(cls, key: str, source: str) -> "Parameter":
        """The parameter of a key as written.

        Raises:
            CaseError: no such key; a missing or wrong index of a vector; a key without effect on the motion.
        """
        match = _KEY.fullmatch(key)
        if match is None or match[1] not in PATHS or match[1].startswith("simulation."):
            known = tuple(path for path in PATHS if not path.startswith("simulation."))
            raise CaseError(source, None, as_written(key), "is no quantity of a scene", nearest_or_all(key, known))
        quantity = PATHS[match[1]]
        if not quantity.moves:
            raise CaseError(source, match[1], None, "changes no motion", "give a quantity that the motion depends on")
        place = None if match[2] is None else int(match[2]) - 1
        if quantity.in_file or (place is None) != quantity.is_number or (place or 0) >= (quantity.count or 1):
            one = "tip.force_scale" if quantity.in_file else match[1]
            accepted = f"write {one}" if quantity.count is None else f"write {match[1]}[1] to {match[1]}[{quantity.count}]"
            raise CaseError(source, None, as_written(key), "names no single number", accepted)
        return cls(match[1], place)

    @property
    def key(self) -> str:
        """The key as it is written, with the index in a vector."""
        return self.path if self.place is None else f"{self.path}[{self.place + 1}]"

    @property
    def quantity(self) -> Quantity:
        """The quantity at this key."""
        return PATHS[self.path]

    def of(self, scene: Mechanism) -> float:
        """The parameter's value in a scene, SI; for an absent part the default, nan if there is none."""
        section, _, name = self.path.partition(".")
        value: Any = values_of(scene).get(section, {}).get(name)
        if value is None and section == "follower":
            value = getattr(scene.follower, name)  # of material and section, which a scene keeps as stiffness and mass
        value = self.quantity.default if value is None else value
        if value is None:
            return math.nan
        return float(value if self.place is None else value[self.place])


def changes(scene: Mechanism, values: Mapping[Parameter, float]) -> dict[str, Value]:
    """Changes of a scene by values (SI) of parameters; other components of a vector keep the scene's values."""
    changed: dict[str, Value] = {}
    for parameter, value in values.items():
        if parameter.place is None:
            changed[parameter.path] = float(value)
        else:
            parts = (Parameter(parameter.path, place) for place in range(parameter.quantity.count or 0))
            vector = changed.get(parameter.path) or tuple(part.of(scene) for part in parts)
            assert isinstance(vector, tuple)
            changed[parameter.path] = (*vector[: parameter.place], float(value), *vector[parameter.place + 1 :])
    return changed


@dataclass(frozen=True)
class Distribution:
    """The distribution of a parameter."""

    kind: str  # "uniform", "log-uniform" or "normal"
    first: float  # SI; lower end, or the mean
    second: float  # SI; upper end, or the standard deviation
    text: str  # as written

    @property
    def told(self) -> str:
        """The text, with the kind of distribution that a tolerance stands for."""
        return self.text if self.text.startswith(self.kind) else f"{self.kind} within {self.text}"

    def quantile(self, probability: Array) -> Array:
        """Quantiles for probabilities from 0 to 1, SI, shape as the argument."""
        if self.kind == "normal":
            return np.asarray(stats.norm(self.first, self.second).ppf(probability))
        if self.kind == "log-uniform":
            return np.asarray(stats.loguniform(self.first, self.second).ppf(probability))
        return np.asarray(self.first + (self.second - self.first) * probability)

    def polynomials(self, values: Array, degree: int) -> Array:
        """Orthonormal polynomials of the parameter at values (SI), shape (n,), up to a degree: shape (n, degree + 1).

        Hermite's for a normal distribution, Legendre's for others (D. Xiu, G. E. Karniadakis, SIAM Journal on Scientific Computing 24,
        2002, 619).
        """
        orders = np.arange(degree + 1)
        if self.kind == "normal":
            hermite = eval_hermitenorm(orders, ((values - self.first) / self.second)[:, None])
            return np.asarray(hermite / np.sqrt(factorial(orders)))
        ends = (math.log(self.first), math.log(self.second)) if self.kind == "log-uniform" else (self.first, self.second)
        place = np.log(values) if self.kind == "log-uniform" else values
        centred = (2.0 * place - ends[0] - ends[1]) / (ends[1] - ends[0])
        return np.asarray(eval_legendre(orders, centred[:, None]) * np.sqrt(2.0 * orders + 1.0))


def distribution(text: Any, parameter: Parameter, source: str) -> Distribution:
    """A distribution as written: `"uniform A .. B"`, `"log-uniform A .. B"`, `"normal M +- S"`, or a tolerance: `"M +- T"`.

    S, the standard deviation, may be a percentage of M, and so may T. Within a tolerance every value is equally likely: it is uniform.

    Raises:
        CaseError: none of these; ends in the wrong order; a value that the quantity cannot have.
    """

    def wrong(problem: str, accepted: str = _EXAMPLES) -> CaseError:
        return CaseError(source, parameter.key, as_written(text), problem, accepted)

    if isinstance(text, str) and plain_number(text.partition(" ")[0]) is not None and PLUS_MINUS in text:
        try:
            _, low, high = toleranced(parameter.path, text)
        except QuantityError as unreadable:
            raise wrong(unreadable.problem, unreadable.accepted) from None
        return Distribution("uniform", low, high, text)
    kind, _, rest = text.strip().partition(" ") if isinstance(text, str) else ("", "", "")
    between = {"uniform": "..", "log-uniform": "..", "normal": PLUS_MINUS}.get(kind)
    if between is None or rest.count(between) != 1:
        raise wrong("is no distribution")
    ends = [part.strip() for part in rest.split(between)]
    first = si_value(parameter.path, ends[0], source, finite=True)
    percent = plain_number(ends[1].removesuffix("%").strip()) if kind == "normal" and ends[1].endswith("%") else None
    second = si_value(parameter.path, ends[1], source, finite=True) if percent is None else abs(first) * percent / 100.0
    if kind == "normal" and not second > 0.0:
        raise wrong("has no positive standard deviation")
    if kind != "normal" and not first < second:
        raise wrong("does not rise", "write the lower end first")
    if kind == "log-uniform" and not first > 0.0:
        raise wrong("has an end that is not positive, and no logarithm", "both ends of a log-uniform distribution must be positive")
    return Distribution(kind, first, second, text)
