"""Scenes and meshes that every peer solves: the definitions of client/examples and of src/element/manufactured.rs.

cube-bend   unit cube, u = 0 on x0, traction (0, 0, -1) on x1, shear modulus 1, incompressible
A1m         the same cube with u = curl(0, x^3 y z^2, x^3 sin(pi y) cos z), p = cos(pi x) y z: loads and tractions
            follow, u = 0 on x0; sigma = 2 eps(u) - p I, p > 0 in compression
hertz-plane quarter of half a ball, flat top held, a rigid plane pressed up by 0.05
hertz-sphere quarter of a block, base held, a rigid sphere of radius 1 pressed down by 0.05
mr-uniax    unit cube of Mooney and Rivlin between frictionless planes, the upper one pressed down by 0.25 in 5 increments
mr-block    the same cube with its base held, in 10 increments
mr-sphere   the block of hertz-sphere of that material, pressed by 0.125 in 5 increments
"""
import itertools
import os
from dataclasses import dataclass

import numpy as np

SIDES = ("x0", "x1", "y0", "y1", "z0", "z1")
HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.normpath(os.path.join(HERE, "..", "..", ".."))
SHIPPED = os.path.join(ROOT, "client", "examples", "meshes")

# Norms of the exact field A1m: errors are divided by them.
A1M_NORMS = {"displacement_l2": 1.2205366, "displacement_h1": 5.3737919, "pressure_l2": 0.2357023}
DEPTH = 0.05
# How many times the model fills the body.
WHOLE_BODY = {"hertz-plane": 4.0, "hertz-sphere": 4.0, "mr-sphere": 4.0, "mr-block": 1.0, "mr-uniax": 1.0, "cube-drag": 1.0, "hertz-press": 4.0}
# Travel and increments of the scenes of rubber, and their coefficients of Mooney and Rivlin.
TRAVEL = {"mr-sphere": (0.125, 5), "mr-block": (0.25, 10), "mr-uniax": (0.25, 5)}
C10, C01 = 0.4, 0.1


@dataclass
class Grid:
    """points [n, 3], cells [m, 4], facets [k, 3] with the name of the side of each."""

    points: np.ndarray
    cells: np.ndarray
    facets: np.ndarray
    sides: list


def cube(count):
    """count^3 cells of six Kuhn tetrahedra, numbered as client/bench/src/cube.rs numbers them."""
    side = count + 1
    z, y, x = np.meshgrid(*[np.arange(side)] * 3, indexing="ij")
    points = np.stack([x.ravel(), y.ravel(), z.ravel()], axis=1) / count
    corner = np.stack([a.ravel() for a in np.meshgrid(*[np.arange(count)] * 3, indexing="ij")], axis=1)[:, ::-1]
    number = lambda place: place[:, 0] + side * (place[:, 1] + side * place[:, 2])
    cells = []
    for walk in itertools.permutations(range(3)):
        place, corners = corner.copy(), [number(corner)]
        for axis in walk:
            place = place.copy()
            place[:, axis] += 1
            corners.append(number(place))
        if np.linalg.det(np.eye(3)[list(walk)]) < 0:
            corners[2], corners[3] = corners[3], corners[2]
        cells.append(np.stack(corners, axis=1))
    cells = np.stack(cells, axis=1).reshape(-1, 4)
    facets, sides = [], []
    for local in ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)):
        triangles = cells[:, local]
        for axis in range(3):
            for end in (0, 1):
                here = triangles[(points[triangles][:, :, axis] == end).all(axis=1)]
                facets.append(here)
                sides += [SIDES[2 * axis + end]] * len(here)
    return Grid(points, cells, np.concatenate(facets), sides)


def gmsh_file(path):
    """A Gmsh file of first order with named surfaces; needs the package gmsh."""
    import gmsh

    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.open(path)
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    where = np.zeros(int(tags.max()) + 1, dtype=np.int64)
    where[tags.astype(np.int64)] = np.arange(len(tags))
    elements = lambda dim, kind, entity: where[
        gmsh.model.mesh.getElementsByType(kind, entity)[1].astype(np.int64)
    ].reshape(-1, dim + 1)
    cells = np.concatenate([elements(3, 4, entity) for _, entity in gmsh.model.getEntities(3)])
    facets, sides = [], []
    for _, group in gmsh.model.getPhysicalGroups(2):
        name = gmsh.model.getPhysicalName(2, group)
        for entity in gmsh.model.getEntitiesForPhysicalGroup(2, group):
            triangles = elements(2, 2, entity)
            facets.append(triangles)
            sides += [name] * len(triangles)
    gmsh.finalize()
    points = np.asarray(coordinates).reshape(-1, 3)
    used = np.unique(cells)
    renumber = np.zeros(len(points), dtype=np.int64)
    renumber[used] = np.arange(len(used))
    return Grid(points[used], renumber[cells], renumber[np.concatenate(facets)], sides)


PREFIX = {"hertz-plane": "hemi", "hertz-press": "hemi", "hertz-sphere": "indent", "mr-sphere": "indent"}


def grid(scene, level, meshes=None):
    """The mesh of a level: n6 for cubes, l3 for Gmsh meshes (of the folder `meshes`, else those of this repository)."""
    if level[0] == "n":
        return cube(int(level[1:]))
    name = f"{PREFIX[scene]}_{level}.msh"
    own = os.path.join(meshes, name) if meshes else ""
    return gmsh_file(own if os.path.exists(own) else os.path.join(SHIPPED, name))
