"""Rigid obstacles as signed distances d(x) > 0 on the free side, with normals and curvatures, in moved poses."""
from dataclasses import dataclass

import numpy as np


@dataclass
class Obstacle:
    """Kind, reference point (point of the plane, centre, point of the axis), direction (normal or axis), radius."""

    kind: str
    point: np.ndarray
    direction: np.ndarray
    radius: float

    def probe(self, x):
        """Distance [n], normal [n, 3] and curvature [n, 3, 3] at points [n, 3]."""
        offset = x - self.point
        if self.kind == "half-space":
            normal = np.broadcast_to(self.direction, x.shape)
            return offset @ self.direction, normal, np.zeros((len(x), 3, 3))
        across = np.eye(3)
        if self.kind == "cylinder":
            across = across - np.outer(self.direction, self.direction)
        offset = offset @ across
        length = np.linalg.norm(offset, axis=1)
        normal = offset / length[:, None]
        curvature = (across - normal[:, :, None] * normal[:, None, :]) / length[:, None, None]
        return length - self.radius, normal, curvature

    def moved(self, translation, rotation):
        """Turned by the rotation vector about the reference point, then shifted."""
        return Obstacle(
            self.kind, self.point + translation, turn(rotation) @ self.direction, self.radius
        )


def turn(vector):
    """The matrix of a rotation vector (Rodrigues)."""
    angle = np.linalg.norm(vector)
    if angle == 0.0:
        return np.eye(3)
    x, y, z = vector / angle
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross


def of(shape):
    """The obstacle of a scene's `shape` table."""
    if shape["kind"] == "torus":
        shape = in_section(shape)
    place, along = {
        "half-space": ("point", "normal"), "sphere": ("centre", None), "cylinder": ("point", "axis"),
    }[shape["kind"]]
    direction = np.array(shape[along], dtype=float) if along else np.array([0.0, 0.0, 1.0])
    direction = direction / np.linalg.norm(direction)
    return Obstacle(shape["kind"], np.array(shape[place], dtype=float), direction, shape.get("radius", 0.0))


def in_section(shape):
    """A torus about the axis y of a body of revolution: a disc of its section x, y."""
    centre = np.array(shape["centre"], dtype=float)
    if centre[0] or centre[2] or np.any(np.cross(shape["axis"], [0.0, 1.0, 0.0])):
        raise ValueError("a torus about the axis y of a body of revolution only")
    point = centre + [shape["radius"], 0.0, 0.0]
    return {"kind": "cylinder", "point": point, "axis": [0.0, 0.0, 1.0], "radius": shape["tube_radius"]}
