"""What obstacles look like beside the body, for pictures; shapes that are not drawn are left out.

Infinite shapes are drawn as the piece beside the body.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import numpy.typing as npt

from ._solution import Increment, Solution

Floats = npt.NDArray[np.float64]


def outlines(result: Solution, increment: Increment, body: Any) -> Iterator[Any]:
    """A `pyvista.PolyData` for each obstacle that is drawn, where it is."""
    draw = flat if result.mesh.dimension == 2 else solid
    shapes = {one.name: one.shape for one in result.scene.obstacles}
    for pose in increment.report.obstacle_poses:
        shape = shapes[pose.name]
        kind = str(shape.WhichOneof("kind"))
        drawn = draw(kind, getattr(shape, kind), pose.translation, turn(pose.rotation), body)
        if drawn is not None:
            yield drawn


def turn(vector: Floats) -> Floats:
    """The matrix of a rotation vector."""
    angle = float(np.linalg.norm(vector))
    if angle == 0.0:
        return np.eye(3)
    x, y, z = vector / angle
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.asarray(np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross)


def foot(point: Floats, normal: Floats, body: Any) -> Floats:
    """The point of a plane nearest to the middle of the body."""
    middle = np.array(body.center)
    return np.asarray(middle - normal * ((middle - point) @ normal))


def flat(kind: str, shape: Any, shift: Floats, turned: Floats, body: Any) -> Any:
    """Lines and circles of the plane z = 0."""
    import pyvista as pv

    if kind == "half_space":
        normal = turned @ shape.normal / np.linalg.norm(shape.normal)
        along = np.array([-normal[1], normal[0], 0.0]) * body.length
        middle = foot(np.array(shape.point) + shift, normal, body)
        return pv.Line(middle - along, middle + along)
    centre = {"sphere": "centre", "cylinder": "point"}.get(kind)
    if centre is None:
        return None
    around = np.linspace(0, 2 * np.pi, 361)
    circle = np.stack([np.cos(around), np.sin(around), np.zeros_like(around)], axis=1)
    return pv.lines_from_points(np.array(getattr(shape, centre)) + shift + shape.radius * circle)


def solid(kind: str, shape: Any, shift: Floats, turned: Floats, body: Any) -> Any:
    """Squares, balls and tubes."""
    import pyvista as pv

    size = 1.5 * body.length
    if kind == "half_space":
        normal = turned @ shape.normal / np.linalg.norm(shape.normal)
        middle = foot(np.array(shape.point) + shift, normal, body)
        return pv.Plane(middle, normal, i_size=size, j_size=size, i_resolution=1, j_resolution=1)
    if kind == "sphere":
        centre = np.array(shape.centre) + shift
        return pv.Sphere(radius=shape.radius, center=centre, theta_resolution=90, phi_resolution=90)
    if kind == "cylinder":
        axis = turned @ shape.axis / np.linalg.norm(shape.axis)
        point = np.array(shape.point) + shift
        middle = point + axis * ((np.array(body.center) - point) @ axis)
        return pv.Cylinder(
            center=middle, direction=axis, radius=shape.radius, height=size, resolution=180, capping=False
        )
    return None
