"""Bodies whose cells are bent by the middles of their edges: X = sum N_a X_a with the P2 functions, so that

    grad N_a = (dX/dL)^-T dN_a/dL,   dV = det(dX/dL) dL

Linear bodies by a rule of degree 4, rubber by that of straight cells (decision 56). The plane.
"""
import numpy as np

from saddle_body import Body

LINEAR_DEGREE = 4


class Bent(Body):
    """A body with bent edges."""

    def __init__(self, mesh, laws, degree, mixed):
        is_rubber = any(law.is_rubber for law in laws.values())
        super().__init__(mesh, laws, degree if is_rubber else max(degree, LINEAR_DEGREE), mixed)
        # By two of the barycentric coordinates [q, a, j].
        self.by_places = self.table[:, :, 1:] - self.table[:, :, :1]

    def sides(self, cells):
        """dX/dL [e, q, d, j]."""
        return np.einsum("ead,qaj->eqdj", self.mesh.nodes[self.mesh.cell_nodes[cells]], self.by_places)

    def weigh(self, cells):
        return 0.5 * np.abs(np.linalg.det(self.sides(cells))) * self.weights

    def gradients(self, cells):
        return np.einsum("qaj,eqjd->eqad", self.by_places, np.linalg.inv(self.sides(cells)))
