"""Surfaces in the plane as rows of faces, and which parts of their faces meet which faces of another surface.

Rules (src/pairs, decision 67), found here by looking at everything:

* bodies lie to the left of their faces; faces that turn by at most 30 degrees at a common vertex share its normal;
* an end that supports hold in one component, about along the face, has the normal of that wall, of a carrier;
* the other surface goes on beyond its ends and corners by 0.3 of the last face, but not before the face on the other
  side of the corner that the ray meets more squarely;
* pieces end where a ray passes an end of a face of the other surface, or where one stops going on, within reach
  along the ray, or of a face that is met; the partner is the nearest one on the ray from the middle, met at a cosine
  of at least 0.2, at most a quarter of the extent of the smaller surface inside and twice that open, or a tenth of the
  own face open at a cosine below a half, unless a gap without a jump joins it to the rest; faces of which no piece is
  within once that have none; rays count up to half of the way to where neighbouring ones meet (decision 72).
"""
import itertools
from dataclasses import dataclass

import numpy as np

from pair_gap import FACE, NOTHING, WALL, Pieces, cross, dot, point, right, slope, tangents, unit

SMOOTH, BEYOND, GRAZING, SLANTED, REACH, WIDE, OPEN, FOCUS = 0.866, 0.3, 0.2, 0.5, 0.25, 2.0, 0.1, 0.5
# Shorter pieces are left out; hits may miss an end by rounding.
SHORTEST, MISSED = 1e-12, 1e-9


@dataclass
class Chain:
    """Nodes [f, 3]; outer end and middle of the neighbours before and after, -1 without [f, 2, 2]; what is beside
    [f, 2]; tangents of walls [f, 2, i]."""

    nodes: np.ndarray
    neighbours: np.ndarray
    beside: np.ndarray
    walls: np.ndarray

    def ranges(self):
        """Part of each face's line that counts [f, 2]."""
        open_ends = self.neighbours[:, :, 0] < 0
        return np.array([0.0, 1.0]) + open_ends * np.array([-BEYOND, BEYOND])


def chain(mesh, facets, held=None):
    """Of facets [f, 2]; `held[dof]` tells what supports hold, of a carrier."""
    nodes = mesh.facet_nodes(outward(mesh, facets))
    corners = mesh.nodes[nodes]
    at = np.ones(len(nodes))
    starts, ends = unit(slope(corners, 0 * at)), unit(slope(corners, at))
    first, last = by_vertex(nodes[:, 0]), by_vertex(nodes[:, 1])
    neighbours = np.full((len(nodes), 2, 2), -1)
    for f, (a, b, _) in enumerate(nodes):
        before, after = last.get(a), first.get(b)
        if before is not None and ends[before] @ starts[f] >= SMOOTH:
            neighbours[f, 0] = nodes[before, 0], nodes[before, 2]
        if after is not None and ends[f] @ starts[after] >= SMOOTH:
            neighbours[f, 1] = nodes[after, 1], nodes[after, 2]
    beside = np.where(neighbours[:, :, 0] >= 0, FACE, NOTHING)
    walls = np.zeros((len(nodes), 2, 2))
    if held is not None:
        add_walls(unit(corners[:, 1] - corners[:, 0]), held[2 * nodes[:, :2, None] + np.arange(2)], beside, walls)
    return Chain(nodes, neighbours, beside, walls)


def add_walls(along, held, beside, walls):
    for f, end in zip(*np.nonzero((held.sum(axis=2) == 1) & (beside == NOTHING))):
        axis = int(held[f, end].argmax())
        if abs(along[f, axis]) >= SMOOTH:
            beside[f, end] = WALL
            walls[f, end, axis] = np.sign(along[f, axis])


def outward(mesh, facets):
    """Facets with the body on their left."""
    beyond = {}
    for cell in mesh.cells.tolist():
        for k in range(3):
            beyond.setdefault(frozenset(cell[:k] + cell[k + 1 :]), cell[k])
    turned = []
    for a, b in facets.tolist():
        inner = mesh.points[beyond[frozenset((a, b))]]
        is_left = cross(mesh.points[b] - mesh.points[a], inner - mesh.points[a]) > 0
        turned.append((a, b) if is_left else (b, a))
    return np.array(turned)


def by_vertex(vertices):
    """Number of the face at each vertex; none where there are several."""
    at = {}
    for face, vertex in enumerate(vertices.tolist()):
        at[vertex] = None if vertex in at else face
    return at


class Meetings:
    """Who meets whom where nodes are at `places` [nodes, i]."""

    def __init__(self, carrier, other, places):
        self.carrier, self.other = carrier, other
        own, ranges = places[carrier.nodes], other.ranges()
        self.partners, self.ranges = places[other.nodes], ranges
        self.reach = REACH * min(diagonal(own[:, :2].reshape(-1, 2)), diagonal(hull(self.partners, ranges)))
        self.own, self.tangents = own, tangents(places[self.nodes(np.arange(len(own)))], carrier.beside, carrier.walls)
        self.turned = self.across_corners()
        self.pieces = self.find()

    def across_corners(self):
        """Whether face q lies across the vertex at an end of face p [end, p, q]."""
        ends, size = self.other.nodes[:, :2], len(self.other.nodes)
        others = ~np.eye(size, dtype=bool)
        return np.array([(ends[:, end, None, None] == ends).any(axis=2) & others for end in (0, 1)])

    def nodes(self, face, other=None):
        """Nodes of pieces [m, 10]; a face's own stand for those that are not there."""
        own = self.carrier.nodes[face]
        beside = np.where(self.carrier.neighbours[face] >= 0, self.carrier.neighbours[face], own[:, None, [0, 2]])
        partner = own if other is None else self.other.nodes[other]
        return np.concatenate([own, beside.reshape(-1, 4), partner], axis=1)

    def find(self):
        rows = [row for face in range(len(self.own)) for row in self.of_face(face)]
        face, other, ends, opposite = (list(column) for column in zip(*rows)) if rows else ([], [], [], [])
        face = np.array(face, dtype=int)
        return Pieces(
            face, np.array(other, dtype=int), self.carrier.beside[face], self.carrier.walls[face],
            np.array(ends, dtype=float).reshape(-1, 2), np.array(opposite, dtype=float).reshape(-1, 2),
        )

    def of_face(self, face):
        """(face, partner, ends, opposite places) along a face."""
        all_breaks = self.breaks(face)
        near = {one for one in all_breaks if self.holds(self.distance(face, *one))}
        met = set()
        while True:
            breaks = [one for one in all_breaks if one in near or one[1] in met]
            runs = self.runs(face, breaks)
            found = {run[0] for run in runs}
            if found <= met:
                break
            met |= found
        runs = self.kept(face, runs)
        for partner, *ends, _ in runs if any(run[-1] <= self.reach for run in runs) else []:
            places = [self.opposite(s, partner, breaks) for s in ends]
            yield face, partner, [s for s, _ in places], [r for _, r in places]

    def kept(self, face, runs):
        """Without what is met aslant and far unless a continuous gap joins it to the rest."""
        near = OPEN * np.linalg.norm(slope(self.own[face][None], np.array([0.5])))
        keep = [gap <= near or self.hit(face, 0.5 * (a + b), p)[1] >= SLANTED for p, a, b, gap in runs]
        for _ in runs:
            for i, j in [*zip(range(len(runs)), range(1, len(runs)))]:
                if keep[i] == keep[j] or runs[j][1] - runs[i][2] > SHORTEST:
                    continue
                g = [self.hit(face, runs[j][1], runs[k][0])[0] for k in (i, j)]
                if abs(g[0] - g[1]) <= near:
                    keep[i] = keep[j] = True
        return [run for run, own in zip(runs, keep) if own]

    def hit(self, face, s, partner):
        """Gap and cosine on the ray from s to a partner."""
        x = point(self.own[face][None], np.array([s]))[0]
        t0, t1 = self.tangents[face]
        t = t0 + s * (t1 - t0)
        n = right(t)
        c, d, m = self.partners[partner]
        k = [t @ (c - x), t @ (4 * m - 3 * c - d), t @ (2 * c + 2 * d - 4 * m)]
        r = -2 * k[0] / (k[1] + np.copysign(np.sqrt(max(k[1] ** 2 - 4 * k[2] * k[0], 0.0)), k[1]))
        y, along = (of(self.partners[partner][None], np.array([r]))[0] for of in (point, slope))
        size = np.linalg.norm(n)
        return n @ (y - x) / size, -cross(n, along) / (size * np.linalg.norm(along))

    def runs(self, face, breaks):
        """[partner, first, last, least gap] between breaks."""
        marks = np.unique([0.0, 1.0, *(s for s, _, _ in breaks)])
        spans = [(a, b) for a, b in itertools.pairwise(marks) if b - a > SHORTEST]
        runs = []
        for (first, last), (partner, gap) in zip(spans, self.nearest(face, np.array(spans).mean(axis=1))):
            if partner < 0:
                continue
            if runs and runs[-1][0] == partner and first - runs[-1][2] <= SHORTEST:
                runs[-1][2:] = last, min(runs[-1][3], gap)
            else:
                runs.append([partner, first, last, gap])
        return runs

    def holds(self, gap):
        return (gap <= WIDE * self.reach) & (-gap <= self.reach)

    def distance(self, face, s, partner, r):
        """Along the ray from s to the place r of a partner."""
        x, y = point(np.stack([self.own[face], self.partners[partner]]), np.array([s, r]))
        t0, t1 = self.tangents[face]
        n = right(t0 + s * (t1 - t0))
        return n @ (y - x) / np.linalg.norm(n)

    def opposite(self, s, partner, breaks):
        """An end with the place of the partner that it is opposite to."""
        if s <= SHORTEST or s >= 1.0 - SHORTEST:
            return float(round(s)), np.nan
        near = [(abs(t - s), t, r) for t, of, r in breaks if of == partner and abs(t - s) <= MISSED]
        return min(near)[1:] if near else (s, np.nan)

    def breaks(self, face):
        """(s, partner, r) where rays of the face pass ends of partners: roots of T.(x - y(r)), a cubic in s."""
        a, b, m = self.own[face]
        t0, t1 = self.tangents[face]
        line = [a, 4 * m - 3 * a - b, 2 * a + 2 * b - 4 * m]
        found = []
        places = np.concatenate([self.ranges, np.clip(self.ranges, 0.0, 1.0)], axis=1)
        ends = point(self.partners, places)
        zero = (a - ends) @ t0
        one = line[1] @ t0 + (a - ends) @ (t1 - t0)
        two, three = line[2] @ t0 + line[1] @ (t1 - t0), line[2] @ (t1 - t0)
        # By Bernstein's coefficients most of them have no root in (0, 1).
        hulls = np.stack([zero, zero + one / 3, zero + 2 * one / 3 + two / 3, zero + one + two + three])
        for partner, end in zip(*np.nonzero((hulls.max(axis=0) > 0) & (hulls.min(axis=0) < 0))):
            k = np.array([three, two, one[partner, end], zero[partner, end]])
            k[:2][np.abs(k[:2]) < 1e-14 * np.abs(k).max()] = 0.0
            roots = np.roots(np.trim_zeros(k, "f"))
            for s in roots[np.abs(roots.imag) < 1e-9].real:
                for _ in range(2):
                    s = s - np.polyval(k, s) / np.polyval(np.polyder(k), s)
                if 0.0 < s < 1.0:
                    found.append((float(s), int(partner), float(places[partner, end])))
        return found

    def nearest(self, face, s):
        """(partner or -1, distance) on the rays from s [k]."""
        x = point(self.own[face][None].repeat(len(s), axis=0), s)
        t0, t1 = self.tangents[face]
        t = t0 + s[:, None] * (t1 - t0)
        n = right(t)
        size = np.linalg.norm(n, axis=1)
        c, d, m = (self.partners[:, k] for k in range(3))
        # t.(x - y(r)) = 0, the root that stays where the partner is straight.
        quadratic = [t @ c.T - dot(t, x)[:, None], t @ (4 * m - 3 * c - d).T, t @ (2 * c + 2 * d - 4 * m).T]
        with np.errstate(all="ignore"):
            root = np.sqrt(quadratic[1] ** 2 - 4 * quadratic[2] * quadratic[0])
            r = -2 * quadratic[0] / (quadratic[1] + np.copysign(root, quadratic[1]))
            y, along = (of(self.partners[None].repeat(len(s), axis=0), r) for of in (point, slope))
            gap = np.einsum("ki,kpi->kp", n, y - x[:, None]) / size[:, None]
            cosine = cross(n[:, None], along) / (size[:, None] * np.linalg.norm(along, axis=2))
            fits = (r >= self.ranges[:, 0] - MISSED) & (r <= self.ranges[:, 1] + MISSED) & (cosine <= -GRAZING)
            fits &= self.holds(gap) & ~self.stands_out(r, gap, -cosine)
        away = np.where(fits, np.abs(gap), np.inf)
        best = away.argmin(axis=1)
        row = np.arange(len(s))
        along = slope(self.own[face][None].repeat(len(s), axis=0), s)
        meet = FOCUS * cross(n, along) + np.maximum(gap[row, best], 0.0) / size * cross(n, right(t1 - t0)[None])
        away[row[meet < 0.0], best[meet < 0.0]] = np.inf
        return [(int(p), gap[k, p]) if away[k, p] < np.inf else (-1, np.inf) for k, p in zip(row, best)]

    def stands_out(self, r, gap, cosine):
        """Where lines beyond corners are met before the face across, which rays meet more squarely [k, p]."""
        is_face = (r >= -MISSED) & (r <= 1.0 + MISSED)
        found = np.zeros(r.shape, dtype=bool)
        for end, beyond in enumerate((r < -MISSED, r > 1.0 + MISSED)):
            behind = is_face[:, None] & (gap[:, None] > gap[..., None]) & (cosine[:, None] > cosine[..., None])
            found |= beyond & (behind & self.turned[end]).any(axis=2)
        return found


def diagonal(points):
    return float(np.linalg.norm(np.ptp(points, axis=0)))


def hull(partners, ranges):
    """Control points of the parts of parabolas that count."""
    ends = point(partners, ranges)
    first = slope(partners, ranges[:, 0])
    control = ends[:, 0] + 0.5 * (ranges[:, 1] - ranges[:, 0])[:, None] * first
    return np.concatenate([ends.reshape(-1, 2), control])

