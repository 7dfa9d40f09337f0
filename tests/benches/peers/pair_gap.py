"""The volume between a piece of a face and a piece of the other surface, and its derivatives.

    X(s, t) = x(s) + t n(s),  n = (T_2, -T_1),  T(s) = (1 - s) T_a + s T_b,  0 <= t <= g(s),  T . (x(s) - y(r)) = 0
    G_j = int int psi_j(s) det(X_t, X_s) dt ds        (about an axis: times 2 pi X_1)

x, y: parabolas through two ends and a middle; T_a: sum of the unit tangents on both sides of a. A piece ends where it
ends on its face, or where T . (x(s) - y(r_v)) = 0 for an end r_v of its partner (reference/contact-volume.md, 2).

First derivatives by the complex step through everything, roots included, second ones by central differences of the
first: only the path of Newton's method feels these. Shapes: pieces m, nodes 10 (ends a, b and middle of the face;
outer end and middle of its neighbours before and after; the partner's c, d and middle), points q, axes i. Any number of
axes may stand before m.
"""
from dataclasses import dataclass

import numpy as np

NODES = 10
OWN, OTHER = slice(0, 3), slice(7, 10)
# Nodes of the neighbour that ends at a (outer end, a, middle), and of that which starts at b.
BESIDE = ((3, 0, 4), (1, 5, 6))
# Imaginary step: far below rounding of the real part.
TINY = 1e-40
# Real step of the differences over the length of a face.
STEP = 1e-5
# What gives the tangent at an end of a face beside the face itself.
NOTHING, FACE, WALL = 0, 1, 2


@dataclass
class Pieces:
    """Faces and partners [m]; beside [m, 2]; walls' tangents [m, 2, i]; ends s [m, 2], and the place r of the partner
    that each of them is opposite to, nan where it stands still [m, 2]."""

    face: np.ndarray
    other: np.ndarray
    beside: np.ndarray
    walls: np.ndarray
    ends: np.ndarray
    opposite: np.ndarray

    def some(self, which):
        """Those of a mask or of a list."""
        return Pieces(*(getattr(self, name)[which] for name in self.__dataclass_fields__))


def dot(a, b):
    return (a * b).sum(axis=-1)


def cross(a, b):
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


def point(nodes, s):
    """Of parabolas [.., 3, i] at s, whose axes follow those of the parabolas."""
    a, b, m = (spread(nodes[..., k, :], s) for k in range(3))
    s = s[..., None]
    return a * (1 - s) * (1 - 2 * s) + b * s * (2 * s - 1) + m * 4 * s * (1 - s)


def slope(nodes, s):
    a, b, m = (spread(nodes[..., k, :], s) for k in range(3))
    s = s[..., None]
    return a * (4 * s - 3) + b * (4 * s - 1) + m * (4 - 8 * s)


def spread(vector, s):
    """Vectors [.., i] with the axes that s has more."""
    more = s.ndim - vector.ndim + 1
    return vector.reshape(*vector.shape[:-1], *(1,) * max(more, 0), vector.shape[-1])


def unit(vector):
    return vector / np.sqrt(dot(vector, vector))[..., None]


def tangents(places, beside, walls):
    """T_a and T_b [.., m, 2, i]."""
    found = []
    for end in (0, 1):
        at = np.full(places.shape[:-2], float(end))
        own = unit(slope(places[..., OWN, :], at))
        with np.errstate(all="ignore"):
            neighbour = unit(slope(places[..., list(BESIDE[end]), :], 1.0 - at))
        kind = beside[:, end, None]
        other = np.where(kind == FACE, neighbour, own)
        found.append(np.where(kind == WALL, 2.0 * walls[:, end], own + other))
    return np.stack(found, axis=-2)


class Rays:
    """The rays of pieces at `places` [.., m, 10, i]."""

    def __init__(self, places, pieces):
        self.own, self.other, self.pieces = places[..., OWN, :], places[..., OTHER, :], pieces
        self.tangents = tangents(places, pieces.beside, pieces.walls)
        self.change = self.tangents[..., 1, :] - self.tangents[..., 0, :]
        self.steps = 2 if np.iscomplexobj(places) else 12

    def tangent(self, s):
        return spread(self.tangents[..., 0, :], s) + s[..., None] * spread(self.change, s)

    def ends(self):
        """s of both ends [.., m, 2]."""
        s = np.broadcast_to(self.pieces.ends, (*self.own.shape[:-2], 2)).astype(self.own.dtype)
        moves = ~np.isnan(self.pieces.opposite)
        if not moves.any():
            return s
        v = point(self.other, np.where(moves, self.pieces.opposite, 0.0) + 0.0 * s)
        for _ in range(3):
            apart = point(self.own, s) - v
            value = dot(self.tangent(s), apart)
            slant = dot(self.tangent(s), slope(self.own, s)) + dot(spread(self.change, s), apart)
            s = s - np.where(moves, value / np.where(moves, slant, 1.0), 0.0)
        return s

    def hits(self, s, start):
        """r where the rays from s meet the partners, from a first guess."""
        x, t = point(self.own, s), self.tangent(s)
        r = start + 0.0 * s
        for _ in range(self.steps):
            r = r + dot(t, x - point(self.other, r)) / dot(t, slope(self.other, r))
        return r

    def gap(self, s, r):
        """g in units of n."""
        t = self.tangent(s)
        n = right(t)
        return dot(n, point(self.other, r) - point(self.own, s)) / dot(n, n)

    def swept(self, s, gap, revolved):
        """int det(X_t, X_s) dt by Gauss's rule of two points along the ray."""
        x, along = point(self.own, s), slope(self.own, s)
        n, bent = right(self.tangent(s)), right(spread(self.change, s) + 0.0 * x)
        total = 0.0
        for place in (0.5 - 3.0**-0.5 / 2, 0.5 + 3.0**-0.5 / 2):
            t = (place * gap)[..., None]
            area = cross(n, along + t * bent)
            total = total + 0.5 * gap * area * (2 * np.pi * (x + t * n)[..., 0] if revolved else 1.0)
        return total


def right(t):
    return np.stack([t[..., 1], -t[..., 0]], axis=-1)


def bernstein(s):
    """Of a, b and the middle [.., 3]."""
    return np.stack([(1 - s) ** 2, s**2, 2 * s * (1 - s)], axis=-1)


def gauss(count):
    x, w = np.polynomial.legendre.leggauss(count)
    return 0.5 * (1 + x), 0.5 * w


class Volume:
    """G_j of pieces with derivatives by the places of their nodes, `count` points a piece."""

    def __init__(self, pieces, places, revolved=False, count=5):
        self.pieces, self.places, self.revolved = pieces, places, revolved
        self.points, self.weights = gauss(count)
        rays = Rays(places, pieces)
        # Where the rays hit at the state itself: the start for all states near it.
        self.start = rays.hits(self.at(rays.ends()), 0.5)

    def at(self, ends):
        first, last = ends[..., 0, None], ends[..., 1, None]
        return first + (last - first) * self.points

    def gaps(self, places=None):
        """G of the three functions of each face [.., m, 3]."""
        rays = Rays(self.places if places is None else places, self.pieces)
        ends = rays.ends()
        s = self.at(ends)
        gap = rays.gap(s, rays.hits(s, self.start))
        length = (ends[..., 1] - ends[..., 0])[..., None] * self.weights
        return np.einsum("...q,...qk->...k", length * rays.swept(s, gap, self.revolved), bernstein(s))

    def slopes(self, places=None):
        """dG by the coordinates [20, .., m, 3]."""
        places = self.places if places is None else places
        moved = places + 1j * TINY * directions(places.ndim - 2)
        return self.gaps(moved).imag / TINY

    def curvature(self, factors):
        """sum_j factors[m, j] d2G_j [m, 20, 20]."""
        count, size = len(self.places), 2 * NODES
        lengths = np.linalg.norm(self.places[:, 1] - self.places[:, 0], axis=1)
        moves = STEP * lengths[:, None, None] * directions(1)
        ahead, back = (self.slopes(self.places + sign * moves) for sign in (1.0, -1.0))
        second = np.einsum("dcmk,mk->mdc", ahead - back, factors) / (2 * STEP * lengths[:, None, None])
        second = second.reshape(count, size, size)
        return 0.5 * (second + second.transpose(0, 2, 1))


def directions(axes):
    """Unit motions of the 20 coordinates, with `axes` between them and the nodes."""
    return np.eye(2 * NODES).reshape(2 * NODES, *(1,) * axes, NODES, 2)
