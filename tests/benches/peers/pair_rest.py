"""Gaps and slips of linear bodies by their relative motion, where the surfaces first touch (decision 67):

    G_j = int psi_j [g + M.(v - u) / (M.n)] n.N da,   R_j = int psi_j t.(u - v) da

u, v: displacements of x and of y = x + g n; M, t: normal and tangent of the other surface at y; N, da those of the
carrier. The other surface is moved by d = -D sum w T.D G / |T| / sum w (T.D)^2 / |T|, twice, T_j the derivative of G_j
by its motion, g_j = G_j / |T_j|, w_j = (g / g_j)^8 (inside its inverse) with g the least g_j, D along sum w T.
"""
import numpy as np

from pair_gap import NODES, OTHER, OWN, Rays, Volume, bernstein, dot, point, right, slope, unit

PASSES, SHARPNESS, ALIKE, NEAR, NONE = 2, 8, 0.5, 0.1, 1e-9


def lagrange(s):
    """Shape functions of a parabola's ends and middle [.., 3]."""
    return np.stack([(1 - s) * (1 - 2 * s), s * (2 * s - 1), 4 * s * (1 - s)], axis=-1)


class AtRest(Volume):
    """Of pieces at places [m, 10, i] that stay where they are."""

    def __init__(self, pieces, places, revolved=False, count=5):
        super().__init__(pieces, places, revolved, count)
        self.rays = rays = Rays(places, pieces)
        ends = rays.ends()
        s = self.s = self.at(ends)
        self.r = rays.hits(s, self.start)
        along = slope(rays.own, s)
        length = np.sqrt(dot(along, along))
        area = (ends[:, 1] - ends[:, 0])[:, None] * self.weights * length
        if revolved:
            area = area * 2 * np.pi * point(rays.own, s)[..., 0]
        self.weighted = area[..., None] * bernstein(s)
        self.facing = dot(right(rays.tangent(s)), right(along)) / length

    def relative(self, direction):
        """direction.(v - u) by the coordinates [m, q, 20]."""
        factors = np.zeros((*self.s.shape, NODES))
        factors[..., OWN], factors[..., OTHER] = -lagrange(self.s), lagrange(self.r)
        return (factors[..., None] * direction[..., None, :]).reshape(*self.s.shape, 2 * NODES)

    def plain(self):
        """G at the places [m, 3]."""
        return np.einsum("mq,mqk->mk", self.rays.gap(self.s, self.r) * self.facing, self.weighted)

    def plain_slopes(self):
        """dG [m, 3, 20]."""
        across = right(slope(self.rays.other, self.r))
        closing = across / dot(across, right(self.rays.tangent(self.s)))[..., None]
        return np.einsum("mqd,mq,mqk->mkd", self.relative(closing), self.facing, self.weighted)

    def dragged(self):
        """R [m, 3, 20]; the other surface runs the other way."""
        along = unit(slope(self.rays.other, self.r))
        return np.einsum("mqd,mqk->mkd", self.relative(along), self.weighted)


def nearer(gaps, by_motion, held, stays, length):
    """d of functions with rows: gaps [j], T [j, i], which components supports hold [j, i]; `stays`: components across
    an axis. None where surfaces touch or have no common normal."""
    sizes = np.linalg.norm(by_motion, axis=1)
    has = sizes > 0.0
    if not has.any():
        return None
    gaps, by_motion, held, sizes = gaps[has], by_motion[has], held[has], sizes[has]
    distances = gaps / sizes
    least = distances.min()
    if abs(least) <= NONE * length:
        return None
    weights = (least / distances if least > 0.0 else np.maximum(distances / least, 0.0)) ** SHARPNESS
    total = weights @ by_motion
    total[stays | held[weights > NEAR].any(axis=0)] = 0.0
    if np.linalg.norm(total) < ALIKE * (weights @ sizes):
        return None
    along = total / np.linalg.norm(total)
    part = by_motion @ along
    return -along * (weights * part / sizes @ gaps) / (weights * part / sizes @ part)
