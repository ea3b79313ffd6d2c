"""Centre line, slider and constraint row, compiled (thesis/DERIVATION.md, sections 2 and 3)."""

import math
from typing import NamedTuple

from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.native.compilation import inlined, inner
from quickreturn.reference_model.thesis.parameters import (
    POINTS,
    TO_POINTS,
    ThesisParameters,
    ThesisTables,
    ThesisWorkspace,
    cumulate,
    find_cell,
    partial_weights,
)

CLOSURE_STEPS = 30  # Newton steps for the slider's place, at most; four suffice where the loop closes


@inner
def foreshortening(slope: float, exact: bool) -> tuple[float, float, float]:
    """g(W') and its first two derivatives, equation 2.2 (exact) or 2.3 (second order)."""
    if exact:
        cosine = math.sqrt(1.0 - slope * slope)
        return slope * slope / (1.0 + cosine), slope / cosine, 1.0 / cosine**3
    return 0.5 * slope * slope, slope, 1.0


@inner
def tangent_angle(slope: float, exact: bool) -> tuple[float, float, float]:
    """Angle theta(W') of the tangent relative to the base tangent and its first two derivatives, equation 2.4."""
    if exact:
        cosine = math.sqrt(1.0 - slope * slope)
        return math.asin(slope), 1.0 / cosine, slope / cosine**3
    return slope, 1.0, 0.0


@inner
def centre_line(t: ThesisTables, exact: bool, eta: Array, eta_rate: Array, w: ThesisWorkspace) -> bool:
    """To `w`: W, W', their rates, F, f_i, the rate of F, and H at all points of a mesh (equations 2.1 to 2.8).

    False if the slope |W'| reaches 1 somewhere: no centre line has that slope.
    """
    N, n = t.phi.shape
    for p in range(N):
        slope = slope_rate = W = W_rate = 0.0
        for i in range(n):
            slope += t.dphi[p, i] * eta[i]
            slope_rate += t.dphi[p, i] * eta_rate[i]
            W += t.phi[p, i] * eta[i]
            W_rate += t.phi[p, i] * eta_rate[i]
        if not abs(slope) < 1.0:
            return False
        g, g1, g2 = foreshortening(slope, exact)
        w.slope[p], w.slope_rate[p], w.W[p], w.W_rate[p] = slope, slope_rate, W, W_rate
        w.g[p], w.g1[p] = g, g1
        w.integrand[p] = g2 * slope_rate * slope_rate
    w.end[0] = w.end[1] = 0.0
    for i in range(n):
        w.end[0] += t.end_dphi[i] * eta[i]
        w.end[1] += t.end_phi[i] * eta[i]
    cumulate(t.edges, w.g, w.F, w.F_edges)
    cumulate(t.edges, w.integrand, w.H, w.H_edges)
    _cumulate_shapes(t, w)
    for p in range(N):
        rate = 0.0
        for i in range(n):
            rate += w.f[p, i] * eta_rate[i]
        w.F_rate[p] = rate
    return True


@inner
def _cumulate_shapes(t: ThesisTables, w: ThesisWorkspace) -> None:
    """To `f` and `f_edges`: f_i(x) = int_0^x g'(W') phi_i' (equation 2.6) at all points and edges."""
    n = t.phi.shape[1]
    for i in range(n):
        w.f_edges[0, i] = 0.0
    for c in range(len(t.edges) - 1):
        length = t.edges[c + 1] - t.edges[c]
        first = c * POINTS
        for i in range(n):
            w.f_edges[c + 1, i] = w.f_edges[c, i]
        for p in range(POINTS):
            for i in range(n):
                w.f[first + p, i] = w.f_edges[c, i]
        for j in range(POINTS):
            g1 = w.g1[first + j]
            end_weight = t.weights[first + j] * g1
            for i in range(n):
                w.f_edges[c + 1, i] += end_weight * t.dphi[first + j, i]
            for p in range(POINTS):
                weight = TO_POINTS[p, j] * length * g1
                for i in range(n):
                    w.f[first + p, i] += weight * t.dphi[first + j, i]


class Slider(NamedTuple):
    """The slider's place and the fields of the follower there, in frame B (equations 3.1 to 3.9)."""

    closes: bool  # whether the loop can be closed
    s: float  # m, arc length
    x: float  # m, s - F(s)
    W: float  # m
    slope: float  # W'(s)
    curvature: float  # W''(s), 1/m
    curvature_slope: float  # W'''(s), 1/m^2
    t1: float  # tangent along b1, 1 - g
    g_slope: float  # dg/dx at s, 1/m
    q2: float  # rad
    a1: float  # crank direction a1 along b1
    a2: float  # crank direction a1 along b2


@inner
def _shapes_at(p: ThesisParameters, x: float, values: Array) -> None:
    """To `values`: phi_i and three derivatives at x, shape (4, n); beyond the follower's ends by the polynomials of the cell there."""
    cell = find_cell(p.shape_edges, x)
    length = p.shape_edges[cell + 1] - p.shape_edges[cell]
    u = (x - p.shape_edges[cell]) / length
    for i in range(p.n):
        v0 = v1 = v2 = v3 = 0.0
        for k in range(p.shape_coefficients.shape[1] - 1, -1, -1):
            v3 = v3 * u + 3.0 * v2
            v2 = v2 * u + 2.0 * v1
            v1 = v1 * u + v0
            v0 = v0 * u + p.shape_coefficients[cell, k, i]
        values[0, i] = v0
        values[1, i] = v1 / length
        values[2, i] = v2 / length**2
        values[3, i] = v3 / length**3


@inner
def place_at(p: ThesisParameters, s: float, eta: Array, w: ThesisWorkspace) -> tuple[float, float, float, float]:
    """Place (x, W) of arc length s in frame B, and slope W' and g there (needs `centre_line` in `w` first)."""
    cell = find_cell(p.shape_edges, s)
    length = p.shape_edges[cell + 1] - p.shape_edges[cell]
    u = (s - p.shape_edges[cell]) / length
    W = slope = 0.0
    for k in range(p.shape_coefficients.shape[1] - 1, -1, -1):
        coefficient = 0.0
        for i in range(p.n):
            coefficient += p.shape_coefficients[cell, k, i] * eta[i]
        slope = slope * u + W
        W = W * u + coefficient
    slope /= length
    edges = p.tables.edges
    cell = find_cell(edges, s)
    length = edges[cell + 1] - edges[cell]
    partial_weights((s - edges[cell]) / length, length, w.weights)
    F, g = w.F_edges[cell], 0.0
    for j in range(POINTS):
        F += w.weights[0, j] * w.g[cell * POINTS + j]
        g += w.weights[1, j] * w.g[cell * POINTS + j]
    return s - F, W, slope, g


@inner
def _locate(p: ThesisParameters, eta: Array, distance: float, w: ThesisWorkspace) -> float:
    """Arc length s at which the centre line passes at `distance` from P (equation 3.2), or nan if there is none near."""
    s = distance
    for step in range(CLOSURE_STEPS):
        x, W, slope, g = place_at(p, s, eta, w)
        gradient = 2.0 * (x * (1.0 - g) + W * slope)
        if not gradient > 1e-3 * distance:
            return math.nan
        correction = (x * x + W * W - distance * distance) / gradient
        s -= correction
        if not (0.0 < s < 1.2 * p.L):
            return math.nan
        if abs(correction) < 4e-16 * p.L:
            break
        # round-off may keep the corrections from falling below the limit above
        if abs(correction) < 1e-14 * p.L and step > 6:
            break
    return s


@inlined
def place_slider(p: ThesisParameters, q1: float, eta: Array, w: ThesisWorkspace) -> Slider:
    """Close the loop (equations 1.1 and 3.1 to 3.4): slider place, base angle, fields there (needs `centre_line` in `w` first)."""
    v1 = p.LA * math.cos(q1) - p.d  # P to C in frame N
    v2 = p.LA * math.sin(q1)
    s = _locate(p, eta, math.hypot(v1, v2), w)
    if math.isnan(s):
        return Slider(False, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    x, W, _, _ = place_at(p, s, eta, w)
    # continuous: v1 < 0 where LA < d, and beyond that P to C is within 90 deg of the crank
    chord = q1 + math.atan2(p.d * math.sin(q1), p.LA - p.d * math.cos(q1)) if p.d < p.LA else math.pi + math.atan2(-v2, -v1)
    q2 = chord - math.atan2(W, x)
    return slider_at(p, s, q1, q2, eta, w)


@inner
def slider_at(p: ThesisParameters, s: float, q1: float, q2: float, eta: Array, w: ThesisWorkspace) -> Slider:
    """All fields at the slider's arc length s for given crank and base angle; fills `w.at_s`, `w.f_s` and `w.f_s_slope`."""
    edges = p.tables.edges
    cell = find_cell(edges, s)
    length = edges[cell + 1] - edges[cell]
    partial_weights((s - edges[cell]) / length, length, w.weights)
    _shapes_at(p, s, w.at_s)
    F, g, g_slope = w.F_edges[cell], 0.0, 0.0
    for i in range(p.n):
        w.f_s[i] = w.f_edges[cell, i]
        w.f_s_slope[i] = 0.0
    for j in range(POINTS):
        point = cell * POINTS + j
        F += w.weights[0, j] * w.g[point]
        g += w.weights[1, j] * w.g[point]
        g_slope += w.weights[2, j] * w.g[point]
        for i in range(p.n):
            product = w.g1[point] * p.tables.dphi[point, i]
            w.f_s[i] += w.weights[0, j] * product
            w.f_s_slope[i] += w.weights[1, j] * product
    W = slope = curvature = curvature_slope = 0.0
    for i in range(p.n):
        W += w.at_s[0, i] * eta[i]
        slope += w.at_s[1, i] * eta[i]
        curvature += w.at_s[2, i] * eta[i]
        curvature_slope += w.at_s[3, i] * eta[i]
    return Slider(True, s, s - F, W, slope, curvature, curvature_slope, 1.0 - g, g_slope, q2, math.cos(q1 - q2), math.sin(q1 - q2))


class Contact(NamedTuple):
    """Rates at the slider and the constraint row in the form q2ddot = C . (q1ddot, etaddot) + c0 (equations 3.5 to 3.9)."""

    regular: bool  # False where the normal passes through the pivot
    q2_rate: float
    s_rate: float
    B0: float  # n . p_perp, lever arm of the slider force about P (m)
    c0: float
    normal: float  # |n|, 1 in exact geometry
    d0: float  # bias of the slider's angular acceleration, 1/s^2 (only with rotary inertia)


@inner
def normal_row(p: ThesisParameters, c: Slider, w: ThesisWorkspace, row: Array) -> None:
    """To `row`: coefficients of the speeds (q1, q2, eta) in n times the velocity loop (equation 3.6): n . (LA a2, -p_perp, -p_i)."""
    n1, n2 = -c.slope, c.t1
    row[0] = p.LA * (n2 * c.a1 - n1 * c.a2)
    row[1] = n1 * c.W - n2 * c.x
    for i in range(p.n):
        row[i + 2] = n1 * w.f_s[i] - n2 * w.at_s[0, i]


class FieldRates(NamedTuple):
    """Time derivatives of the fields at the slider's place, for a constant arc length."""

    W: float  # m/s
    F: float  # m/s
    slope: float  # 1/s
    F_slope: float  # 1/s
    curvature: float  # 1/(m s)


@inner
def field_rates(p: ThesisParameters, eta_rate: Array, w: ThesisWorkspace) -> FieldRates:
    """Rates of W, F, W', F' and W'' at the slider (needs `slider_at` first)."""
    W = F = slope = F_slope = curvature = 0.0
    for i in range(p.n):
        W += w.at_s[0, i] * eta_rate[i]
        F += w.f_s[i] * eta_rate[i]
        slope += w.at_s[1, i] * eta_rate[i]
        curvature += w.at_s[2, i] * eta_rate[i]
        F_slope += w.f_s_slope[i] * eta_rate[i]
    return FieldRates(W, F, slope, F_slope, curvature)


@inner
def sliding_speed(p: ThesisParameters, c: Slider, r: FieldRates, q1_rate: float, q2_rate: float) -> float:
    """Rate of the slider's arc length, m/s: velocity of the crank tip relative to the follower, times t / |t|^2 (equation 3.5)."""
    along_1 = -p.LA * c.a2 * q1_rate + c.W * q2_rate + r.F
    along_2 = p.LA * c.a1 * q1_rate - c.x * q2_rate - r.W
    return (c.t1 * along_1 + c.slope * along_2) / (c.t1 * c.t1 + c.slope * c.slope)


@inner
def loop_bias(
    p: ThesisParameters, c: Slider, r: FieldRates, q1_rate: float, q2_rate: float, s_rate: float, w: ThesisWorkspace
) -> tuple[float, float]:
    """Bias of the loop's second derivative: its terms without accelerations of the speeds, in frame B (equation 3.7).

    That is -LA q1dot^2 a1 - a0 - 2 q2dot sdot t_perp - 2 sdot tdot - sdot^2 t_x.
    """
    b1 = -p.LA * q1_rate**2 * c.a1 + q2_rate**2 * c.x + 2.0 * q2_rate * r.W + _h_at_slider(p, c, w)
    b2 = -p.LA * q1_rate**2 * c.a2 + q2_rate**2 * c.W + 2.0 * q2_rate * r.F
    b1 += 2.0 * q2_rate * s_rate * c.slope + 2.0 * s_rate * r.F_slope + s_rate**2 * c.g_slope
    b2 -= 2.0 * q2_rate * s_rate * c.t1 + 2.0 * s_rate * r.slope + s_rate**2 * c.curvature
    return b1, b2


@inner
def constraint_row(p: ThesisParameters, c: Slider, q1_rate: float, eta: Array, eta_rate: Array, w: ThesisWorkspace) -> Contact:
    """Project the velocity loop and its derivative on the normal at the slider; fills `w.C` and, with rotary inertia, `w.D`."""
    square = c.t1 * c.t1 + c.slope * c.slope
    normal_row(p, c, w, w.C)
    B0 = -w.C[1]
    if not abs(B0) > 1e-6 * p.L:
        return Contact(False, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    w.C[0] /= B0
    q2_rate = w.C[0] * q1_rate
    for i in range(p.n):
        w.C[i + 2] /= B0
        q2_rate += w.C[i + 2] * eta_rate[i]
    r = field_rates(p, eta_rate, w)
    s_rate = sliding_speed(p, c, r, q1_rate, q2_rate)
    b1, b2 = loop_bias(p, c, r, q1_rate, q2_rate, s_rate, w)
    d0 = 0.0
    if p.slider_inertia > 0.0:
        _, angle_1, angle_2 = tangent_angle(c.slope, p.exact_geometry)
        bend = angle_1 * c.curvature / square
        w.D[0] = bend * p.LA * (c.slope * c.a1 - c.t1 * c.a2)
        w.D[1] = 1.0 + bend * (c.t1 * c.W - c.slope * c.x)
        for i in range(p.n):
            w.D[i + 2] = angle_1 * w.at_s[1, i] + bend * (c.t1 * w.f_s[i] - c.slope * w.at_s[0, i])
        d0 = angle_1 * (2.0 * r.curvature * s_rate + c.curvature_slope * s_rate**2) + bend * (c.t1 * b1 + c.slope * b2)
        d0 += angle_2 * (r.slope + c.curvature * s_rate) ** 2
    return Contact(True, q2_rate, s_rate, B0, (c.t1 * b2 - c.slope * b1) / B0, math.sqrt(square), d0)


@inner
def _h_at_slider(p: ThesisParameters, c: Slider, w: ThesisWorkspace) -> float:
    """H(s) = int_0^s g''(W') (dW'/dt)^2 (equation 2.8); `w.integrand` still holds the integrand."""
    cell = find_cell(p.tables.edges, c.s)
    H = w.H_edges[cell]
    for j in range(POINTS):
        H += w.weights[0, j] * w.integrand[cell * POINTS + j]
    return H
