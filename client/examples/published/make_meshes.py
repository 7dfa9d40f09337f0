#!/usr/bin/env python3
"""Meshes of the published cases. usage: make_meshes.py [OUTDIR [FACTOR]]

FACTOR (1) multiplies the sizes of all cells. Needs `pip install gmsh`. Curved edges are of second order;
lengths are those of the sources.
"""
import math
import sys
from itertools import pairwise
from pathlib import Path

import gmsh

OUT = Path(sys.argv[1] if len(sys.argv) > 1 else Path(__file__).parent / "meshes")
FACTOR = float(sys.argv[2]) if len(sys.argv) > 2 else 1.0
PLANE = gmsh.model.geo


def points(places, sizes):
    return [PLANE.addPoint(x, y, 0, size) for (x, y), size in zip(places, sizes)]


def lines(ends):
    return [PLANE.addLine(a, b) for a, b in pairwise(ends)]


def surface(*loops):
    return PLANE.addPlaneSurface([PLANE.addCurveLoop(loop, reorient=True) for loop in loops])


def groups(cells, facets):
    """Names groups of surfaces and of curves."""
    PLANE.synchronize()
    for dimension, named in [(2, cells), (1, facets)]:
        for group, entities in named.items():
            gmsh.model.addPhysicalGroup(dimension, entities, name=group)


def settings(order):
    for name, value in [
        ("MshFileVersion", 4.1),
        ("Binary", 1),
        ("ElementOrder", order),
        ("SecondOrderLinear", 0),
        ("MeshSizeFactor", FACTOR),
    ]:
        gmsh.option.setNumber(f"Mesh.{name}", value)


def write(name, cells, facets, order=2):
    """Meshes groups of surfaces and of curves, and writes them."""
    groups(cells, facets)
    finish(name, 2, order)


def finish(name, dimension, order):
    settings(order)
    gmsh.model.mesh.generate(dimension)
    gmsh.write(str(OUT / f"{name}.msh"))


def quarter(name, radius, corners, size_inside):
    """A quarter of a disc, x and y above zero, with the sizes at its two ends; x0, y0, rim."""
    sizes = [size_inside, *corners]
    middle, right, top = points([(0, 0), (radius, 0), (0, radius)], sizes)
    bottom, side = PLANE.addLine(middle, right), PLANE.addLine(top, middle)
    rim = PLANE.addCircleArc(right, middle, top)
    body = surface([bottom, rim, side])
    write(name, {"rubber": [body]}, {"x0": [side], "y0": [bottom], "rim": [rim]})


def half_disc(name, radius, touched, sizes):
    """The lower right quarter of a disc, its cells smallest where its rim is `touched`; x0, top, rim."""
    pole, inside = sizes
    angle = touched / radius
    edge = (radius * math.sin(angle), -radius * math.cos(angle))
    places = [(0, 0), (radius, 0), edge, (0, -radius), (0, touched - radius)]
    middle, right, end, low, above = points(places, [inside, inside, pole, pole, pole])
    top, beside, side = PLANE.addLine(middle, right), PLANE.addLine(low, above), PLANE.addLine(above, middle)
    rim = [PLANE.addCircleArc(low, middle, end), PLANE.addCircleArc(end, middle, right)]
    body = surface([top, *rim, beside, side])
    write(name, {"body": [body]}, {"x0": [beside, side], "top": [top], "rim": rim})


def half_ring(radii, sizes):
    """Right halves of circles about the origin, outwards: their arcs and the gaps between them on x = 0."""
    middle = PLANE.addPoint(0, 0, 0, sizes[0])
    ends = [points([(0, -r), (r, 0), (0, r)], [size, size, size]) for r, size in zip(radii, sizes)]
    arcs = [[PLANE.addCircleArc(a, middle, b) for a, b in pairwise(end)] for end in ends]
    gaps = [
        [PLANE.addLine(inner[0], outer[0]), PLANE.addLine(inner[2], outer[2])]
        for inner, outer in pairwise(ends)
    ]
    return arcs, gaps


def roller():
    """Rubber from 35 to 70 mm of diameter."""
    (bore, tread), (gap,) = half_ring([17.5, 35], [4.5, 2.2])
    body = surface(bore + gap + tread)
    write("roller", {"rubber": [body]}, {"x0": gap, "bore": bore, "tread": tread})


def coated_roller():
    """Rubber from 30 to 65 mm of diameter in a ring of 2.5 mm."""
    (bore, seam, tread), (inner, outer) = half_ring([15, 32.5, 35], [4.5, 2, 2])
    cells = {"rubber": [surface(bore + inner + seam)], "coat": [surface(seam + outer + tread)]}
    write("coated-roller", cells, {"x0": inner + outer, "bore": bore, "tread": tread})


def wave():
    """Half a wave of length one and height 0.002 on a block of depth one; the crest is at x = 0."""
    ends = points([(0, 0), (0.5, 0), (0.5, 1), (0, 1)], [0.12, 0.12, 0.0125, 0.0125])
    bottom, right, top, left = lines(ends + ends[:1])
    body = surface([bottom, right, top, left])
    facets = {"bottom": [bottom], "right": [right], "wave": [top], "left": [left]}
    groups({"body": [body]}, facets)
    settings(2)
    gmsh.model.mesh.generate(2)
    nodes, places, _ = gmsh.model.mesh.getNodes()
    for node, (x, y, _) in zip(nodes, places.reshape(-1, 3)):
        gmsh.model.mesh.setNode(node, [x, y * (1 + 0.002 * math.cos(math.tau * x)), 0], [])
    gmsh.write(str(OUT / "wave.msh"))


def gasket():
    """Right half of a gasket, 8 mm wide, 4 mm high at its sides and 6 mm in the middle, crowned above and below."""
    ends = points([(0, -3), (4, -2), (4, 2), (0, 3)], [0.3, 0.4, 0.4, 0.3])
    low, high = points([(0, 5.5), (0, -5.5)], [1, 1])
    below, above = PLANE.addCircleArc(ends[0], low, ends[1]), PLANE.addCircleArc(ends[2], high, ends[3])
    side, axis = PLANE.addLine(ends[1], ends[2]), PLANE.addLine(ends[3], ends[0])
    body = surface([below, side, above, axis])
    write("gasket", {"rubber": [body]}, {"x0": [axis], "low": [below], "side": [side], "high": [above]})


def bearing():
    """Right half of two layers of rubber of 2 mm, 20 mm wide, with a sheet of steel of 1 mm between them."""
    heights = [0, 2, 3, 5]
    left = points([(0, y) for y in heights], [0.5] * 4)
    right = points([(10, y) for y in heights], [0.5] * 4)
    levels = [PLANE.addLine(a, b) for a, b in zip(left, right)]
    axis, free = lines(left), lines(right)
    layers = [surface([levels[k], free[k], levels[k + 1], axis[k]]) for k in range(3)]
    cells = {"rubber": [layers[0], layers[2]], "steel": layers[1:2]}
    write("bearing", cells, {"x0": axis, "floor": levels[:1], "lid": levels[3:]}, order=1)


def bar():
    """Section of a round bar of radius and height one."""
    ends = points([(0, 0), (1, 0), (1, 1), (0, 1)], [0.5] * 4)
    bottom, side, top, axis = lines(ends + ends[:1])
    body = surface([bottom, side, top, axis])
    write("bar", {"rubber": [body]}, {"axis": [axis], "low": [bottom], "high": [top]}, order=1)


def ball():
    """An eighth of a ball of radius 5, z below zero."""
    shape = gmsh.model.occ
    whole = shape.addSphere(0, 0, 0, 5)
    block = shape.addBox(0, 0, -6, 6, 6, 6)
    (solid,), _ = shape.intersect([(3, whole)], [(3, block)])
    shape.synchronize()
    gmsh.model.addPhysicalGroup(3, [solid[1]], name="rubber")
    for _, face in gmsh.model.getEntities(2):
        centre = gmsh.model.occ.getCenterOfMass(2, face)
        flat = [axis for axis, x in zip("xyz", centre) if abs(x) < 1e-6]
        gmsh.model.addPhysicalGroup(2, [face], name=f"{flat[0]}0" if flat else "rim")
    gmsh.option.setNumber("Mesh.MeshSizeMin", 0.95)
    gmsh.option.setNumber("Mesh.MeshSizeMax", 0.95)
    finish("ball", 3, 2)


MAKE = [
    lambda: quarter("cylinder", 200, [22, 11], 30),
    lambda: quarter("ball-section", 5, [0.6, 0.3], 0.7),
    lambda: half_disc("hertz", 8, 0.8, [0.068, 1.2]),
    lambda: half_disc("spheres", 50, 12, [0.9, 6]),
    roller,
    coated_roller,
    wave,
    gasket,
    bearing,
    bar,
    ball,
]

for make in MAKE:
    gmsh.initialize(["gmsh", "-v", "2"])
    make()
    gmsh.finalize()
