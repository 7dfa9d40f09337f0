"""Meshes of the scripts: boxes without further packages, curved bodies by `pip install gmsh`. Each function gives a file."""
import math

import numpy as np

from common import FOLDER
from family_mesh import Box


def box(name, counts, sizes, move=None):
    """Triangles or tetrahedra in [0, sizes], groups x0 .. z1; `move` maps points [n, dim] to others."""
    path = FOLDER / f"{name}.msh"
    made = Box(sizes, counts, 0.0, False, np.random.default_rng(1))
    if move:
        made.points = move(made.points)
    made.write(path)
    return path


def column(name, counts, sizes, bow=0.0):
    """A plane column whose middle stands beside its ends by `bow`."""
    bent = lambda p: p + np.c_[bow * (0.5 - 0.5 * np.cos(2 * math.pi * p[:, 1] / sizes[1])), np.zeros(len(p))]
    return box(name, counts, sizes, bent)


def shell(name, count):
    """A quarter of a ring of radii 1 and 2: x0 inside, x1 outside, y0 on the first axis, y1 on the second."""
    turn = lambda p: (1 + p[:, :1]) * np.c_[np.cos(0.5 * math.pi * p[:, 1]), np.sin(0.5 * math.pi * p[:, 1])]
    return box(name, [count, count], [1.0, 1.0], turn)


def drawn(name, dim, draw, order=1, size=None):
    """What `draw(model)` draws with Gmsh; it gives groups of boundary parts by name. `size(x, y, z)` is that of cells."""
    import gmsh

    gmsh.initialize()
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        for key, value in {"MshFileVersion": 2.2, "RandomSeed": 1, "MeshSizeExtendFromBoundary": 0 if size else 1}.items():
            gmsh.option.setNumber("Mesh." + key, value)
        groups = draw(gmsh)
        for group, parts in groups.items():
            gmsh.model.addPhysicalGroup(dim - 1, parts, name=group)
        gmsh.model.addPhysicalGroup(dim, [tag for _, tag in gmsh.model.getEntities(dim)], name="body")
        if size:
            gmsh.model.mesh.setSizeCallback(lambda d, tag, x, y, z, old: size(x, y, z))
        gmsh.model.mesh.generate(dim)
        gmsh.model.mesh.setOrder(order)
        path = FOLDER / f"{name}.msh"
        gmsh.write(str(path))
    finally:
        gmsh.finalize()
    return path


def boundary(gmsh, dim, name_of):
    """Groups of the boundary by `name_of(lower corner, upper corner)` of each part."""
    groups = {}
    for _, tag in gmsh.model.getEntities(dim - 1):
        bounds = gmsh.model.getBoundingBox(dim - 1, tag)
        groups.setdefault(name_of(bounds[:3], bounds[3:]), []).append(tag)
    return groups


def flat_sides(rest):
    """Names x0, y0, z0 of parts on the planes through the origin, `rest` of all others."""
    return lambda low, high: next((f"{a}0" for a, x in zip("xyz", high) if x < 1e-5), rest)


def quarter_disc(name, size, order):
    """Of radius 1, groups x0, y0, rim."""
    def draw(gmsh):
        occ = gmsh.model.occ
        disc, square = occ.addDisk(0, 0, 0, 1, 1), occ.addRectangle(0, 0, 0, 2, 2)
        occ.intersect([(2, disc)], [(2, square)])
        occ.synchronize()
        return boundary(gmsh, 2, lambda low, high: "x0" if high[0] < 1e-5 else "y0" if high[1] < 1e-5 else "rim")
    return drawn(name, 2, draw, order, size)


def eighth_ball(name, size, order):
    """Of radius 1, groups x0, y0, z0, rim."""
    def draw(gmsh):
        occ = gmsh.model.occ
        occ.intersect([(3, occ.addSphere(0, 0, 0, 1))], [(3, occ.addBox(0, 0, 0, 2, 2, 2))])
        occ.synchronize()
        return boundary(gmsh, 3, flat_sides("rim"))
    return drawn(name, 3, draw, order, size)


def quarter_ring(name, facets, order):
    """Of radii 1 and 2 with `facets` a whole circle, in rows; groups x0, y0, inner, outer."""
    def draw(gmsh):
        geo = gmsh.model.geo
        centre = geo.addPoint(0, 0, 0)
        ends = [geo.addPoint(*at, 0) for at in ((1, 0), (2, 0), (0, 2), (0, 1))]
        y0, x0 = geo.addLine(ends[0], ends[1]), geo.addLine(ends[2], ends[3])
        outer, inner = geo.addCircleArc(ends[1], centre, ends[2]), geo.addCircleArc(ends[3], centre, ends[0])
        ring = geo.addPlaneSurface([geo.addCurveLoop([y0, outer, x0, inner])])
        for curve, count in ((y0, facets // 8), (x0, facets // 8), (outer, facets // 4), (inner, facets // 4)):
            geo.mesh.setTransfiniteCurve(curve, count + 1)
        geo.mesh.setTransfiniteSurface(ring)
        geo.synchronize()
        return {"x0": [x0], "y0": [y0], "inner": [inner], "outer": [outer]}
    return drawn(name, 2, draw, order)


def ring_section(name, size, half):
    """Section of an O-ring of 50 x 5.33 mm, whole or its upper half (group cut); group skin."""
    def draw(gmsh):
        occ = gmsh.model.occ
        disc = occ.addDisk(27.665, 0, 0, 2.665, 2.665)
        if half:
            occ.intersect([(2, disc)], [(2, occ.addRectangle(20, 0, 0, 20, 5))])
        occ.synchronize()
        gmsh.option.setNumber("Mesh.MeshSizeMax", size)
        return boundary(gmsh, 2, lambda low, high: "cut" if high[1] < 1e-5 else "skin")
    return drawn(name, 2, draw)


def half_bush(name, size):
    """Half (y >= 0) of a tube of radii 10 and 20, 30 long: groups pin, sleeve, cut, ends."""
    def draw(gmsh):
        occ = gmsh.model.occ
        tube = occ.cut([(3, occ.addCylinder(0, 0, 0, 0, 0, 30, 20))], [(3, occ.addCylinder(0, 0, 0, 0, 0, 30, 10))])[0]
        occ.intersect(tube, [(3, occ.addBox(-30, 0, -1, 60, 30, 40))])
        occ.synchronize()
        gmsh.option.setNumber("Mesh.MeshSizeMax", size)
        def name_of(low, high):
            if high[2] - low[2] < 1e-5:
                return "ends"
            return "cut" if high[1] < 1e-5 else "pin" if high[0] < 15 else "sleeve"
        return boundary(gmsh, 3, name_of)
    return drawn(name, 3, draw)
