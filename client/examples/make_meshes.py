#!/usr/bin/env python3
"""Meshes of the seals and soft tools: o-ring, bush, lip, stopper, finger, tyre, belt, gripper, of the seals that fluids
press (seal-ring, backed-ring, lip-seal, syringe, kiss-seal), of the rollers, of the bush in its sleeves, of the bellows, and the surface of the egg that the gripper meets.
usage: make_meshes.py [OUTDIR [FACTOR OF THE SIZES OF THOSE SEALS]]

Needs `pip install gmsh numpy`. Lengths in millimetres.
"""
import math
import struct
import sys
from pathlib import Path

import gmsh
import numpy as np

OUT = Path(sys.argv[1] if len(sys.argv) > 1 else Path(__file__).parent / "meshes")
FACTOR = float(sys.argv[2]) if len(sys.argv) > 2 else 1.0
PLANE = gmsh.model.geo


def points(places, size):
    return [PLANE.addPoint(x, y, 0, size) for x, y in places]


def write(name, surface, groups, order=1):
    """Meshes `surface`, or several by the names of their bodies, and writes it with its groups of curves."""
    PLANE.synchronize()
    for body, one in (surface if isinstance(surface, dict) else {"rubber": surface}).items():
        gmsh.model.addPhysicalGroup(2, [one], name=body)
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


def belt():
    """Strip of 80 mm by 5 mm, fine where a roller passes."""
    places = [(-40, 0), (40, 0), (40, 5), (22, 5), (-22, 5), (-40, 5)]
    ends = [PLANE.addPoint(x, y, 0, size) for (x, y), size in zip(places, [3, 3, 3, 0.8, 0.8, 3])]
    curves = [PLANE.addLine(a, b) for a, b in zip(ends, ends[1:] + ends[:1])]
    surface = PLANE.addPlaneSurface([PLANE.addCurveLoop(curves)])
    groups = {"bed": curves[:1], "ends": [curves[1], curves[5]], "top": curves[2:5]}
    write("belt", surface, groups)


def gripper():
    """Pad of a gripper, half of it: 24 by 8 by 10 mm, its lower face curved about y with 30 mm; y = 0 is its middle."""
    shape = gmsh.model.occ
    block = shape.addBox(-12, 0, 0, 24, 8, 10)
    round_ = shape.addCylinder(0, -1, 30, 0, 10, 0, 30)
    (solid,), _ = shape.intersect([(3, block)], [(3, round_)])
    shape.synchronize()
    sides = {"plate": [], "middle": [], "pad": []}
    for _, face in gmsh.model.getEntities(2):
        x, y, z = gmsh.model.occ.getCenterOfMass(2, face)
        name = "plate" if z > 9.99 else "middle" if y < 0.01 else "pad" if z < 2 and y < 7.9 else None
        if name:
            sides[name].append(face)
    gmsh.model.addPhysicalGroup(3, [solid[1]], name="rubber")
    for name, faces in sides.items():
        gmsh.model.addPhysicalGroup(2, faces, name=name)
    field = gmsh.model.mesh.field
    field.add("MathEval", 1)
    field.setString(1, "F", "1.3 + 0.22 * (x*x/6 + y*y/3 + z*z/3)^0.5")
    field.setAsBackgroundMesh(1)
    gmsh.option.setNumber("Mesh.MeshSizeExtendFromBoundary", 0)
    gmsh.option.setNumber("Mesh.MshFileVersion", 4.1)
    gmsh.option.setNumber("Mesh.Binary", 1)
    gmsh.model.mesh.generate(3)
    gmsh.write(str(OUT / "gripper.msh"))


def seal_ring():
    """Section of an O-ring of 5.33 mm: the fluid comes from the left, the right has to stay dry."""
    wet, dry = math.radians(55), math.radians(60)
    arcs = [math.pi - wet, math.pi + wet, 2 * math.pi - dry, dry]
    (curves,) = ring((27.665, 0), [2.665], 0.22 * FACTOR, arcs)
    surface = PLANE.addPlaneSurface([PLANE.addCurveLoop(curves)])
    write("seal-ring", surface, {"inside": curves[:1], "outside": curves[2:3], "skin": curves}, order=2)


def backed_ring():
    """Section of the same O-ring with a back-up ring of 1.4 x 4.7 mm on its right, corners rounded by 0.3 mm on its side."""
    wet = math.radians(55)
    (curves,) = ring((27.665, 0), [2.665], 0.24 * FACTOR, [math.pi - wet, math.pi + wet, 1.5 * math.pi, 0.0, 0.5 * math.pi])
    left, right, low, high, round = 30.4, 31.8, -2.665, 2.035, 0.3
    ends = points([(right, low), (right, high), (left + round, high), (left, high - round), (left, low + round), (left + round, low)], 0.2 * FACTOR)
    middles = points([(left + round, high - round), (left + round, low + round)], 0.2 * FACTOR)
    line = lambda a, b: PLANE.addLine(ends[a], ends[b])
    arc = lambda a, b, middle: PLANE.addCircleArc(ends[a], middles[middle], ends[b])
    sides = [line(0, 1), line(1, 2), arc(2, 3, 0), line(3, 4), arc(4, 5, 1), line(5, 0)]
    bodies = {name: PLANE.addPlaneSurface([PLANE.addCurveLoop(loop)]) for name, loop in (("rubber", curves), ("back-up", sides))}
    groups = {"inside": curves[:1], "skin": curves, "face": sides[1:5], "back": sides[:1], "seat": sides[5:]}
    write("backed-ring", bodies, groups, order=2)


def lip_seal():
    """Section of a lip that is held in a case of 22 mm radius: oil below it, air above."""
    places = [(22, 0), (22, 7), (20, 7), (20, 2.2), (18.6, 2.6), (16.4, 5.2), (15.48, 5.93), (14.83, 5.57), (15.4, 4.4), (17.6, 0)]
    sizes = [0.8, 0.8, 0.8, 0.6, 0.4, 0.25, 0.05, 0.04, 0.15, 0.6]
    ends = [PLANE.addPoint(x, y, 0, size * FACTOR) for (x, y), size in zip(places, sizes)]
    edge = PLANE.addPoint(15.2, 5.6, 0, 0.05)
    curves = [PLANE.addLine(a, b) for a, b in zip(ends[:6], ends[1:7])]
    curves += [PLANE.addCircleArc(ends[6], edge, ends[7])]
    curves += [PLANE.addLine(a, b) for a, b in zip(ends[7:], ends[8:] + ends[:1])]
    surface = PLANE.addPlaneSurface([PLANE.addCurveLoop(curves)])
    groups = {"case": curves[0:3], "air": curves[3:5], "lip": curves[5:8], "oil": curves[8:9]}
    write("lip-seal", surface, groups, order=2)


def syringe():
    """Section of a stopper with two round ribs: the drug above it, the plunger below."""
    at = lambda x, y, size: PLANE.addPoint(x, y, 0, size * FACTOR)
    places = [(0, 0, 0.5), (6.0, 0, 0.4), (6.6, 0.4, 0.3), (6.6, 0.8, 0.15), (6.6, 2.4, 0.15), (6.6, 5.6, 0.15), (6.6, 7.2, 0.15),
              (6.6, 7.6, 0.3), (6.0, 8, 0.4), (0, 9.5, 0.5)]
    ends = [at(*place) for place in places]
    tops = [at(7.6, 1.6, 0.08), at(7.6, 6.4, 0.08)]
    middles = [at(6.8, 1.6, 1.0), at(6.8, 6.4, 1.0)]
    feet = [[at(6.8, y, 0.12) for y in ys] for ys in ((0.8, 2.4), (5.6, 7.2))]
    curves = [PLANE.addLine(ends[0], ends[1]), PLANE.addLine(ends[1], ends[2]), PLANE.addLine(ends[2], ends[3])]
    for (low, high), foot, top, middle, after in zip((ends[3:5], ends[5:7]), feet, tops, middles, (ends[5], ends[7])):
        curves += [PLANE.addLine(low, foot[0]), PLANE.addCircleArc(foot[0], middle, top), PLANE.addCircleArc(top, middle, foot[1]),
                   PLANE.addLine(foot[1], high), PLANE.addLine(high, after)]
    curves += [PLANE.addLine(a, b) for a, b in zip(ends[7:], ends[8:] + ends[:1])]
    surface = PLANE.addPlaneSurface([PLANE.addCurveLoop(curves)])
    groups = {"plunger": curves[:1], "foot": curves[1:2], "barrel": curves[2:13], "head": curves[13:15], "axis": curves[-1:]}
    write("syringe", surface, groups, order=2)


def kiss_seal():
    """Section of a seal of 4 mm that hangs from a clip and bends along a quarter circle to the plate it kisses."""
    middle = PLANE.addPoint(0, 0, 0, 0.8)
    at = lambda radius, angle, size: PLANE.addPoint(radius * math.cos(angle), radius * math.sin(angle), 0, size * FACTOR)
    outer = [at(20, math.pi, 1.0), at(20, 1.3 * math.pi, 0.5), at(20, 1.55 * math.pi, 0.4)]
    inner = [at(16, 1.55 * math.pi, 0.5), at(16, math.pi, 1.0)]
    clip = points([(-16, 12), (-20, 12)], 1.0 * FACTOR)
    curves = [PLANE.addCircleArc(outer[0], middle, outer[1]), PLANE.addCircleArc(outer[1], middle, outer[2]),
              PLANE.addLine(outer[2], inner[0]), PLANE.addCircleArc(inner[0], middle, inner[1]), PLANE.addLine(inner[1], clip[0]),
              PLANE.addLine(clip[0], clip[1]), PLANE.addLine(clip[1], outer[0])]
    surface = PLANE.addPlaneSurface([PLANE.addCurveLoop(curves)])
    groups = {"clip": curves[5:6], "bay": curves[3:5], "tip": curves[1:3], "duct": [curves[0], curves[6]]}
    write("kiss-seal", surface, groups, order=2)


def egg():
    """Surface of an egg lying along x, 20 mm long and 14 mm thick, its top at the origin: 1,440 facets."""
    rows, around = 18, 40
    heights = [10 * math.cos(math.pi * k / rows) for k in range(1, rows)]
    radius = lambda x: 7 * math.sqrt(1 - (x / 10) ** 2) * (1 - 0.015 * x)
    ring = lambda x: [(x, radius(x) * math.cos(a), radius(x) * math.sin(a) - 7) for a in 2 * math.pi * np.arange(around) / around]
    rings = [ring(x) for x in heights]
    facets = []
    for k in range(around):
        n = (k + 1) % around
        facets += [((10, 0, -7), rings[0][k], rings[0][n]), ((-10, 0, -7), rings[-1][n], rings[-1][k])]
        for upper, lower in zip(rings, rings[1:]):
            facets += [(upper[k], lower[k], lower[n]), (upper[k], lower[n], upper[n])]
    with open(OUT / "egg.stl", "wb") as file:
        file.write(b"egg".ljust(80) + struct.pack("<I", len(facets)))
        for facet in facets:
            file.write(struct.pack("<12fH", 0, 0, 0, *np.ravel(facet), 0))


egg()
def rollers():
    """Sections of two rollers of 40 mm on shafts of 24 mm, one above the other; cells are small where they touch."""
    bodies, groups = {}, {}
    for name, sign, size in (("upper", 1, 0.5), ("lower", -1, 0.7)):
        middle = PLANE.addPoint(0, 20 * sign, 0, 3)
        at = lambda radius, angle, size: PLANE.addPoint(radius * math.sin(angle), sign * (20 - radius * math.cos(angle)), 0, size)
        loops = {}
        for part, radius, sizes in (("skin", 20, (size, 5, 5, 5)), ("bore", 12, (2, 4, 4, 4))):
            ends = [at(radius, 0.5 * math.pi * quarter, one) for quarter, one in enumerate(sizes)]
            near = [at(20, angle, size) for angle in (0.25, -0.25)] if part == "skin" else []
            ends = ends[:1] + near[:1] + ends[1:] + near[1:]
            loops[part] = [PLANE.addCircleArc(a, middle, b) for a, b in zip(ends, ends[1:] + ends[:1])]
            groups[f"{name}-{part}"] = loops[part]
        bodies[name] = PLANE.addPlaneSurface([PLANE.addCurveLoop(loops[part]) for part in ("skin", "bore")])
    write("rollers", bodies, groups, order=2)


def sleeved_bush():
    """Section of a bush of rubber between a tube of 16 x 2 mm and one of 40 x 2 mm, three bodies whose meshes do not match."""
    quarters = [0.0, 0.5 * math.pi, math.pi, 1.5 * math.pi]
    bodies, groups = {}, {}
    for name, radii, size in (("tube", [8, 10], 2.2), ("rubber", [10, 20], 1.8), ("shell", [20, 22], 2.6)):
        inner, outer = ring((0, 0), radii, size, quarters)
        groups |= {f"{name}-inside": inner, f"{name}-outside": outer}
        bodies[name] = PLANE.addPlaneSurface([PLANE.addCurveLoop(outer), PLANE.addCurveLoop(inner)])
    write("sleeved-bush", bodies, groups, order=2)


def bellows():
    """Section of a bellows of three folds of 8 mm between radii of 14 and 20 mm, wall 1.2 mm."""
    folds, steps, pitch = 3, 8, 8.0
    z = np.linspace(0, folds * pitch, 2 * folds * steps + 1)
    x = 17 + 3 * np.cos(2 * math.pi * z / pitch)
    slope = -6 * math.pi / pitch * np.sin(2 * math.pi * z / pitch)
    normal = np.stack([np.ones_like(z), -slope], 1) / np.hypot(1, slope)[:, None]
    walls = {name: points(np.stack([x, z], 1) + side * normal, 0.55) for name, side in (("inside", -0.6), ("outside", 0.6))}
    flanks = range(0, 2 * folds * steps, steps)
    groups = {name: [PLANE.addSpline(wall[k : k + steps + 1]) for k in flanks] for name, wall in walls.items()}
    inside, outside = walls.values()
    groups |= {"foot": [PLANE.addLine(inside[0], outside[0])], "head": [PLANE.addLine(outside[-1], inside[-1])]}
    back = [-curve for curve in groups["inside"][::-1]]
    surface = PLANE.addPlaneSurface([PLANE.addCurveLoop(groups["foot"] + groups["outside"] + groups["head"] + back)])
    write("bellows", surface, groups, order=2)


for make in (o_ring, bush, lip, stopper, finger, tyre, belt, gripper, seal_ring, backed_ring, lip_seal, syringe, kiss_seal, rollers, sleeved_bush, bellows):
    gmsh.initialize(["-v", "2"])
    make()
    gmsh.finalize()
