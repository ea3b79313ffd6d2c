"""Finite elements with fixed nodes, the slider force shared between the nodes of its element (RIVALS.md, section 5)."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from reference_model.compilation import inlined, inside
from reference_model.constraints.gap import Gap, Speeds, crank_tip, smooth_gap
from reference_model.constraints.joint import BOTH_LINEAR, LEVER, Joint
from reference_model.constraints.workspace import OpenWorkspace
from reference_model.kinematics import Slider, slider_at
from reference_model.parameters import Parameters, Workspace
from reference_model.tables import find_cell

Array = NDArray[np.float64]


def nodal_load(distribution: int, stabilization: float, bending_damping: float = 0.0) -> Joint:
    """A force that keeps the gap closed as the multiplier does, but acts on the nodes of cubic elements.

    Args:
        distribution: one of `LEVER`, `CONSISTENT` and `BOTH_LINEAR` of `reference_model.constraints.joint`.
        stabilization: as that of `multiplier`, 1/s.
        bending_damping: time constant of a damping moment EI x time constant x curvature rate, s (equation R5.6).
    """
    return Joint(False, 0.0, 0.0, stabilization, distribution, bending_damping)


@inlined
def meet(joint: Joint, p: Parameters, y: Speeds, w: OpenWorkspace) -> tuple[Slider, Gap]:
    """Slider and gap; `w.row` moves the gap, `w.spread` is what the force acts on. With nodes the quadrature cells are the elements."""
    if joint.distribution == BOTH_LINEAR:
        c, gap = _chord_gap(p, y, w.beam, w.row)
    else:
        c, gap = smooth_gap(p, y, w.beam, w.row)
    for a in range(p.n + 2):
        w.spread[a] = w.row[a]
    if joint.distribution == LEVER and gap.exists:
        edges = p.tables.edges
        left = find_cell(edges, c.s)
        share = (c.s - edges[left]) / (edges[left + 1] - edges[left])
        _share_force(p, y, left, share, -c.slope, c.t1, w.beam, w.spread)
    return c, gap


class Node(NamedTuple):
    """A node of the elements in frame B, its rate relative to that frame and its remaining acceleration (equation 3.7)."""

    x: float  # m
    W: float  # m
    x_rate: float  # m/s
    W_rate: float  # m/s
    a1: float  # m/s^2
    a2: float  # m/s^2


@inlined
def _node(p: Parameters, y: Speeds, node: int, w: Workspace) -> Node:
    """Cubic elements: the deflection of node k >= 1 is coordinate 2 k - 2, node 0 is the pivot."""
    W = W_rate = F_rate = 0.0
    if node > 0 and p.n > 0:
        W, W_rate = y.eta[2 * node - 2], y.eta_rate[2 * node - 2]
    for i in range(p.n):
        F_rate += w.f_edges[node, i] * y.eta_rate[i]
    x = p.tables.edges[node] - w.F_edges[node]
    a1 = -(y.q2_rate**2) * x - 2.0 * y.q2_rate * W_rate - w.H_edges[node]
    return Node(x, W, -F_rate, W_rate, a1, -(y.q2_rate**2) * W - 2.0 * y.q2_rate * F_rate)


@inside
def _share_force(p: Parameters, y: Speeds, left: int, share: float, n1: float, n2: float, w: Workspace, out: Array) -> None:
    """Follower's part of `out` for 1 - share of the force on node `left` and share on the next (equation R5.1)."""
    for a in range(1, p.n + 2):
        out[a] = 0.0
    for side in range(2):
        node = left + side
        weight = share if side == 1 else 1.0 - share
        deflected = node > 0 and p.n > 0
        W = y.eta[2 * node - 2] if deflected else 0.0
        out[1] += weight * (n1 * W - n2 * (p.tables.edges[node] - w.F_edges[node]))
        for i in range(p.n):
            out[i + 2] += weight * n1 * w.f_edges[node, i]
        if deflected:
            out[2 * node] -= weight * n2


@inside
def _chord_gap(p: Parameters, y: Speeds, w: Workspace, row: Array) -> tuple[Slider, Gap]:
    """The slider on the chord between the two nodes of its element, and the gap to the chord (equations R5.2 to R5.5)."""
    edges = p.tables.edges
    C1, C2 = crank_tip(p, y.q1, y.q2)
    left, moved = find_cell(edges, C1), 0
    t1 = t2 = share = chord = 0.0
    for _ in range(len(edges)):
        x, W = edges[left] - w.F_edges[left], 0.0
        if left > 0 and p.n > 0:
            W = y.eta[2 * left - 2]
        next_W = y.eta[2 * left] if p.n > 0 else 0.0
        along, across = edges[left + 1] - w.F_edges[left + 1] - x, next_W - W
        chord = (along * along + across * across) ** 0.5
        t1, t2 = along / chord, across / chord
        share = (t1 * (C1 - x) + t2 * (C2 - W)) / chord
        # a crank tip in the wedge between two chords belongs to either: do not go back and forth
        if share < 0.0 and left > 0 and moved <= 0:
            left, moved = left - 1, -1
        elif share > 1.0 and left < len(edges) - 2 and moved >= 0:
            left, moved = left + 1, 1
        else:
            break
    a, b = _node(p, y, left, w), _node(p, y, left + 1, w)
    n1, n2 = -t2, t1
    length = edges[left + 1] - edges[left]
    c = slider_at(p, edges[left] + share * length, y.q1, y.q2, y.eta, w)
    if not 0.0 < c.s < 1.2 * p.L:
        return c, Gap(False, 0.0, 0.0, 0.0, 0.0)
    value = n1 * (C1 - a.x) + n2 * (C2 - a.W)
    row[0] = p.LA * (n2 * c.a1 - n1 * c.a2)
    _share_force(p, y, left, share, n1, n2, w, row)
    rate = row[0] * y.q1_rate + row[1] * y.q2_rate
    for i in range(p.n):
        rate += row[i + 2] * y.eta_rate[i]
    turn = y.q2_rate + (n1 * (b.x_rate - a.x_rate) + n2 * (b.W_rate - a.W_rate)) / chord
    point_1 = (1.0 - share) * (a.x_rate - y.q2_rate * a.W) + share * (b.x_rate - y.q2_rate * b.W)
    point_2 = (1.0 - share) * (a.W_rate + y.q2_rate * a.x) + share * (b.W_rate + y.q2_rate * b.x)
    sliding = t1 * (-p.LA * c.a2 * y.q1_rate - point_1) + t2 * (p.LA * c.a1 * y.q1_rate - point_2) + turn * value
    a1 = -p.LA * y.q1_rate**2 * c.a1 - (1.0 - share) * a.a1 - share * b.a1
    a2 = -p.LA * y.q1_rate**2 * c.a2 - (1.0 - share) * a.a2 - share * b.a2
    remainder = n1 * a1 + n2 * a2 - 2.0 * turn * sliding + turn**2 * value
    return c, Gap(True, value, rate, remainder, sliding * length / chord)
