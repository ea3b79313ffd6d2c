"""The problems by equations written down by hand, closed forms where there are some, and the bead in MuJoCo."""

import mujoco
import numpy as np
from scipy.integrate import solve_bvp, solve_ivp
from scipy.optimize import brentq

from quickreturn.plugins.pack.values import BEAD, BRIDGE, DECAY, FOUR_BAR, SAG, Columns, G, times
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.shapes import clamped_free_modes


def sag(rows: int) -> Columns:
    """The elastica: EI psi'' = part of (F + w (L - s)) cos psi, psi(0) = 0, psi'(L) = 0, psi being the tangent's angle."""
    length, found, s = SAG.length, [], np.linspace(0.0, SAG.length, 41)
    guess = np.zeros((4, len(s)))  # psi, its slope, x, y
    for part in times(1.0, rows):

        def slopes(s: Array, z: Array, part: float = part) -> Array:
            moment = part * (SAG.force + SAG.mass * G * (length - s)) / SAG.bending * np.cos(z[0])
            return np.array([z[1], moment, np.cos(z[0]), np.sin(z[0])])

        def ends(begin: Array, end: Array) -> Array:
            return np.array([begin[0], begin[2], begin[3], end[1]])

        solution = solve_bvp(slopes, ends, s, guess, tol=1e-10, max_nodes=10_000)
        guess = solution.sol(s)
        found.append([*solution.sol(length)[[2, 3, 0]], solution.sol(length / 2)[3]])
    return {"time": times(1.0, rows)} | dict(zip(("tip_x", "tip_y", "tip_angle", "middle_y"), np.array(found).T, strict=True))


def decay(rows: int, modes: int = 40) -> Columns:
    """The series of the clamped beam's modes under a force from time 0 on, each damped by c/m + tau omega^2; slopes are small."""
    t, length = times(DECAY.duration, rows)[:, None], DECAY.length
    roots = np.array([brentq(lambda b: np.cos(b) + 1 / np.cosh(b), k * np.pi, (k + 1) * np.pi) for k in range(modes)])
    omega = (roots / length) ** 2 * np.sqrt(DECAY.bending / DECAY.mass)
    rate = (DECAY.damping / DECAY.mass + DECAY.material * omega**2) / 2
    turning = np.sqrt((omega**2 - rate**2).astype(complex))  # imaginary where a mode creeps
    swing = (
        np.exp((1j * turning - rate) * t) * (1 - 1j * rate / turning) + np.exp((-1j * turning - rate) * t) * (1 + 1j * rate / turning)
    ) / 2
    # the square of a mode's tip is four times its mean square over the length
    size = 4 * DECAY.force / (DECAY.mass * length * omega**2) * (1 - swing.real)
    middle, tip = clamped_free_modes(length, modes).evaluate(length * np.array([0.5, 1.0]))
    return {"time": t[:, 0], "tip_deflection": size.sum(axis=1), "middle_deflection": size @ (middle / tip)}


def moving_load(rows: int, modes: int = 40) -> Columns:
    """The bridge's modes under a mass M at x = v t, with the inertia of its place w(v t, t): w'' + 2 v w'_x + v^2 w_xx."""
    waves, speed, load = np.pi * np.arange(1, modes + 1) / BRIDGE.length, BRIDGE.velocity, BRIDGE.load
    modal = BRIDGE.mass * BRIDGE.length / 2

    def rate(t: float, z: Array) -> Array:
        eta, eta_rate = z[:modes], z[modes:]
        phi, slope = np.sin(waves * speed * t), waves * np.cos(waves * speed * t)
        bias = 2 * speed * slope @ eta_rate - speed**2 * (waves**2 * phi) @ eta
        force = -modal * BRIDGE.bending / BRIDGE.mass * waves**4 * eta - load * (G + bias) * phi
        # Sherman and Morrison: the mass matrix is modal 1 + load phi phi^T
        return np.concatenate([eta_rate, (force - load * phi * (phi @ force) / (modal + load * phi @ phi)) / modal])

    t = times(BRIDGE.duration, rows)
    eta = solve_ivp(rate, (0.0, t[-1]), np.zeros(2 * modes), "DOP853", t, rtol=1e-8, atol=1e-11).y[:modes]
    at = {"middle_y": 0.5 + 0 * t, "quarter_y": 0.25 + 0 * t, "load_y": speed * t / BRIDGE.length}
    return {"time": t} | {name: np.sum(eta * np.sin(waves[:, None] * BRIDGE.length * place), axis=0) for name, place in at.items()}


def double_four_bar(rows: int) -> Columns:
    """All arms have one angle a: (3/3 + 2) m L^2 a'' = -(3/2 + 2) m g L cos a."""
    t = times(FOUR_BAR.duration, rows)

    def rate(t: float, z: Array) -> list[float]:
        return [z[1], -3.5 / 3 * G / FOUR_BAR.length * np.cos(z[0])]

    angle, speed = solve_ivp(rate, (0.0, t[-1]), [np.pi / 2, FOUR_BAR.rate], "DOP853", t, rtol=1e-12, atol=1e-12).y
    x, y = FOUR_BAR.length * np.cos(angle), FOUR_BAR.length * np.sin(angle)
    return {"time": t, "tip_x": x, "tip_y": y, "tip_vx": -speed * y, "tip_vy": speed * x}


#: Rod and bead for MuJoCo: its angle counts from the first axis, the bead's place from the rod's middle.
_BEAD = """
<mujoco><option timestep="{step}" integrator="RK4" gravity="0 {weight} 0"/><worldbody><body>
  <inertial pos="{half} 0 0" mass="{rod}" diaginertia="{inertia} {inertia} {inertia}"/><joint type="hinge" axis="0 0 1"/>
  <body pos="{half} 0 0"><inertial pos="0 0 0" mass="{bead}" diaginertia="1e-9 1e-9 1e-9"/>
    <joint type="slide" axis="1 0 0" stiffness="{stiffness}"/></body>
</body></worldbody></mujoco>
"""


def bead(rows: int, steps: int = 10) -> Columns:
    """A hinge and a slide in MuJoCo, with Runge and Kutta's steps of the fourth order."""
    step, half, inertia = BEAD.duration / (rows * steps), BEAD.length / 2, BEAD.rod * BEAD.length**2 / 12
    model = mujoco.MjModel.from_xml_string(_BEAD.format(**vars(BEAD), step=step, half=half, inertia=inertia, weight=-G))
    data, found = mujoco.MjData(model), []
    data.qpos[1] = BEAD.place - half
    for row in range(rows + 1):
        found.append([data.qpos[0], data.qvel[0], data.qpos[1] + half])
        for _ in range(steps if row < rows else 0):
            mujoco.mj_step(model, data)
    return {"time": times(BEAD.duration, rows)} | dict(zip(("rod_angle", "rod_speed", "bead_place"), np.array(found).T, strict=True))
