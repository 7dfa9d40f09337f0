"""Multipliers between bodies: lambda = sum Lam_j psi_j on a carrier, G_j >= 0 the volume between the surfaces.

Functions are L^2 and 2 La Lb at the nodes of the carrier, one a node and side of a corner of more than 30 degrees; a
function whose node supports hold along the normals of its faces goes in equal parts to the nearest others of them, and
so does one that meets next to nothing (`pair_lend`): of rubber from an increment's start on, of linear bodies for good.
Linear bodies have G and dG by their relative motion where they first touch (`pair_rest`); a function of which less than
a thousandth has a partner has no row. The interface is that of `saddle_surface`: `saddle_newton` solves with it.
"""
import numpy as np
import scipy.sparse as sp

from pair_gap import Volume, bernstein, gauss, point, slope
from pair_lend import Lending
from pair_rest import PASSES, AtRest, nearer
from pair_search import SMOOTH, Meetings, chain
from saddle_surface import matrix

LEAST_COVERED = 1e-3
HELD_ALONG, EQUAL = 1e-9, 1e-6


class Pair:
    """One contact: facets of the carrier and of the other surface."""

    def __init__(self, name, mesh, sides, held, options):
        self.name, self.mesh = name, mesh
        self.is_rubber, self.revolved, self.points = options
        self.carrier, self.other = chain(mesh, sides[0], held), chain(mesh, sides[1])
        self.last = None
        self.functions, around = functions(mesh, self.carrier)
        self.merge = given_away(mesh, self.carrier, (self.functions, around), held)
        self.multipliers = len(self.merge)
        self.unknowns = 2 * len(mesh.nodes)
        _, self.areas = self.covered(mesh.nodes, self.meetings(mesh.nodes).pieces)
        nodes = np.array([node for node, _ in around])
        self.lending = Lending(self.merge, self.functions, mesh.nodes[nodes])
        self.held = held.reshape(-1, 2)[nodes[self.lending.own]]
        self.rest, none = None, np.zeros(self.multipliers)
        if not self.is_rubber:
            # Where surfaces touch by all functions tells which of them lend; then again by those that are left.
            self.lend(self.touching(), none)
            self.touch = self.touching()
            gaps, coupling = self.linear(self.places(self.touch))
            self.rest = gaps + coupling @ self.touch, coupling

    def lend(self, u, pressures):
        """Has functions lend that meet next to nothing at u; gives what multipliers carry on from `pressures`."""
        places = self.places(u)
        faces = np.arange(len(self.functions))
        meetings = self.meetings(places)
        covered = np.zeros((len(faces), 3))
        np.add.at(covered, meetings.pieces.face, self.lengths(places, meetings.pieces.ends, meetings.pieces.face))
        whole = self.lengths(places, np.tile([0.0, 1.0], (len(faces), 1)), faces)
        lending = self.lending
        pressures = lending.carried(self.merge, pressures)
        self.merge = lending.lent(lending.shares(covered, whole), pressures)
        return self.kept(pressures)

    def kept(self, values):
        """Of multipliers that have a function."""
        return np.where(self.merge.any(axis=1), values, 0.0)

    def touching(self):
        """Displacements at which the surfaces touch, the other one moved."""
        moved = np.zeros((len(self.mesh.nodes), 2))
        others = np.unique(self.other.nodes)
        length = np.ptp(self.mesh.points, axis=0).max()
        for _ in range(PASSES):
            gaps, coupling = self.linear(self.places(moved))
            by_motion = -coupling.reshape(self.multipliers, -1, 2)[:, others].sum(axis=1)
            step = nearer(gaps, by_motion, self.held, np.array([self.revolved, False]), length)
            if step is None:
                break
            moved[others] += step
        return moved.ravel()

    def gathered(self, of_faces, faces):
        """Sums of functions from those of faces [m, 3]."""
        sums = np.zeros(self.functions.max() + 1)
        np.add.at(sums, self.functions[faces].ravel(), of_faces.ravel())
        return sums

    def lengths(self, places, ends, faces):
        """int psi da of parts of faces [m, 3]."""
        own = places[self.carrier.nodes[faces]]
        at, weights = gauss(self.points)
        s = ends[:, :1] + (ends[:, 1:] - ends[:, :1]) * at
        length = (ends[:, 1:] - ends[:, :1]) * weights * np.linalg.norm(slope(own, s), axis=-1)
        if self.revolved:
            length = length * 2 * np.pi * point(own, s)[..., 0]
        return np.einsum("mq,mqk->mk", length, bernstein(s))

    def places(self, u):
        return self.mesh.nodes + u.reshape(-1, 2)

    def meetings(self, places):
        """Who meets whom there, kept for the same places."""
        if self.last is None or not np.array_equal(self.last[0], places):
            self.last = places.copy(), Meetings(self.carrier, self.other, places)
        return self.last[1]

    def volume(self, places):
        meetings = self.meetings(places)
        pieces = meetings.pieces
        nodes = meetings.nodes(pieces.face, pieces.other)
        kind = Volume if self.is_rubber else AtRest
        return meetings, nodes, kind(pieces, places[nodes], self.revolved, self.points)

    def uncovered(self, places, meetings):
        """Which multipliers have no partner, and their gaps."""
        covered, whole = self.covered(places, meetings.pieces)
        areas = np.where(whole > 0.0, whole, self.areas)
        return (covered < LEAST_COVERED * whole) | (whole <= 0.0), meetings.reach * areas

    def covered(self, places, pieces):
        """int psi da over what has a partner, and over all."""
        faces = np.arange(len(self.functions))
        parts = ((pieces.ends, pieces.face), (np.tile([0.0, 1.0], (len(faces), 1)), faces))
        return [self.merge @ self.gathered(self.lengths(places, ends, face), face) for ends, face in parts]

    def covered_at(self, u):
        """The same where contact is measured: a linear body where it touches."""
        places = self.places(u if self.is_rubber else self.touch)
        return self.covered(places, self.meetings(places).pieces)

    def linear(self, places):
        """Gaps and C = -dG/du at places."""
        meetings, nodes, volume = self.volume(places)
        own = volume.gaps() if self.is_rubber else volume.plain()
        gaps = self.merge @ self.gathered(own, meetings.pieces.face)
        slopes = volume.slopes().transpose(1, 2, 0) if self.is_rubber else volume.plain_slopes()
        entries = (self.functions[meetings.pieces.face], dofs(nodes), -slopes)
        rows = matrix([entries], (self.merge.shape[1], self.unknowns))
        coupling = (self.merge @ rows.toarray()) if len(nodes) else np.zeros((self.multipliers, self.unknowns))
        far, open_gaps = self.uncovered(places, meetings)
        coupling[far] = 0.0
        return np.where(far, open_gaps, gaps), coupling

    def contact(self, u, multipliers):
        """Gaps, C and entries of -sum Lam_j d2G_j."""
        if self.rest is not None:
            return self.rest[0] - self.rest[1] @ u, self.rest[1], []
        places = self.places(u)
        gaps, coupling = self.linear(places)
        return gaps, coupling, self.curvature(places, multipliers)

    def curvature(self, places, multipliers):
        meetings = self.meetings(places)
        factors = (multipliers @ self.merge)[self.functions[meetings.pieces.face]]
        loaded = np.abs(factors).max(axis=1, initial=0.0) > 0.0
        if not loaded.any():
            return []
        pieces = meetings.pieces.some(loaded)
        nodes = meetings.nodes(pieces.face, pieces.other)
        volume = Volume(pieces, places[nodes], self.revolved, self.points)
        return [(dofs(nodes), dofs(nodes), -volume.curvature(factors[loaded]))]

    def peak(self, multipliers):
        """The largest pressure on the carrier, at ends of faces or where its slope vanishes."""
        values = (multipliers @ self.merge)[self.functions]
        a, b, m = values.T
        with np.errstate(all="ignore"):
            s = np.nan_to_num((a - m) / (a + b - 2 * m))
        inside = np.einsum("fk,fk->f", values, bernstein(np.clip(s, 0.0, 1.0)))
        return float(max(inside.max(), a.max(), b.max()))

    def parted(self, forces, u):
        """Sums of nodal forces and their moment [3] over the carrier and over the other body."""
        forces = forces.reshape(-1, 2)
        places = self.places(u)
        turning = places[:, 0] * forces[:, 1] - places[:, 1] * forces[:, 0]
        forces = np.concatenate([forces, turning[:, None]], axis=1)
        is_other = np.zeros(len(forces), dtype=bool)
        is_other[self.other.nodes.ravel()] = True
        return forces[~is_other].sum(axis=0), forces[is_other].sum(axis=0)

    def least_covered(self, u, multipliers):
        """The least share with a partner of functions that press."""
        covered, whole = self.covered_at(u)
        return float((covered / np.maximum(whole, 1e-300))[multipliers > 0.0].min(initial=1.0))

    def pressing(self, u, multipliers):
        """int lambda da over what has a partner."""
        return float(multipliers @ self.covered_at(u)[0])


def functions(mesh, carrier):
    """Numbers of the functions [f, 3], and (node, faces) of each."""
    corners = mesh.nodes[carrier.nodes]
    flat = corners[:, 1] - corners[:, 0]
    flat = flat / np.linalg.norm(flat, axis=1, keepdims=True)
    numbers, around = np.full((len(corners), 3), -1), []
    for f, nodes in enumerate(carrier.nodes.tolist()):
        for k, node in enumerate(nodes):
            own = ((n, faces) for n, (other, faces) in enumerate(around) if other == node)
            same = [n for n, faces in own if flat[faces[0]] @ flat[f] >= SMOOTH]
            numbers[f, k] = same[0] if same else len(around)
            if same:
                around[same[0]][1].append(f)
            else:
                around.append((node, [f]))
    return numbers, around


def given_away(mesh, carrier, layout, held):
    """T [multipliers, functions]: psi = T psi_raw."""
    numbers, around = layout
    corners = mesh.nodes[carrier.nodes]
    along = corners[:, 1] - corners[:, 0]
    normals = np.stack([along[:, 1], -along[:, 0]], axis=1) / np.linalg.norm(along, axis=1, keepdims=True)

    def is_held(node, faces):
        components = (np.abs(normals[faces]) > HELD_ALONG).any(axis=0)
        return bool(held[2 * node + np.flatnonzero(components)].all())

    lost = [is_held(node, faces) for node, faces in around]
    own = np.cumsum(np.logical_not(lost)) - 1
    merge = np.zeros((max(own, default=-1) + 1, len(around)))
    for function, (node, faces) in enumerate(around):
        if not lost[function]:
            merge[own[function], function] = 1.0
            continue
        others = {k for k in numbers[faces].ravel().tolist() if not lost[k]}
        away = {k: np.linalg.norm(mesh.nodes[around[k][0]] - mesh.nodes[node]) for k in others}
        takers = [k for k in away if away[k] <= min(away.values()) * (1 + EQUAL)]
        for taker in takers:
            merge[own[taker], function] = 1.0 / len(takers)
    return merge


def dofs(nodes):
    return (2 * nodes[..., None] + np.arange(2)).reshape(*nodes.shape[:-1], 2 * nodes.shape[-1])


class Pairs:
    """All contacts between bodies of a scene, in the place of a `saddle_surface.Surface`; multipliers of `tools`, one
    of these with its obstacles at rest, come first."""

    def __init__(self, mesh, pairs, tools):
        self.mesh, self.pairs = mesh, pairs
        self.tools, self.at_rest = tools
        self.ends = self.tools.multipliers + np.cumsum([0] + [pair.multipliers for pair in pairs])
        self.multipliers = int(self.ends[-1])
        self.areas = np.concatenate([self.tools.areas] + [pair.areas for pair in pairs])
        # What gaps are let in by.
        self.admitted = np.zeros(self.multipliers)

    def lend(self, u, multipliers):
        """What multipliers carry on once functions lend that meet next to nothing at u, and T of before; bodies of
        rubber."""
        pressures, before = multipliers.copy(), [pair.merge for pair in self.pairs]
        for pair, part in zip(self.pairs, self.own(pressures)):
            if pair.is_rubber:
                part[:] = pair.lend(u, part)
        return pressures, before

    def carried(self, before, values):
        """Values of multipliers beside the pressures, from those before functions were lent."""
        values = values.copy()
        for pair, merge, part in zip(self.pairs, before, self.own(values)):
            part[:] = pair.kept(pair.lending.carried(merge, part))
        return values

    def own(self, values):
        return [values[a:b] for a, b in zip(self.ends[:-1], self.ends[1:])]

    def contact(self, u, obstacles, multipliers):
        found = [pair.contact(u, own) for pair, own in zip(self.pairs, self.own(multipliers))]
        gaps, coupling, entries = zip(*found)
        size = 2 * len(self.mesh.nodes)
        curvature = matrix([entry for own in entries for entry in own], (size, size))
        gaps, coupling = np.concatenate(gaps), sp.csr_matrix(np.concatenate(coupling))
        if self.tools.multipliers:
            pressed = multipliers[: self.tools.multipliers]
            by_tools = self.tools.contact(u, self.at_rest if obstacles is None else obstacles, pressed)
            gaps = np.concatenate([by_tools[0], gaps])
            coupling, curvature = sp.vstack([by_tools[1], coupling]).tocsr(), curvature + by_tools[2]
        return gaps + self.admitted, coupling, curvature

    def forces(self, u, multipliers):
        """Force on the carrier of each contact with its moment [3], and on the other body."""
        own = zip(self.pairs, self.own(multipliers))
        return [pair.parted(-(values @ pair.contact(u, np.zeros_like(values))[1]), u) for pair, values in own]
