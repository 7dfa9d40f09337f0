"""Energy, forces, volume defects and tangent of a body of P2 displacements and P1 pressures.

    E(u, p) = int W(H) - p j(H) - p^2 / (2 K) dX,   B = d2E / dp du,   S = int phi phi / K
"""
import itertools
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from saddle_rule import p2_slopes, rule

# Points whose tangents are held at a time.
CHUNK = 20000


@dataclass
class Response:
    """At a state: energy, forces dE/du, defects dE/dp, K = d2E/du2, B, S and the least J."""

    energy: float
    forces: np.ndarray
    defects: np.ndarray
    stiffness: sp.csr_matrix
    divergence: sp.csr_matrix
    compressibility: sp.csr_matrix
    least_jacobian: float


class Body:
    """Cells with their laws; `laws` by name of the group of cells."""

    def __init__(self, mesh, laws, degree, mixed):
        self.mesh, self.mixed, self.dim = mesh, mixed, mesh.dim
        corners = mesh.points[mesh.cells]
        sides = np.swapaxes(corners[:, 1:] - corners[:, :1], 1, 2)
        self.measure = np.abs(np.linalg.det(sides)) / (2.0 if mesh.dim == 2 else 6.0)
        inner = np.linalg.inv(sides)
        self.slopes = np.concatenate([-inner.sum(axis=1, keepdims=True), inner], axis=1)
        self.points, self.weights = rule(mesh.dim + 1, degree)
        self.table = p2_slopes(self.points)
        self.parts = [(laws[name], cells) for name, cells in mesh.cell_groups.items() if name in laws]
        self.displacements = mesh.dim * len(mesh.nodes)
        self.pressures = len(mesh.points) if mixed else 0

    def dofs(self, nodes):
        return (self.dim * nodes[..., None] + np.arange(self.dim)).reshape(*nodes.shape[:-1], -1)

    def respond(self, u, p):
        """Everything at displacements `u` and pressures `p`."""
        total = Total(self)
        step = max(1, CHUNK // len(self.weights))
        for law, cells in self.parts:
            for start in range(0, len(cells), step):
                self.add(law, cells[start : start + step], u, p, total)
        return total.response()

    def add(self, law, cells, u, p, total):
        nodes, corners = self.mesh.cell_nodes[cells], self.mesh.cells[cells]
        gradients, weights = self.gradients(cells), self.weigh(cells)
        flat = self.strain(gradients, u.reshape(-1, self.dim)[nodes]).reshape(-1, 3, 3)
        energy, stress, tangent = law.response(flat)
        change, slope, second = law.volume(flat)
        pressure = np.zeros(weights.shape)
        if self.mixed:
            pressure = p[corners] @ self.points.T
            energy = energy - pressure.ravel() * (change + 0.5 * pressure.ravel() * law.inverse_bulk)
        stress = stress - pressure.reshape(-1, 1, 1) * slope
        tangent = tangent - pressure.reshape(-1, 1, 1, 1, 1) * second
        total.energy += energy @ weights.ravel()
        if law.is_rubber:
            total.least = min(total.least, 1.0 + change.min())
        forces = np.einsum("eq,eqai->eai", weights, self.against(gradients, stress), optimize=True)
        total.add_forces(self.dofs(nodes), forces)
        total.add_stiffness(self.dofs(nodes), self.blocks(gradients, weights, tangent))
        if self.mixed:
            slope = self.against(gradients, slope)
            volumes = np.einsum("eq,qv,eqai->evai", weights, self.points, slope, optimize=True)
            change = change.reshape(weights.shape) + pressure * law.inverse_bulk
            total.add_volumes(corners, self.dofs(nodes), -volumes, -(weights * change) @ self.points)
            masses = np.einsum("eq,qv,qw->evw", weights, self.points, self.points) * law.inverse_bulk
            total.add_masses(corners, masses)

    def weigh(self, cells):
        """Volume of each point [e, q]."""
        return np.outer(self.measure[cells], self.weights)

    def gradients(self, cells):
        """Of the nodes' functions [e, q, a, d]."""
        return np.einsum("qak,ekd->eqad", self.table, self.slopes[cells])

    def strain(self, gradients, moved):
        """The displacement gradient H [e, q, 3, 3] of nodes moved by [e, a, i]."""
        h = np.zeros((*gradients.shape[:2], 3, 3))
        h[..., : self.dim, : self.dim] = np.einsum("eqad,eai->eqid", gradients, moved)
        return h

    def against(self, gradients, tensor):
        """A tensor [e q, 3, 3] against the gradients of the nodes' motions [e, q, a, i]."""
        tensor = tensor[:, : self.dim, : self.dim].reshape(*gradients.shape[:2], self.dim, self.dim)
        return np.einsum("eqid,eqad->eqai", tensor, gradients, optimize=True)

    def least_within(self, u):
        """The least J of all cells on a grid of each, vertices too: the points of the rule may not see a cell turn."""
        points = lattice(self.dim + 1)
        gradients = np.einsum("qak,ekd->eqad", p2_slopes(points), self.slopes)
        moved = u.reshape(-1, self.dim)[self.mesh.cell_nodes]
        flat = np.einsum("eqad,eai->eqid", gradients, moved) + np.eye(self.dim)
        return float((np.linalg.det(flat) * self.around(points, moved)).min())

    def around(self, _points, _moved):
        """Stretch out of the plane."""
        return 1.0

    def blocks(self, gradients, weights, tangent):
        """Stiffness of each cell [cells, nodes * dim, nodes * dim]."""
        dim, (count, points, nodes, _) = self.dim, gradients.shape
        tangent = tangent[:, :dim, :dim, :dim, :dim].reshape(count, points, dim, dim, dim, dim)
        # [cell, point, d, i k f] with the weight.
        turned = np.transpose(tangent, (0, 1, 3, 2, 4, 5)) * weights[:, :, None, None, None, None]
        left = gradients @ turned.reshape(count, points, dim, dim**3)
        left = left.reshape(count, points, nodes * dim * dim, dim)
        full = (left @ np.swapaxes(gradients, 2, 3)).sum(axis=1)
        full = full.reshape(count, nodes, dim, dim, nodes)
        return np.transpose(full, (0, 1, 2, 4, 3)).reshape(count, nodes * dim, nodes * dim)


def lattice(corners, parts=6):
    """Barycentric points of a regular grid [n, corners]."""
    places = itertools.product(range(parts + 1), repeat=corners - 1)
    return np.array([[*x, parts - sum(x)] for x in places if sum(x) <= parts]) / parts


class Total:
    """Sums over cells."""

    def __init__(self, body):
        self.body, self.energy, self.least = body, 0.0, float("inf")
        self.forces = np.zeros(body.displacements)
        self.defects = np.zeros(body.pressures)
        self.entries = {"stiffness": [], "divergence": [], "masses": []}

    def add_forces(self, dofs, values):
        np.add.at(self.forces, dofs.ravel(), values.ravel())

    def add_stiffness(self, dofs, values):
        self.entries["stiffness"].append(spread(dofs, dofs, values))

    def add_volumes(self, corners, dofs, values, defects):
        flat = values.reshape(len(corners), corners.shape[1], -1)
        self.entries["divergence"].append(spread(corners, dofs, flat))
        np.add.at(self.defects, corners.ravel(), defects.ravel())

    def add_masses(self, corners, values):
        self.entries["masses"].append(spread(corners, corners, values))

    def matrix(self, name, shape):
        parts = self.entries[name]
        if not parts:
            return sp.csr_matrix(shape)
        rows, columns, values = (np.concatenate([part[k] for part in parts]) for k in range(3))
        return sp.coo_matrix((values, (rows, columns)), shape=shape).tocsr()

    def response(self):
        u, p = self.body.displacements, self.body.pressures
        return Response(
            self.energy, self.forces, self.defects, self.matrix("stiffness", (u, u)),
            self.matrix("divergence", (p, u)), self.matrix("masses", (p, p)), self.least,
        )


def spread(rows, columns, values):
    """Rows, columns and values of element matrices, one after the other."""
    shape = values.shape
    return (
        np.broadcast_to(rows[:, :, None], shape).ravel(),
        np.broadcast_to(columns[:, None, :], shape).ravel(),
        values.ravel(),
    )
