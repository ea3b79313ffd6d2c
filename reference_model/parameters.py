"""Everything the compiled equations read, as one flat tuple of numbers and arrays, built from a `Mechanism` and a `ShapeSet`."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from reference_model.mechanism import FollowerAlone, PrescribedSpeed, Scene, Tip
from reference_model.rigid import deflection_scale
from reference_model.shapes import ShapeSet
from reference_model.tables import POINTS, Tables, build_tables


class UnsuitableShapes(ValueError):
    """The shapes cannot carry what the scene asks for; the text is one sentence."""


class Parameters(NamedTuple):
    """Constants of the equations (DERIVATION.md, section 1), SI; read-only in compiled code."""

    d: float  # m, pivot distance
    LA: float  # m, crank length
    L: float  # m, follower length
    crank_inertia: float  # kg m^2 about O, slider mass included
    crank_moment: float  # kg m, first moment of crank and slider about O
    torque: float  # N m
    crank_damping: float  # N m s
    crank_is_free: bool
    base_inertia: float  # kg m^2
    base_damping: float  # N m s
    rhoA: float  # kg/m
    EI: float  # N m^2 (0 for the rigid follower: no shape refers to it)
    beam_damping: float  # N s/m^2
    axial_share: float  # of the beam damping on the velocity along b1: 1, or 0 if it acts on the transverse velocity alone
    tip_mass: float  # kg
    tip_inertia: float  # kg m^2
    tip_offset: float  # m
    slider_inertia: float  # kg m^2
    gravity_1: float  # m/s^2
    gravity_2: float  # m/s^2
    has_gravity: bool
    exact_geometry: bool
    n: int  # number of shapes
    thickness: float  # m
    gauges: NDArray[np.float64]  # (3,) m
    tables: Tables
    shape_edges: NDArray[np.float64]
    shape_coefficients: NDArray[np.float64]  # (cells, degree + 1, n)
    stiffness: NDArray[np.float64]  # (n, n) N/m: EI int phi'' phi''
    mass_transverse: NDArray[np.float64]  # (n, n) kg: rhoA int phi phi
    deflection_scale: float  # m, size that errors of the deflection are measured against


def build_parameters(scene: Scene, shapes: ShapeSet, *, exact_geometry: bool, cells: int, transverse_damping: bool = False) -> Parameters:
    """Parameters of the equations for a scene.

    Args:
        scene: a slider joint must be rigid; without crank and slider their constants are zero.
        shapes: the follower's shapes (`no_shapes` for a rigid follower).
        exact_geometry: exact planar geometry, or the thesis' second-order foreshortening with linear curvature.
        cells: cells of the quadrature mesh; 0 takes the shapes' own cells.
        transverse_damping: the beam damping acts on the velocity along b2 alone, not on both components.

    Raises:
        UnsuitableShapes: a slider with rotary inertia on shapes whose curvature jumps.
    """
    follower, crank = scene.follower, _crank_constants(scene)
    if crank["slider_inertia"] > 0.0 and not shapes.has_continuous_curvature:
        raise UnsuitableShapes(
            "a slider with rotary inertia needs shapes with continuous curvature: clamped-free modes or one Hermite element"
        )
    tip = scene.tip or Tip(mass=0.0, inertia=0.0)
    tables = build_tables(shapes, cells)
    EI = 0.0 if follower.is_rigid else follower.bending_stiffness
    return Parameters(
        L=follower.length,
        crank_is_free=not isinstance(scene, FollowerAlone) and scene.crank_is_free,
        **crank,
        base_inertia=scene.base.inertia,
        base_damping=scene.base.damping,
        rhoA=follower.mass_per_length,
        EI=EI,
        beam_damping=follower.damping,
        axial_share=0.0 if transverse_damping else 1.0,
        tip_mass=tip.mass,
        tip_inertia=tip.inertia,
        tip_offset=tip.center_of_mass,
        gravity_1=scene.gravity[0],
        gravity_2=scene.gravity[1],
        has_gravity=scene.has_gravity,
        exact_geometry=exact_geometry,
        n=shapes.count,
        thickness=follower.thickness,
        gauges=np.array(follower.strain_gauges, dtype=float),
        tables=tables,
        shape_edges=np.ascontiguousarray(shapes.edges),
        shape_coefficients=np.ascontiguousarray(shapes.coefficients),
        stiffness=EI * (tables.ddphi.T @ (tables.weights[:, None] * tables.ddphi)),
        mass_transverse=follower.mass_per_length * (tables.phi.T @ (tables.weights[:, None] * tables.phi)),
        deflection_scale=0.01 * follower.length if isinstance(scene, FollowerAlone) else deflection_scale(scene),
    )


def _crank_constants(scene: Scene) -> dict[str, float]:
    """What belongs to crank and slider; zero where the scene has none."""
    if isinstance(scene, FollowerAlone):
        return dict.fromkeys(("d", "LA", "crank_inertia", "crank_moment", "torque", "crank_damping", "slider_inertia"), 0.0)
    crank, slider, drive = scene.crank, scene.slider, scene.crank.drive
    return {
        "d": scene.pivot_distance,
        "LA": crank.length,
        "crank_inertia": crank.inertia_about_pivot + slider.mass * crank.length**2,
        "crank_moment": crank.mass * crank.center_of_mass + slider.mass * crank.length,
        "torque": 0.0 if isinstance(drive, PrescribedSpeed) else drive.torque,
        "crank_damping": 0.0 if isinstance(drive, PrescribedSpeed) else drive.damping,
        "slider_inertia": slider.inertia,
    }


class Workspace(NamedTuple):
    """Scratch arrays of one evaluation of the equations (N points, m cells, n shapes); never read across evaluations."""

    slope: NDArray[np.float64]  # (N,) W'
    slope_rate: NDArray[np.float64]  # (N,) time derivative of W'
    W: NDArray[np.float64]  # (N,)
    W_rate: NDArray[np.float64]  # (N,)
    g: NDArray[np.float64]  # (N,) 1 - dx/ds of the centre line
    g1: NDArray[np.float64]  # (N,) dg/dW'
    F: NDArray[np.float64]  # (N,)
    F_edges: NDArray[np.float64]  # (m + 1,)
    f: NDArray[np.float64]  # (N, n) dF/deta_i
    f_edges: NDArray[np.float64]  # (m + 1, n)
    F_rate: NDArray[np.float64]  # (N,)
    end: NDArray[np.float64]  # (2,) W' and W at x = L
    slider: NDArray[np.float64]  # (2,) s, m; highest angular frequency, rad/s: not known here, 0
    H: NDArray[np.float64]  # (N,) int g'' (dW'/dt)^2
    H_edges: NDArray[np.float64]  # (m + 1,)
    integrand: NDArray[np.float64]  # (N,) scratch
    F1_edges: NDArray[np.float64]  # (m + 1,) scratch of the recovery
    F2_edges: NDArray[np.float64]  # (m + 1,) likewise
    M_edges: NDArray[np.float64]  # (m + 1,) likewise
    at_s: NDArray[np.float64]  # (4, n) phi, phi', phi'', phi''' at the slider
    f_s: NDArray[np.float64]  # (n,) f at the slider
    f_s_slope: NDArray[np.float64]  # (n,) df/dx at the slider
    weights: NDArray[np.float64]  # (3, POINTS)
    M: NDArray[np.float64]  # (n + 2, n + 2) mass matrix for (q1, q2, eta)
    Q: NDArray[np.float64]  # (n + 2,) applied minus inertia forces
    C: NDArray[np.float64]  # (n + 2,) q2dot = C . (q1dot, -, etadot)
    D: NDArray[np.float64]  # (n + 2,) slider rotation rate = D . (q1dot, q2dot, etadot)
    reduced: NDArray[np.float64]  # (n + 1, n + 1)
    rhs: NDArray[np.float64]  # (n + 1,)
    acceleration: NDArray[np.float64]  # (n + 2,) q1, q2, eta


def build_workspace(tables: Tables) -> Workspace:
    """Scratch arrays for a mesh of points and its shapes."""
    N, n, m = len(tables.x), tables.phi.shape[1], len(tables.edges) - 1

    def zeros(*shape: int) -> NDArray[np.float64]:
        return np.zeros(shape)

    return Workspace(
        slope=zeros(N),
        slope_rate=zeros(N),
        W=zeros(N),
        W_rate=zeros(N),
        g=zeros(N),
        g1=zeros(N),
        F=zeros(N),
        F_edges=zeros(m + 1),
        f=zeros(N, n),
        f_edges=zeros(m + 1, n),
        F_rate=zeros(N),
        end=zeros(2),
        slider=zeros(2),
        H=zeros(N),
        H_edges=zeros(m + 1),
        integrand=zeros(N),
        F1_edges=zeros(m + 1),
        F2_edges=zeros(m + 1),
        M_edges=zeros(m + 1),
        at_s=zeros(4, n),
        f_s=zeros(n),
        f_s_slope=zeros(n),
        weights=zeros(3, POINTS),
        M=zeros(n + 2, n + 2),
        Q=zeros(n + 2),
        C=zeros(n + 2),
        D=zeros(n + 2),
        reduced=zeros(n + 1, n + 1),
        rhs=zeros(n + 1),
        acceleration=zeros(n + 2),
    )


def state_size(parameters: Parameters) -> int:
    """Length of the state vector (q1, eta, q1dot, etadot, dissipated energy, drive work)."""
    return 2 * parameters.n + 4


def rounding_scale(parameters: Parameters) -> float:
    """Length (m) below which places on the follower cannot be told apart in double precision."""
    return 8.0 * math.ulp(parameters.L)
