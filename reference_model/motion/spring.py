"""The spring between a place of the follower and a fixed point (DERIVATION.md, equations 4.13 and 4.14)."""

import math

from quickreturn.reference_model import spring
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.motion.layout import BeamParameters, BeamTables, BeamWorkspace
from quickreturn.reference_model.motion.plane import dot
from quickreturn.reference_model.native.compilation import inner

spring_tension, spring_energy, spring_stiffness = inner(spring.spring_tension), inner(spring.spring_energy), inner(spring.spring_stiffness)


@inner
def hang(p: BeamParameters, t: BeamTables, w: BeamWorkspace) -> None:
    """To `at_spring` and the facts: where the spring holds the follower, its length, its rate and its force."""
    N, f = t.points, w.facts
    _weigh(p, t, w)
    f.spring_place = at_spring(w, w.z, N)
    away = f.frame.conjugate() * complex(p.anchor_1 - p.d, p.anchor_2) - f.spring_place
    f.spring_length = math.sqrt(dot(away, away))
    f.spring_line = away / f.spring_length
    f.spring_rate = -dot(f.spring_line, at_spring(w, w.relative, N) + 1j * f.q2_rate * f.spring_place)
    f.tension = spring_tension(f.spring_length, f.spring_rate, p.spring)
    f.spring_force = f.tension * f.spring_line


@inner
def _weigh(p: BeamParameters, t: BeamTables, w: BeamWorkspace) -> None:
    """To `at_spring`: weights of the points in a field's value at the spring's place, for fields that are zero at P (equation 4.14).

    On the cell that contains the place it is the polynomial through the cell's begin and its Gauss points.
    """
    G = t.gauss_points
    for j in range(t.points):
        w.at_spring[j] = 0.0
    begin = covered = 0.0
    for cell in range(t.cells):
        # a cell beyond a slider that has left the follower has no length
        last = cell == t.cells - 1 or w.length[cell + 1] <= 0.0
        end = math.inf if last else begin + w.length[cell]
        if covered < p.spring_place <= end:
            first, u = cell * t.cell_size, (p.spring_place - begin) / w.length[cell]
            product = u
            for j in range(G):
                w.at_spring[first + j] = product * t.lagrange[j] / t.u[j]
                product *= u - t.u[j]
            product = left = 1.0
            for j in range(G - 1, -1, -1):
                w.at_spring[first + j] *= product
                left -= w.at_spring[first + j]
                product *= u - t.u[j]
            if cell > 0:
                w.at_spring[first - t.cell_size + G] += left
        begin += w.length[cell]
        covered = end


@inner
def at_spring(w: BeamWorkspace, row: Array, N: int) -> complex:
    """A row of vectors at the spring's place."""
    return complex(number_at_spring(w, row[:N]), number_at_spring(w, row[N : 2 * N]))


@inner
def number_at_spring(w: BeamWorkspace, row: Array) -> float:
    """A row of numbers at the spring's place."""
    number = 0.0
    for j in range(len(row)):
        number += w.at_spring[j] * row[j]
    return number


@inner
def load_spring(t: BeamTables, w: BeamWorkspace) -> None:
    """Take the spring's force from `force`, shared between the points as their weights are."""
    N, f = t.points, w.facts
    for j in range(N):
        w.force[j] -= w.at_spring[j] * f.spring_force.real
        w.force[N + j] -= w.at_spring[j] * f.spring_force.imag
