"""Fields along the follower: angles, directions and places of the points, and their integrals (DERIVATION.md, section 2)."""

import math

from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.motion.layout import BeamParameters, BeamTables, BeamWorkspace
from quickreturn.reference_model.motion.plane import point
from quickreturn.reference_model.native.compilation import inlined, inner
from quickreturn.reference_model.native.simd import load, plus, spread, store
from quickreturn.reference_model.state import State

#: Largest angle (rad) between a tangent and the base at which a state is accepted.
LARGEST_ANGLE = 2.0 * math.pi
#: Largest angle (rad) for which the series alone is good to 1e-15.
SMALL_ANGLE = 0.25 * math.pi


@inner
def interpolate_row(t: BeamTables, s: float, row: Array) -> int:
    """To `row`: the table's row at s. Returns the number of the cell that ends at the slider."""
    k = min(max(int((s - t.low) / t.step), 0), t.coefficients.shape[0] - 1)
    ds, c = spread(s - t.low - k * t.step), t.coefficients[k]
    for j in range(0, len(row), 4):
        slope = plus(load(c[1], j), ds, load(c[0], j))
        store(row, j, plus(load(c[3], j), ds, plus(load(c[2], j), ds, slope)))
    return int(t.slider_cell[k])


@inner
def directions(psi: Array, e: Array) -> bool:
    """To `e`: exp(i psi) to 1e-15, by Taylor's series, of an eighth of large angles, doubled three times; False for too large an angle."""
    N = len(e) // 2
    largest = 0.0
    for j in range(N):
        largest = max(largest, abs(psi[j]))
    if not largest <= LARGEST_ANGLE:
        return False
    halvings = 0 if largest <= SMALL_ANGLE else 3
    part = 1.0 if halvings == 0 else 0.125
    for j in range(N):  # the compiler vectorises sines and cosines only in separate loops
        x = part * psi[j]
        q = x * x
        odd = q * (-1 / 5040 + q * (1 / 362880 + q * (-1 / 39916800 + q * (1 / 6227020800 - q / 1307674368000))))
        e[N + j] = x * (1.0 + q * (-1 / 6 + q * (1 / 120 + odd)))
    for j in range(N):
        q = part * psi[j] * part * psi[j]
        even = q * (1 / 40320 + q * (-1 / 3628800 + q * (1 / 479001600 + q * (-1 / 87178291200 + q / 20922789888000))))
        e[j] = 1.0 + q * (-1 / 2 + q * (1 / 24 + q * (-1 / 720 + even)))
    for _ in range(halvings):
        for j in range(N):
            e[j], e[N + j] = 1.0 - 2.0 * e[N + j] * e[N + j], 2.0 * e[N + j] * e[j]
    return True


@inlined
def _cumulate(t: BeamTables, length: Array, f: Array, out: Array, G: int, S: int) -> None:
    """`cumulate` for G Gauss points in a cell of S points.

    The loops treat real and imaginary parts together, and twelve points at a time, or four, so that these share what is loaded.
    """
    cells = t.cells
    N = cells * S
    before_1 = before_2 = 0.0
    for cell in range(cells):
        first, size, p = cell * S, length[cell], 0
        begin_1, begin_2 = spread(before_1), spread(before_2)
        while p < S:
            here = first + p
            a1 = a2 = b1 = b2 = c1 = c2 = spread(0.0)
            if S - p >= 12:
                for j in range(G):
                    entry, f1, f2 = j * S + p, f[first + j], f[N + first + j]
                    a, b, c = load(t.to_points, entry), load(t.to_points, entry + 4), load(t.to_points, entry + 8)
                    a1, b1, c1 = plus(a1, f1, a), plus(b1, f1, b), plus(c1, f1, c)
                    a2, b2, c2 = plus(a2, f2, a), plus(b2, f2, b), plus(c2, f2, c)
                store(out, here + 4, plus(begin_1, size, b1))
                store(out, here + 8, plus(begin_1, size, c1))
                store(out, N + here + 4, plus(begin_2, size, b2))
                store(out, N + here + 8, plus(begin_2, size, c2))
                p += 8
            else:
                for j in range(G):
                    a = load(t.to_points, j * S + p)
                    a1, a2 = plus(a1, f[first + j], a), plus(a2, f[N + first + j], a)
            store(out, here, plus(begin_1, size, a1))
            store(out, N + here, plus(begin_2, size, a2))
            p += 4
        before_1, before_2 = out[first + G], out[N + first + G]


@inner
def cumulate(t: BeamTables, length: Array, f: Array, out: Array) -> None:
    """To `out`: integrals of a complex function f, given at the points of all cells, from x = 0 to every point.

    The compiler unrolls the loops where it knows the number of points: here for those of up to three and up to nine modes.
    """
    if t.gauss_points == 11:
        _cumulate(t, length, f, out, 11, 12)
    elif t.gauss_points == 7:
        _cumulate(t, length, f, out, 7, 8)
    else:
        _cumulate(t, length, f, out, t.gauss_points, t.cell_size)


@inlined
def _cumulate_real(t: BeamTables, length: Array, f: Array, out: Array, G: int, S: int) -> None:
    before = 0.0
    for cell in range(t.cells):
        first = cell * S
        for p in range(0, S, 4):
            sums = spread(0.0)
            for j in range(G):
                sums = plus(sums, f[first + j], load(t.to_points, j * S + p))
            store(out, first + p, plus(spread(before), length[cell], sums))
        before = out[first + G]


@inner
def cumulate_real(t: BeamTables, length: Array, f: Array, out: Array) -> None:
    """`cumulate` for a real function, in rows of N numbers."""
    if t.gauss_points == 11:
        _cumulate_real(t, length, f, out, 11, 12)
    else:
        _cumulate_real(t, length, f, out, t.gauss_points, t.cell_size)


@inlined
def turned(rate: Array, e: Array, f: Array) -> None:
    """To `f`: i rate e, for N real rates and N complex e."""
    N, none = len(e) // 2, spread(0.0)
    for j in range(0, N, 4):
        here = load(rate, j)
        store(f, j, plus(none, -1.0, plus(none, here, load(e, N + j))))
        store(f, N + j, plus(none, here, load(e, j)))


@inlined
def combine(rows: Array, factors: Array, out: Array) -> None:
    """To `out`: sum_i factors_i rows_i."""
    for j in range(0, len(out), 4):
        sums = spread(0.0)
        for i in range(len(rows)):
            sums = plus(sums, factors[i], load(rows[i], j))
        store(out, j, sums)


@inner
def place(p: BeamParameters, t: BeamTables, w: BeamWorkspace, y: State, s: float) -> int:
    """Angles, places and the integrals U_i and Y of the state `y`, the slider at s (equations 2.1 to 2.5).

    Returns:
        Index of the slider's point; -1 if the follower is bent too far.
    """
    n, N = p.n, t.points
    slider_cell = interpolate_row(t, s, w.row)
    combine(w.psi_i, y.eta, w.psi)
    if not directions(w.psi, w.e):
        return -1
    cumulate(t, w.length, w.e, w.z)
    if t.moves:
        combine(w.psi_i_s, y.eta, w.psi_s)
        turned(w.psi_s, w.e, w.integrand)
        cumulate(t, w.length, w.integrand, w.Y)
    for i in range(n):
        turned(w.psi_i[i], w.e, w.integrand)
        cumulate(t, w.length, w.integrand, w.U[i])
    for cell in range(t.cells):
        for j in range(0, t.cell_size, 4):
            share = plus(spread(0.0), w.length[cell], load(t.weights, j))
            store(w.dx, cell * t.cell_size + j, share)
            store(w.dx, N + cell * t.cell_size + j, share)
    w.facts.tip_arm = p.tip_offset * point(w.e, t.tip, N)
    return slider_cell * t.cell_size + t.gauss_points
