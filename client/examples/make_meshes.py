#!/usr/bin/env python3
"""Meshes of the seals: o-ring, bush, lip, stopper, finger, tyre. usage: make_meshes.py [OUTDIR]

Needs `pip install gmsh`. Lengths in millimetres. Surface edges are straight, cells triangles.
"""
import math
import sys
from pathlib import Path

import gmsh

OUT = Path(sys.argv[1] if len(sys.argv) > 1 else Path(__file__).parent / "meshes")
PLANE = gmsh.model.geo


def points(places, size):
    return [PLANE.addPoint(x, y, 0, size) for x, y in places]


def write(name, surface, groups, order=1):
    """Meshes `surface` and writes it with its groups of curves."""
    PLANE.synchronize()
    gmsh.model.addPhysicalGroup(2, [surface], name="rubber")
    for group, curves in groups.items():
        gmsh.model.addPhysicalGroup(1, curves, name=group)
    gmsh.option.setNumber("Mesh.MshFileVersion", 4.1)
    gmsh.option.setNumber("Mesh.Binary", 1)
    gmsh.option.setNumber("Mesh.ElementOrder", order)
    gmsh.option.setNumber("Mesh.SecondOrderLinear", 0)
    gmsh.model.mesh.generate(2)
    gmsh.write(str(OUT / f"{name}.msh"))


def ring(centre, radii, size, arcs):
    """Closed circles of `radii`, each in four arcs; gives the curves of each."""
    middle = PLANE.addPoint(*centre, 0, size)
    found = []
    for radius in radii:
        places = [
            (centre[0] + radius * math.cos(a), centre[1] + radius * math.sin(a)) for a in arcs
        ]
        ends = points(places, size)
        found.append([PLANE.addCircleArc(a, middle, b) for a, b in zip(ends, ends[1:] + ends[:1])])
    return found


def o_ring():
    """Section of 5.33 mm of a ring of 50 mm inside; the fluid acts on what looks inwards."""
    lip = math.radians(50)
    arcs = [math.pi - lip, math.pi + lip, 1.5 * math.pi, 0.0, 0.5 * math.pi]
    (curves,) = ring((27.665, 0), [2.665], 0.32, arcs)
    surface = PLANE.addPlaneSurface([PLANE.addCurveLoop(curves)])
    write("o-ring", surface, {"wet": curves[:1], "skin": curves}, order=2)


def bush():
    """Section of a bush of 10 mm inside and 20 mm outside."""
    quarters = [0.0, 0.5 * math.pi, math.pi, 1.5 * math.pi]
    bore, sleeve = ring((0, 0), [10, 20], 1.4, quarters)
    loops = [PLANE.addCurveLoop(sleeve), PLANE.addCurveLoop(bore)]
    write("bush", PLANE.addPlaneSurface(loops), {"bore": bore, "sleeve": sleeve}, order=2)


def lip():
    """Section of a lip that is held in a case of 22 mm radius and meets a shaft of 15 mm with an edge of 0.4 mm radius."""
    places = [(22, 0), (22, 7), (20, 7), (20, 2.2), (18.6, 2.6), (16.4, 5.2), (15.48, 5.93), (14.83, 5.57), (15.4, 4.4), (17.6, 0)]
    sizes = [0.8, 0.8, 0.8, 0.6, 0.4, 0.25, 0.06, 0.05, 0.2, 0.6]
    ends = [PLANE.addPoint(x, y, 0, size) for (x, y), size in zip(places, sizes)]
    edge = PLANE.addPoint(15.2, 5.6, 0, 0.06)
    curves = [PLANE.addLine(a, b) for a, b in zip(ends[:6], ends[1:7])]
    curves += [PLANE.addCircleArc(ends[6], edge, ends[7])]
    curves += [PLANE.addLine(a, b) for a, b in zip(ends[7:], ends[8:] + ends[:1])]
    surface = PLANE.addPlaneSurface([PLANE.addCurveLoop(curves)])
    write("lip", surface, {"case": curves[0:3], "lip": curves[5:8]}, order=2)


def stopper():
    """Section of a syringe stopper: two sealing ribs of 7.6 mm radius on a core of 6.6 mm."""
    places = [(0, 0), (6.0, 0), (6.6, 0.4), (7.4, 1.0), (7.6, 1.6), (7.4, 2.2), (6.6, 2.8), (6.6, 5.2),
              (7.4, 5.8), (7.6, 6.4), (7.4, 7.0), (6.6, 7.6), (6.0, 8), (0, 9.5)]
    ends = points(places, 0.4)
    curves = [PLANE.addLine(a, b) for a, b in zip(ends, ends[1:] + ends[:1])]
    surface = PLANE.addPlaneSurface([PLANE.addCurveLoop(curves)])
    groups = {"plunger": curves[:1], "barrel": curves[2:12], "axis": curves[-1:]}
    write("stopper", surface, groups)


def finger():
    """Tip of a soft finger on its bone: 12 mm thick, 30 mm long, rounded."""
    tip = PLANE.addPoint(0, 6, 0, 0.8)
    places = [(-24, 0), (0, 0), (6, 6), (0, 12), (-24, 12)]
    ends = [PLANE.addPoint(x, y, 0, size) for (x, y), size in zip(places, [0.7, 0.7, 1, 2, 2])]
    curves = [
        PLANE.addLine(ends[0], ends[1]),
        PLANE.addCircleArc(ends[1], tip, ends[2]),
        PLANE.addCircleArc(ends[2], tip, ends[3]),
        PLANE.addLine(ends[3], ends[4]),
        PLANE.addLine(ends[4], ends[0]),
    ]
    surface = PLANE.addPlaneSurface([PLANE.addCurveLoop(curves)])
    write("finger", surface, {"pad": curves[0:2], "bone": curves[3:4]}, order=2)


def tyre():
    """Section across a solid tyre of 200 mm, 40 mm thick."""
    fine = [math.radians(a) for a in (-150, -30, 90)]
    rim, tread = ring((0, 0), [60, 100], 9, fine)
    gmsh.model.geo.synchronize()
    gmsh.model.mesh.setSize(gmsh.model.getBoundary([(1, tread[0])]), 5)
    loops = [PLANE.addCurveLoop(tread), PLANE.addCurveLoop(rim)]
    write("tyre", PLANE.addPlaneSurface(loops), {"tread": tread, "rim": rim}, order=2)


for make in (o_ring, bush, lip, stopper, finger, tyre):
    gmsh.initialize(["-v", "2"])
    make()
    gmsh.finalize()
