"""How far pieces have slid since an increment began, and what tractions along them do:

    f = t(s).(x(s) - y(r)),   t = T / |T|,   R_j = int psi_j df/du da   (s and r held)
    sigma = t0(s).(y0(r) - x0(s)),   S_j = int psi_j sigma da   (x0, y0, t0: at the start; r: opposite to s now)
    force on the bodies: sum_j q_j R_j

da: length on the carrier, about an axis times 2 pi x_1 (src/pairs/slip.rs states them). Derivatives as in `pair_gap`.
"""
import numpy as np

from pair_gap import NODES, STEP, TINY, Rays, Volume, bernstein, directions, dot, point, slope, unit


class Slip(Volume):
    """Of pieces at `places`, from where their nodes were `before` [m, 10, i]."""

    def sites(self, places):
        """Rays, s and r of the points, weights times length."""
        rays = Rays(places, self.pieces)
        ends = rays.ends()
        s = self.at(ends)
        along = slope(rays.own, s)
        area = (ends[..., 1] - ends[..., 0])[..., None] * self.weights * np.sqrt(dot(along, along))
        if self.revolved:
            area = area * 2 * np.pi * point(rays.own, s)[..., 0]
        return rays, s, rays.hits(s, self.start), area

    def slips(self, before, places=None):
        """S of the three functions of each face [.., m, 3]."""
        places = self.places if places is None else places
        _, s, r, area = self.sites(places)
        start = Rays(np.broadcast_to(before, places.shape), self.pieces)
        sigma = dot(unit(start.tangent(s)), point(start.other, r) - point(start.own, s))
        return np.einsum("...q,...qk->...k", area * sigma, bernstein(s))

    def slips_slopes(self, before):
        """dS by the coordinates [20, m, 3]."""
        moved = self.places + 1j * TINY * directions(self.places.ndim - 2)
        return self.slips(before, moved).imag / TINY

    def rows(self, places=None):
        """R by the coordinates [20, .., m, 3]."""
        places = self.places if places is None else places
        _, s, r, area = self.sites(places)
        moved = places + 1j * TINY * directions(places.ndim - 2)
        rays = Rays(moved, self.pieces)
        s, r = (np.broadcast_to(value, (2 * NODES, *value.shape)) for value in (s, r))
        apart = dot(unit(rays.tangent(s)), point(rays.own, s) - point(rays.other, r)).imag / TINY
        return np.einsum("d...q,...q,d...qk->d...k", apart, area, bernstein(s))

    def turning(self, tractions):
        """d(sum_j q_j R_j) of tractions [m, 3]: force by motion [m, 20, 20]."""
        count, size = len(self.places), 2 * NODES
        lengths = np.linalg.norm(self.places[:, 1] - self.places[:, 0], axis=1)
        moves = STEP * lengths[:, None, None] * directions(1)
        ahead, back = (self.rows(self.places + sign * moves) for sign in (1.0, -1.0))
        turned = np.einsum("fdmk,mk->mfd", ahead - back, tractions) / (2 * STEP * lengths[:, None, None])
        return turned.reshape(count, size, size)
