"""A linear model with named inputs, outputs and states: matrices, poles, frequency response, files."""

import io
import math
import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from quickreturn.cases.files.case import Case
from quickreturn.cases.files.errors import Argument, CaseError, as_written, nearest_or_all, texts_given
from quickreturn.cases.files.shown import Cell, Printable, Rows
from quickreturn.reference_model.arrays import Array
from quickreturn.reports.output import check_writable, write_file

if TYPE_CHECKING:
    import pandas as pd

    from quickreturn.reports.drawing.style import Drawing

ENDINGS: Final = (".npz", ".csv")
#: Points of a Bode plot.
POINTS: Final = 4000
#: Its lowest frequency over that of the lowest resonance, about the cycle over its highest.
BELOW: Final = 0.2
BELOW_HIGHEST: Final = 1e-3
#: Its highest frequency over that of the last mode. Up to there the responses of ten modes of run 24 are within 0.1 % RMS of those of 40.
UP_TO: Final = 0.7
#: Unit of the amplitude of a mass-normalised shape.
AMPLITUDE: Final = "kg^(1/2) m"


@dataclass(frozen=True, repr=False, eq=False)
class LinearModel(Printable):
    """dx/dt = A x + B u, y = C x + D u; all numbers are SI, and deviations from what the model is about.

    About the settled cycle A x + B u is the state a turn later, with the inputs constant over the turn.

    Attributes:
        case: the machine.
        about: what the motion is about, in words.
        A: shape (states, states).
        B: shape (states, inputs).
        C: shape (outputs, states).
        D: shape (outputs, inputs).
        states: name -> unit.
        inputs: name -> unit.
        outputs: name -> unit.
        crank_angle: about which the machine moves, rad; NaN for a follower alone.
        highest_frequency: up to which the model has modes, Hz; about the cycle half of the turns in a second.
        turn: duration of the settled cycle, s; 0 at rest.
    """

    case: Case
    about: str
    A: Array
    B: Array
    C: Array
    D: Array
    states: Mapping[str, str]
    inputs: Mapping[str, str]
    outputs: Mapping[str, str]
    crank_angle: float
    highest_frequency: float
    turn: float = 0.0

    @property
    def matrices(self) -> tuple[Array, Array, Array, Array]:
        """A, B, C and D, as `scipy.signal.StateSpace(*matrices)` and `control.ss(*matrices)` take them; add `turn` about the cycle."""
        return self.A, self.B, self.C, self.D

    @property
    def poles(self) -> NDArray[np.complex128]:
        """Eigenvalues of A, smallest modulus first: rad/s; about the cycle the Floquet multipliers."""
        return np.array(sorted(np.linalg.eigvals(self.A).astype(complex), key=lambda pole: (round(abs(pole), 6), pole.imag)))

    def response(self, frequencies: Array) -> NDArray[np.complex128]:
        """Frequency response, output over input in SI.

        Args:
            frequencies: Hz, shape (n,).

        Returns:
            Shape (n, outputs, inputs).
        """
        s = 2j * math.pi * np.asarray(frequencies, dtype=float)[:, None, None]
        shift = np.exp(s * self.turn) if self.turn else s
        return np.asarray(self.C @ np.linalg.solve(shift * np.eye(len(self.A)) - self.A, self.B.astype(complex)) + self.D)

    @property
    def frame(self) -> "pd.DataFrame":
        """A, B over C, D as one table: a row for the rate of each state and for each output, a column for each state and input."""
        import pandas as pd

        headings = [f"{name} [{unit}]" for name, unit in (*self.states.items(), *self.inputs.items())]
        of_states = [f"{name} a turn later" if self.turn else f"rate of {name}" for name in self.states]
        rows = [*of_states, *(f"{name} [{unit}]" for name, unit in self.outputs.items())]
        return pd.DataFrame(np.block([[self.A, self.B], [self.C, self.D]]), index=rows, columns=headings)

    def save(self, path: "str | os.PathLike[str]") -> None:
        """Write the model: `.npz` has the matrices with names and units as texts, `.csv` is `frame`. OutputError: it cannot be written."""
        check_writable(place := Path(path), "", *ENDINGS)
        write_file(place, self.content(place.suffix.lower()))

    def content(self, ending: str) -> bytes:
        """The content of a file with one of `ENDINGS`."""
        if ending == ".csv":
            return self.frame.to_csv(float_format="%.17g").encode()
        file, document = io.BytesIO(), self.document()
        for name in ("states", "inputs", "outputs"):
            named = document[name]
            document |= {name: [*named], f"units_of_{name}": [*named.values()]}
        np.savez(file, **document)
        return file.getvalue()

    def plot(self) -> "Drawing":
        """Draw the frequency response of each output to each input, up to the last mode; about the cycle up to half of the turns."""
        from quickreturn.plugins.linear.bode import bode

        low, high = BELOW_HIGHEST * self.highest_frequency, self.highest_frequency
        if not self.turn:
            lowest = min(self.poles.imag[self.poles.imag > 0.0], default=high) / (2.0 * math.pi)
            low, high = BELOW * lowest, max(UP_TO * high, 2.0 * lowest)
        frequencies, title = np.geomspace(low, high, POINTS), f"{self.case.name}: frequency response, {self.about}"
        return bode(frequencies, self.response(frequencies), self.inputs, self.outputs, self.case.units, title)

    def document(self) -> dict[str, Any]:
        """The JSON document."""
        about = {"case": self.case.name, "about": self.about, "crank_angle": self.crank_angle, "turn": self.turn}
        names = {name: dict(getattr(self, name)) for name in ("states", "inputs", "outputs")}
        matrices = {name: matrix.tolist() for name, matrix in zip("ABCD", self.matrices, strict=True)}
        return {**about, **names, "poles": [[pole.real, pole.imag] for pole in self.poles], **matrices}

    def _parts(self) -> Iterator[Cell]:
        named = (", ".join(f"{name} [{unit}]" for name, unit in each.items()) for each in (self.inputs, self.outputs))
        yield "{}, {}: {} states, inputs {}, outputs {}".format(self.case.name, self.about, len(self.states), *named)
        poles = [pole for pole in self.poles if pole.imag >= 0.0]
        rows: list[tuple[str, ...]] = [(f"{abs(pole):.4g}", f"{pole:.4g}") for pole in reversed(poles)]
        heads: tuple[str, ...] = ("multiplier", "complex")
        if not self.turn:
            ratios = [0.0 - pole.real / (abs(pole) or 1.0) for pole in poles]
            rows = [(f"{p.imag / (2.0 * math.pi):.6g}", f"{p.real:.4g}", f"{ratio:.3g}") for p, ratio in zip(poles, ratios, strict=True)]
            heads = ("damped frequency Hz", "real part 1/s", "damping ratio")
        yield Rows(rows, heads)


def chosen(what: str, given: str | Sequence[str], known: Mapping[str, str], about: str) -> dict[str, str]:
    """The names given as the argument `what`, with their units. CaseError: none is given, or one is unknown."""
    source = Argument(what)
    if not (names := texts_given(given, source, next(iter(known)))):
        raise CaseError(source, None, None, "none is given", f"known are {', '.join(known)}")
    for name in names:
        if name not in known:
            raise CaseError(source, None, as_written(name), f"is none {about}", nearest_or_all(name, tuple(known)))
    return {name: known[name] for name in names}


def named_states(modes: int, residuals: int = 0, angle: str = "", speed: str = "") -> dict[str, str]:
    """Name -> unit of the states: an angle, if there is one, and amplitudes of shapes; then their rates."""
    shapes = [*(f"mode_{number}" for number in range(1, modes + 1)), *(f"residual_{number}" for number in range(1, residuals + 1))]
    places, rates = dict.fromkeys(shapes, AMPLITUDE), {f"{name}_rate": f"{AMPLITUDE}/s" for name in shapes}
    return ({angle: "rad"} if angle else {}) | places | ({speed: "rad/s"} if speed else {}) | rates
