"""Constants and shapes of the follower alone, clamped to a base that turns as prescribed, for compiled code (DERIVATION.md, section 14)."""

from typing import NamedTuple

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray

from reference_model.gauss_points import barycentric_weights, integrals_to_points
from reference_model.mechanism import FollowerAlone, Tip
from reference_model.natural_modes import clamped_modes

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]


class ClampedParameters(NamedTuple):
    """Constants of the equations, SI; G Gauss points along the follower and, behind them, its end."""

    L: float
    rhoA: float
    EI: float
    beam_damping: float
    base_inertia: float
    base_damping: float
    tip_mass: float
    tip_inertia: float
    tip_offset: float
    gravity_1: float
    gravity_2: float
    speed: float  # rad/s, of the base from `time` on
    time: float  # s, of the spin-up
    thickness: float
    gauges: Array  # (3,) m
    n: int
    psi: Array  # (n, G + 1) slopes of the clamped modes
    squares: Array  # (n,) omega^2, 1/s^2
    x: Array  # (G,) m
    weights: Array  # (G,) m, of integrals over the whole length
    to_points: Array  # (G, G + 1) m, weight of each Gauss point in the integrals from the base to each point
    barycentric: Array  # (G,) weights of the polynomial through the Gauss points (Berrut and Trefethen, 2004)


class ClampedWorkspace(NamedTuple):
    """Scratch of one evaluation; planar vectors are complex numbers in frame B."""

    slider: Array  # (1,) what the integrator watches for a slider that leaves the follower; here there is none, it stays at zero
    angle: Array  # (G + 1,) psi
    turn: Array  # (G + 1,) rate of the tangent's angle
    e: Complex  # (G + 1,) exp(i psi)
    z: Complex  # (G + 1,) place relative to P
    integrand: Complex  # (G + 1,)
    V: Complex  # (n, G + 1) partial velocities
    T: Complex  # (n,) those of the tip's centre
    relative: Complex  # (G + 1,) velocity relative to frame B
    A: Complex  # (G + 1,) acceleration less gravity
    reduced: Array  # (n, n) mass matrix
    acceleration: Array  # (n,)
    tip: Complex  # (1,) acceleration of the tip's centre less gravity
    facts: Array  # (4,) base angle, rate, acceleration; acceleration of the end's angle


def gauss_points(modes: int) -> int:
    """Gauss points along the follower: pi for every wave of a product of two of the highest modes, and as many as smooth fields need.

    With half of them the tip deflection of the spin-up changes by less than 1e-12 of itself.
    """
    return 3 * modes + 12


def clamped_parameters(scene: FollowerAlone, modes: int) -> ClampedParameters:
    """Parameters of a scene in its first `modes` (at least 1) clamped modes, equations 14.2 and 14.3."""
    follower, tip = scene.follower, scene.tip or Tip(mass=0.0, inertia=0.0)
    found, G = clamped_modes(scene, modes), gauss_points(modes)
    points, weights = legendre.leggauss(G)
    half = 0.5 * follower.length
    psi = np.asarray(legendre.legval(np.append(points, 1.0), found.slope_series()[0]), dtype=np.float64)
    return ClampedParameters(
        L=follower.length,
        rhoA=follower.mass_per_length,
        EI=follower.bending_stiffness,
        beam_damping=follower.damping,
        base_inertia=scene.base.inertia,
        base_damping=scene.base.damping,
        tip_mass=tip.mass,
        tip_inertia=tip.inertia,
        tip_offset=tip.center_of_mass,
        gravity_1=scene.gravity[0],
        gravity_2=scene.gravity[1],
        speed=scene.spin_up.speed,
        time=scene.spin_up.time,
        thickness=follower.thickness,
        gauges=np.array(follower.strain_gauges, dtype=float),
        n=modes,
        psi=np.ascontiguousarray(psi),
        squares=(2.0 * np.pi * found.frequencies) ** 2,
        x=half * (points + 1.0),
        weights=half * weights,
        to_points=half * integrals_to_points(points, weights),
        barycentric=barycentric_weights(points, weights),
    )


def clamped_workspace(p: ClampedParameters) -> ClampedWorkspace:
    """Scratch arrays for a scene."""
    size, n = len(p.x) + 1, p.n
    return ClampedWorkspace(
        slider=np.zeros(2),
        angle=np.zeros(size),
        turn=np.zeros(size),
        e=np.zeros(size, complex),
        z=np.zeros(size, complex),
        integrand=np.zeros(size, complex),
        V=np.zeros((n, size), complex),
        T=np.zeros(n, complex),
        relative=np.zeros(size, complex),
        A=np.zeros(size, complex),
        reduced=np.zeros((n, n)),
        acceleration=np.zeros(n),
        tip=np.zeros(1, complex),
        facts=np.zeros(4),
    )
