"""Bodies of revolution about x = 0 by their section: rings of x = R, with the stretch u_x / R around the axis,

    dV = 2 pi R dA,   H_33 = u_x / R,   da = 2 pi r |t|,   r = sum N_a x_a

All numbers are those of a full turn. Rubber only, as Signorini has no other.
"""
from dataclasses import dataclass

import numpy as np

from saddle_area import Area, Deformed
from saddle_body import Body
from saddle_rule import p2

# Rule of the volume where the scene names none: the stretch around the axis is no polynomial.
DEGREE = 4
TURN = 2.0 * np.pi
# Components of H that a motion of the section has.
ROWS, COLUMNS = [0, 0, 1, 1, 2], [0, 1, 0, 1, 2]


class Revolved(Body):
    """A section; "gradients" are those components of H by motions of the nodes [e, q, 5, a, i]."""

    def __init__(self, mesh, laws, degree, mixed):
        super().__init__(mesh, laws, degree, mixed)
        if not all(law.is_rubber for law in laws.values()):
            raise ValueError("bodies of revolution of rubber only")
        self.radii = mesh.points[mesh.cells][:, :, 0] @ self.points.T
        self.values = p2(self.points)

    def weigh(self, cells):
        return super().weigh(cells) * TURN * self.radii[cells]

    def gradients(self, cells):
        flat = super().gradients(cells)
        motions = np.zeros((*flat.shape[:2], 5, flat.shape[2], 2))
        motions[:, :, [0, 1], :, 0] = np.moveaxis(flat, 3, 0)
        motions[:, :, [2, 3], :, 1] = np.moveaxis(flat, 3, 0)
        motions[:, :, 4, :, 0] = self.values / self.radii[cells][..., None]
        return motions

    def strain(self, gradients, moved):
        h = np.zeros((*gradients.shape[:2], 3, 3))
        h[..., ROWS, COLUMNS] = np.einsum("eqcai,eai->eqc", gradients, moved)
        return h

    def around(self, points, moved):
        return 1.0 + moved[..., 0] @ p2(points).T / (self.mesh.points[self.mesh.cells][:, :, 0] @ points.T)

    def against(self, gradients, tensor):
        tensor = np.broadcast_to(tensor[:, ROWS, COLUMNS], (gradients.shape[0] * gradients.shape[1], 5))
        return np.einsum("eqc,eqcai->eqai", tensor.reshape(gradients.shape[:3]), gradients, optimize=True)

    def blocks(self, gradients, weights, tangent):
        count, points, _, nodes, _ = gradients.shape
        inner = tangent[:, ROWS, COLUMNS][:, :, ROWS, COLUMNS].reshape(count, points, 5, 5)
        inner = inner * weights[:, :, None, None]
        motions = gradients.reshape(count, points, 5, 2 * nodes)
        return (np.swapaxes(motions, 2, 3) @ inner @ motions).sum(axis=1)


@dataclass
class RingArea(Area):
    """2 pi r times the length of `flat`; radius [f, q], values of the nodes' functions [q, a]."""

    flat: Area
    radius: np.ndarray
    values: np.ndarray

    def curvature(self, factor):
        bends = self.flat.curvature(TURN * factor * self.radius)
        mixed = np.einsum("fq,fqai,qb->faib", TURN * factor, self.flat.slope, self.values, optimize=True)
        bends[..., 0] += mixed
        bends[:, :, 0] += np.moveaxis(mixed, 3, 1)
        return bends


class Ring(Deformed):
    """da of the rings where they are."""

    def __init__(self, points, weights):
        super().__init__(points, weights)
        self.values = p2(points)

    def area(self, measure, places):
        flat = super().area(measure, places)
        radius = places[..., 0] @ self.values.T
        slope = radius[..., None, None] * flat.slope
        slope[..., 0] += flat.value[..., None] * self.values
        return RingArea(
            TURN * radius * flat.value, TURN * slope, flat.tangents, flat.gradients, flat, radius, self.values
        )
