"""The frequency response of the machine at rest by the exact solutions of the beam's equation, EI w'''' + rhoA w s^2 = 0, in each span.

The equation has the solutions cos, sin and exp of beta x. Their weights, the crank's angle and the slider's force follow from the
conditions at P, slider and tip: there are no modes and no elements.
"""

import math

import numpy as np
from numpy.typing import NDArray

from quickreturn.reference_model.mechanism import Scene
from quickreturn.reference_model.rigid import rigid_motion

Response = NDArray[np.complex128]
#: Columns of the right side, and the result's.
INPUTS = ("torque", "tool_force", "base_torque")


class ExactBeam:
    """At one frequency; without damping of the beam against its base. The division of a follower alone is in its middle."""

    def __init__(self, scene: Scene, crank_angle: float, free: bool, hertz: float) -> None:
        self.scene, self.s, self.length = scene, 2j * math.pi * hertz, scene.follower.length
        self.stiffness = scene.follower.bending_stiffness * (1.0 + self.s * scene.follower.material_damping)
        self.beta = (-(self.s**2) * scene.follower.mass_per_length / self.stiffness) ** 0.25
        self.place, self.turn = self.length / 2.0, 1.0
        if scene.crank is not None:
            motion = rigid_motion(scene, np.array(crank_angle), 1.0)
            self.place, self.turn = float(motion.slider_position), float(motion.follower_speed)
        self.q1, self.force = np.eye(10)[8:]
        rows, right = self._conditions(free)
        scale = np.abs(rows).max(axis=0)
        self.weights = np.linalg.solve(rows / scale, right) / scale[:, None]

    def row(self, x: float, derivative: int, outboard: bool) -> Response:
        """A derivative of the deflection by the ten unknowns."""
        begin, end = (self.place, self.length) if outboard else (0.0, self.place)
        b, z, d = self.beta, x - begin, derivative
        row = np.zeros(10, complex)
        turned = b * z + d * math.pi / 2.0
        row[4 * outboard : 4 * outboard + 4] = np.cos(turned), np.sin(turned), (-1.0) ** d * np.exp(-b * z), np.exp(b * (x - end))
        return b**d * row

    def _conditions(self, free: bool) -> tuple[Response, Response]:
        scene, s, EI, at, L = self.scene, self.s, self.stiffness, self.place, self.length
        base, slope = scene.base, self.row(0.0, 1, False)
        of_base = EI * self.row(0.0, 2, False) - (base.inertia * s**2 + base.damping * s) * slope
        right = np.zeros((10, 3), complex)
        jumps = [self.row(at, order, True) - self.row(at, order, False) for order in range(4)]
        if scene.crank is None:
            support = [of_base if free else slope, self.force, self.q1, jumps[0]]
        else:
            drive = scene.crank.drive
            of_crank = (scene.crank_inertia * s**2 + drive.damping * s) * self.q1 + self.turn * at * self.force
            joint = scene.slider.closed_stiffness + s * scene.slider.joint_damping
            gap = self.turn * at * self.q1 - self.row(at, 0, False) - (self.force / joint)
            support = [of_base, of_crank if free else self.q1, gap, jumps[0]]
            right[2, 0] = 1.0 if free else 0.0
        right[1, 2] = -1.0 if scene.crank is not None or free else 0.0
        at_slider = [jumps[1], EI * jumps[2] - scene.slider.inertia * s**2 * self.row(at, 1, False), EI * jumps[3] - self.force]
        tip, w, turned = scene.tip_body, self.row(L, 0, True), self.row(L, 1, True)
        moved = tip.mass * s**2 * (w + tip.center_of_mass * turned)
        at_tip = [EI * self.row(L, 2, True) + tip.inertia * s**2 * turned + tip.center_of_mass * moved, EI * self.row(L, 3, True) - moved]
        right[9, 1] = -1.0
        return np.array([self.row(0.0, 0, False), *support, *at_slider, *at_tip]), right

    def __call__(self, column: str) -> Response:
        """Response of a column to each of `INPUTS`, shape (3,)."""
        L, follower, base, tip = self.length, self.scene.follower, self.row(0.0, 1, False), self.row(self.length, 0, True)
        known = {
            "tip_deflection": tip - L * base,
            "tip_acceleration": self.s**2 * tip,
            "follower_angle": base,
            "slider_force": self.force,
            "crank_speed": self.s * self.q1,
            "crank_torque": self.turn * self.place * self.force,
            "base_torque": -self.stiffness * self.row(0.0, 2, False),
        }
        bent = {f"strain_{number}": (x, follower.extreme_fibre) for number, x in enumerate(follower.strain_gauges, 1)}
        bent |= {f"moment_{number:02d}": (number / 12.0 * L, self.stiffness) for number in range(1, 12)}
        if column in bent:
            x, factor = bent[column]
            known[column] = factor * self.row(x, 2, x > self.place)
        return np.asarray(known[column] @ self.weights)
