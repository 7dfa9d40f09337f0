"""Contact surfaces and their multipliers: lambda = sum Lam_j psi_j, G_j = int psi_j d(x + u) da >= 0 by a rule of
degree 8, over the deformed surface where bodies are of rubber, else over the undeformed one (`saddle_area`).

Functions before merging ("raw") stand at the nodes of each obstacle's facets: hats at vertices (`linear`), L^2 and
2 La Lb at all nodes (`quadratic`). A matrix T >= 0 of columns with sum one makes the multipliers, psi = T psi_raw:

* nodes of two obstacles on disjoint facets with nearly parallel normals share one multiplier;
* a node whose normal displacement supports hold gives its function in equal parts to the nearest free nodes of its
  facets; a function of a facet without free nodes is left out.

Both for `quadratic` only. A facet of one obstacle that meets another at an edge shares its functions there: surfaces
with sharp edges inside one obstacle are Signorini's only where each side has an obstacle of its own.
"""
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from saddle_rule import bernstein, of_facets, p2

DEGREE = 8
# Least cosine between normals of nearly parallel facets.
PARALLEL = 0.99
# Component of a unit normal that counts as one.
ALONG = 1e-9
# Distances that differ by less, relative, are equal.
EQUAL = 1e-6


@dataclass
class Faces:
    """Facets of one obstacle: nodes [n, k], measure [n], outward or inward unit normal [n, dim], raw numbers."""

    nodes: np.ndarray
    measure: np.ndarray
    normals: np.ndarray
    functions: np.ndarray


class Surface:
    """The facets of all obstacles; `held[dof]` tells supports, `space` is linear or quadratic, `measure` the class of
    `saddle_area` that weighs the gap."""

    def __init__(self, mesh, facets, held, space, measure):
        self.mesh, self.dim, self.space = mesh, mesh.dim, space
        self.points, self.weights = of_facets(mesh.dim, DEGREE)
        self.measure = measure(self.points, self.weights)
        self.shapes = p2(self.points)
        self.psi = self.points if space == "linear" else bernstein(self.points)
        self.raw = []
        self.faces = [self.make_faces(index, each) for index, each in enumerate(facets)]
        self.merge = self.merged(held)
        self.multipliers = self.merge.shape[0]
        self.areas = self.merge @ self.raw_areas()

    def make_faces(self, obstacle, facets):
        nodes = self.mesh.facet_nodes(facets)
        corners = self.mesh.points[facets]
        sides = corners[:, 1:] - corners[:, :1]
        if self.dim == 2:
            normals = np.stack([sides[:, 0, 1], -sides[:, 0, 0]], axis=1)
            factor = 1.0
        else:
            normals, factor = np.cross(sides[:, 0], sides[:, 1]), 0.5
        lengths = np.linalg.norm(normals, axis=1)
        carriers = facets if self.space == "linear" else nodes
        own = {}
        for node in np.unique(carriers).tolist():
            own[node] = len(self.raw)
            self.raw.append((obstacle, node))
        functions = np.vectorize(own.get, otypes=[int])(carriers)
        return Faces(nodes, factor * lengths, normals / lengths[:, None], functions)

    def raw_areas(self):
        """Of the undeformed facets: scales of gaps only."""
        areas = np.zeros(len(self.raw))
        shares = self.weights @ self.psi
        for faces in self.faces:
            np.add.at(areas, faces.functions.ravel(), np.outer(faces.measure, shares).ravel())
        return areas

    def merged(self, held):
        """T [multipliers, raw]."""
        count = len(self.raw)
        if self.space == "linear":
            return sp.identity(count, format="csr")
        around = self.around()
        cluster = self.clusters(around)
        is_held = self.held_clusters(around, cluster, held)
        rows, columns, values = [], [], []
        for members in group(cluster):
            heirs = [cluster[members[0]]]
            if is_held[heirs[0]]:
                heirs = self.heirs(members, around, cluster, is_held)
            for raw in members:
                rows += heirs
                columns += [raw] * len(heirs)
                values += [1.0 / len(heirs)] * len(heirs)
        kept = np.unique(rows)
        number = {row: i for i, row in enumerate(kept.tolist())}
        rows = [number[row] for row in rows]
        return sp.coo_matrix((values, (rows, columns)), shape=(len(kept), count)).tocsr()

    def around(self):
        """Facets (obstacle, facet) of each raw function."""
        around = [[] for _ in self.raw]
        for obstacle, faces in enumerate(self.faces):
            for facet, functions in enumerate(faces.functions.tolist()):
                for raw in functions:
                    around[raw].append((obstacle, facet))
        return around

    def clusters(self, around):
        """Number of the multiplier of each raw function before held ones are given away."""
        keys = [{tuple(sorted(nodes)) for nodes in faces.nodes.tolist()} for faces in self.faces]
        cluster, of_node = list(range(len(self.raw))), {}
        for raw, (obstacle, node) in enumerate(self.raw):
            normal = self.mean_normal(around[raw])
            for other, its_normal in of_node.get(node, []):
                disjoint = not keys[obstacle] & keys[self.raw[other][0]]
                if disjoint and abs(normal @ its_normal) > PARALLEL:
                    cluster[raw] = cluster[other]
                    break
            of_node.setdefault(node, []).append((raw, normal))
        return cluster

    def mean_normal(self, facets):
        normals = np.array([self.faces[o].normals[f] for o, f in facets])
        normals = normals * np.sign(normals @ normals[0])[:, None]
        mean = normals.sum(axis=0)
        return mean / np.linalg.norm(mean)

    def held_clusters(self, around, cluster, held):
        """Whether supports hold every component along the normals of the facets around."""
        is_held = {}
        for raw, (_, node) in enumerate(self.raw):
            stuck = held[self.dim * node : self.dim * (node + 1)]
            normals = np.array([self.faces[o].normals[f] for o, f in around[raw]])
            along = (np.abs(normals) > ALONG).any(axis=0)
            is_held[cluster[raw]] = is_held.get(cluster[raw], True) and bool(stuck[along].all())
        return is_held

    def heirs(self, members, around, cluster, is_held):
        """Clusters of the nearest free nodes of the facets around a held node."""
        place = self.mesh.nodes[self.raw[members[0]][1]]
        distances = {}
        for raw in members:
            for obstacle, facet in around[raw]:
                for other in self.faces[obstacle].functions[facet].tolist():
                    if not is_held[cluster[other]]:
                        away = np.linalg.norm(self.mesh.nodes[self.raw[other][1]] - place)
                        distances[cluster[other]] = away
        least = min(distances.values(), default=0.0)
        return sorted(c for c, away in distances.items() if away <= least * (1.0 + EQUAL))

    def contact(self, u, obstacles, multipliers):
        """Gaps G, C = -dG/du and the curvature -sum Lam_j d2G_j/du2 at displacements `u`."""
        raw = self.merge.T @ multipliers
        gaps = np.zeros(len(self.raw))
        coupling, curvature = [], []
        for faces, obstacle in zip(self.faces, obstacles):
            area, distance, normal, bend = self.probe(faces, obstacle, u)
            of_faces = np.einsum("fq,qk,fq->fk", area.value, self.psi, distance)
            np.add.at(gaps, faces.functions.ravel(), of_faces.ravel())
            dofs = (self.dim * faces.nodes[..., None] + np.arange(self.dim)).reshape(len(faces.nodes), -1)
            size = dofs.shape[1]
            rows = -self.slopes(area, distance, normal)
            coupling.append((faces.functions, dofs, rows.reshape(len(dofs), -1, size)))
            block = -self.bends(area, raw[faces.functions] @ self.psi.T, (distance, normal, bend))
            curvature.append((dofs, dofs, block.reshape(len(dofs), size, size)))
        unknowns = self.dim * len(self.mesh.nodes)
        c = matrix(coupling, (len(self.raw), unknowns))
        return self.merge @ gaps, (self.merge @ c).tocsr(), matrix(curvature, (unknowns, unknowns))

    def slopes(self, area, distance, normal):
        """int psi_k (n . v da + d da(v)) of the functions and displacements of each facet [f, k, a, i]."""
        slopes = np.einsum("fq,qk,qa,fqi->fkai", area.value, self.psi, self.shapes, normal, optimize=True)
        if area.slope is not None:
            slopes += np.einsum("fq,qk,fqai->fkai", distance, self.psi, area.slope, optimize=True)
        return slopes

    def bends(self, area, pressure, probed):
        """int lambda (v . d2d w da + n . v da(w) + n . w da(v) + d d2a(v, w)) of each facet [f, a, i, b, j]."""
        distance, normal, bend = probed
        bends = np.einsum(
            "fq,qa,qb,fqij->faibj", pressure * area.value, self.shapes, self.shapes, bend, optimize=True
        )
        if area.slope is not None:
            turned = np.einsum("fq,qa,fqi,fqbj->faibj", pressure, self.shapes, normal, area.slope, optimize=True)
            bends += turned + turned.transpose(0, 3, 4, 1, 2) + area.curvature(pressure * distance)
        return bends

    def probe(self, faces, obstacle, u):
        """Area, distance [f, q], normal [f, q, dim] and curvature [f, q, dim, dim]."""
        places = self.mesh.nodes[faces.nodes] + u.reshape(-1, self.dim)[faces.nodes]
        x = np.zeros((len(faces.nodes), len(self.weights), 3))
        x[..., : self.dim] = np.einsum("qa,fai->fqi", self.shapes, places)
        distance, normal, bend = obstacle.probe(x.reshape(-1, 3))
        shape = x.shape[:2]
        normal = normal.reshape(*shape, 3)[..., : self.dim]
        bend = bend.reshape(*shape, 3, 3)[..., : self.dim, : self.dim]
        return self.measure.area(faces.measure, places), distance.reshape(shape), normal, bend

    def forces(self, u, obstacles, multipliers):
        """Force of each obstacle on the body [3]: int lambda n da."""
        raw = self.merge.T @ multipliers
        forces = []
        for faces, obstacle in zip(self.faces, obstacles):
            area, _, normal, _ = self.probe(faces, obstacle, u)
            pressed = area.value * (raw[faces.functions] @ self.psi.T)
            force = np.zeros(3)
            force[: self.dim] = np.einsum("fq,fqi->i", pressed, normal)
            forces.append(force)
        return forces


def group(cluster):
    """Raw functions of each cluster."""
    members = {}
    for raw, number in enumerate(cluster):
        members.setdefault(number, []).append(raw)
    return members.values()


def matrix(parts, shape):
    if not parts:
        return sp.csr_matrix(shape)
    rows, columns, values = [], [], []
    for row, column, value in parts:
        rows.append(np.broadcast_to(row[:, :, None], value.shape).ravel())
        columns.append(np.broadcast_to(column[:, None, :], value.shape).ravel())
        values.append(value.ravel())
    entries = np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))
    return sp.coo_matrix(entries, shape=shape).tocsr()
