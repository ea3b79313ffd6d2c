"""The explicit model with shapes that follow the slider: tables, equations, integration and observables under one roof."""

from dataclasses import dataclass, field

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray
from scipy.interpolate import CubicHermiteSpline
from scipy.optimize import brentq

from reference_model.equations import right_hand_side
from reference_model.integrate import Integration, integrate_dop853
from reference_model.mechanism import Mechanism
from reference_model.model import ObservationFailed
from reference_model.moving_observables import observe_moving
from reference_model.moving_parameters import S_RATE, MovingParameters, MovingWorkspace, moving_parameters, moving_workspace
from reference_model.observables import COLUMNS

Array = NDArray[np.float64]


@dataclass(frozen=True)
class MovingShapeModel:
    """The pseudo-coordinate model of a scene with the first `modes` modes of the beam supported at the slider.

    Args:
        mechanism: the scene; a flexible follower and a rigid slider joint.
        modes: number of modes, at least 1.
    """

    mechanism: Mechanism
    modes: int
    parameters: MovingParameters = field(init=False, repr=False)
    _workspace: MovingWorkspace = field(init=False, repr=False)
    _output_workspace: MovingWorkspace = field(init=False, repr=False)

    def __post_init__(self) -> None:
        parameters = moving_parameters(self.mechanism, self.modes)
        object.__setattr__(self, "parameters", parameters)
        object.__setattr__(self, "_workspace", moving_workspace(parameters.tables, self.modes))
        object.__setattr__(self, "_output_workspace", moving_workspace(parameters.tables, self.modes))

    @property
    def degrees_of_freedom(self) -> int:
        """Number of free speeds: the modes, and the crank unless its speed is prescribed."""
        return self.modes + (1 if self.mechanism.crank_is_free else 0)

    def straight_state(self, crank_angle: float, crank_speed: float) -> Array:
        """State vector (2 n + 5,) with the follower straight and moving as the rigid mechanism does."""
        n, p = self.modes, self.parameters
        y = np.zeros(2 * n + 5)
        y[0], y[n + 2] = crank_angle, crank_speed
        y[n + 1] = np.hypot(p.LA * np.cos(crank_angle) - p.d, p.LA * np.sin(crank_angle))
        return y

    def bent_state(
        self,
        crank_angle: float,
        crank_speed: float,
        slider: tuple[float, float],
        x: Array,
        angle: Array,
        angle_rate: Array,
    ) -> Array:
        """State vector (2 n + 5,) closest to a given shape.

        Args:
            crank_angle: rad.
            crank_speed: rad/s.
            slider: arc length (m) and its rate (m/s) that close the loop for the given shape.
            x: arc lengths, m, shape (k,).
            angle: tangent angle relative to the base there, rad, shape (k,).
            angle_rate: its rate at fixed arc length, rad/s, shape (k,).
        """
        n = self.modes
        y = self.straight_state(crank_angle, crank_speed)
        s, s_rate = slider
        psi, psi_s = self._shapes(s, x)
        eta = np.linalg.lstsq(psi, angle, rcond=None)[0]
        eta_rate = np.linalg.lstsq(psi, angle_rate - psi_s @ eta * s_rate, rcond=None)[0]
        y[1 : n + 1], y[n + 1], y[n + 3 : 2 * n + 3] = eta, s, eta_rate
        distance = np.hypot(self.parameters.LA * np.cos(crank_angle) - self.parameters.d, self.parameters.LA * np.sin(crank_angle))

        def excess(place: float) -> float:
            """The projected shape differs a little from the given one, and so does the place that closes its loop."""
            trial = y.copy()
            trial[n + 1] = place
            right_hand_side(self.parameters, self._workspace, trial, np.empty_like(trial))
            t = self.parameters.tables
            return float(np.hypot(self._workspace.z[t.G], self._workspace.z[2 * t.S + t.G])) - distance

        y[n + 1] = brentq(excess, 0.98 * s, min(1.02 * s, self.parameters.tables.high), xtol=1e-15)
        return y

    def _shapes(self, s: float, x: Array) -> tuple[Array, Array]:
        """psi_i and its derivative by s at arc lengths x (k,), with the tables' signs; each (k, n)."""
        t, n = self.parameters.tables, self.modes
        k = min(max(int((s - t.low) / t.step), 0), len(t.coefficients) - 1)
        powers = (s - t.low - k * t.step) ** np.arange(3, -1, -1)
        row = powers @ t.coefficients[k]
        pieces = ((s * t.u, 0, s, x <= s), (s + (self.parameters.L - s) * t.u, t.S, self.parameters.L, x > s))
        found = np.empty((2, len(x), n))
        for block in range(2):
            values = row[block * 2 * t.S * n : (block + 1) * 2 * t.S * n].reshape(n, 2 * t.S).T
            for places, first, end, inside in pieces:
                found[block, inside] = _through(np.append(places, end), values[first : first + t.G + 1], x[inside])
        return found[0], found[1]

    def can_move(self, y: Array) -> bool:
        """Whether the loop closes and the accelerations exist in the state `y`."""
        return bool(right_hand_side(self.parameters, self._workspace, y, np.empty_like(y)))

    def integrate(self, y: Array, output_step: float, intervals: int, tolerance: float, first_step: float = 0.0) -> Integration:
        """States on a uniform grid from the state `y`; see `reference_model.integrate`."""
        return integrate_dop853(self.parameters, self._workspace, y, output_step, intervals, tolerance, first_step)

    def observe(self, states: Array) -> dict[str, Array]:
        """Observables of states (k, 2 n + 5), by the names of `reference_model.observables.COLUMNS`, each of shape (k,).

        Raises:
            ObservationFailed: a state in which the loop cannot close.
        """
        out = np.zeros((len(states), len(COLUMNS)))
        rows = observe_moving(self.parameters, self._output_workspace, np.ascontiguousarray(states), out)
        if rows < len(states):
            raise ObservationFailed(rows)
        return dict(zip(COLUMNS, np.ascontiguousarray(out.T), strict=True))

    def deflection(self, y: Array) -> tuple[CubicHermiteSpline, CubicHermiteSpline]:
        """Deflection W(x) (m) and its rate (m/s) in the state `y`, as functions of arc length with derivatives."""
        n, s = self.modes, y[self.modes + 1]
        x = np.unique(np.concatenate([np.linspace(0.0, s, 121), np.linspace(s, self.parameters.L, 121)]))
        self.can_move(y)
        psi, psi_s = self._shapes(s, x)
        angle = psi @ y[1 : n + 1]
        rate = psi @ y[n + 3 : 2 * n + 3] + psi_s @ y[1 : n + 1] * self._workspace.facts[S_RATE]
        slope, slope_rate = np.sin(angle), np.cos(angle) * rate
        # cubic through the slopes, integrated: exact to the fourth power of the spacing (5 mm)
        place = CubicHermiteSpline(x, slope, np.gradient(slope, x)).antiderivative()(x)
        speed = CubicHermiteSpline(x, slope_rate, np.gradient(slope_rate, x)).antiderivative()(x)
        return CubicHermiteSpline(x, place, slope), CubicHermiteSpline(x, speed, slope_rate)


def _through(places: Array, values: Array, x: Array) -> Array:
    """The polynomial through `values` (m, n) at `places` (m,), at x (k,); shape (k, n)."""
    low, high = places[0], places[-1]
    scaled, at = (2.0 * (places - low) / (high - low) - 1.0), 2.0 * (x - low) / (high - low) - 1.0
    coefficients = np.linalg.solve(chebyshev.chebvander(scaled, len(places) - 1), values)
    return chebyshev.chebvander(at, len(places) - 1) @ coefficients
