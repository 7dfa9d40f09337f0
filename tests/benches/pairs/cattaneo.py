#!/usr/bin/env python3
"""Two equal balls pressed by Hertz's load, then pushed across (Cattaneo and Mindlin): tractions, the radius that sticks and
the way that the push takes.

    q = mu p0 / a [ sqrt(a^2 - r^2) - sqrt(c^2 - r^2) ],   c = a (1 - T / mu N)^(1/3)
    way = 3 mu N (2 - nu) / (8 G a) [ 1 - (1 - T / mu N)^(2/3) ],   T (2 - nu) / (4 G a) where all sticks

Halves of balls of second order, cut by the plane of the push, led by their flat faces, linear. The solution takes the
bodies for half-spaces and tractions for parallel, which is exact for nu = 0 alone. What bodies give far from the contact
is left out by a second run in which everything sticks: both give the same there. The radius that sticks is that whose
tractions are nearest to those found. The contact is small beside the radius: linear bodies meet along normals at rest of
the one that carries, which turn by a / R, and a way along them is counted as slip: at a / R of .05 a quarter of what the
surfaces move inwards. `graded` has facets of half the size in a ring about the borders of contact and stick, where
tractions have infinite slopes.
"""
import math

import numpy as np
from shared import FOLDER, away, common, elastic, held, pair, row, run, vtu

RADIUS, HALF_WIDTH, FRICTION = 1.0, 0.01, 0.4
# Middle and half width of the ring of `graded`, over the radius of contact, and how much smaller its facets are.
RING, FINER = (0.9, 0.16), 2.2


def sizes(cell, is_graded):
    """The size of cells for Gmsh."""
    half, reach = HALF_WIDTH * RADIUS, 1.3 * HALF_WIDTH * RADIUS
    core = f"{cell} + 0.35*Max(0, Sqrt(x*x + y*y + (z+{RADIUS})*(z+{RADIUS})) - {reach})"
    if not is_graded:
        return core
    beside = f"Max(0, Abs(Sqrt(x*x + y*y) - {RING[0] * half}) - {RING[1] * half})"
    return f"Min({core}, {cell / FINER} + 0.5*Sqrt({beside}^2 + (z+{RADIUS})*(z+{RADIUS})))"


def body(gmsh, name, size, sense, angle):
    """Points and cells of second order, its surfaces by name; the mesh turned by an angle about the axis at the pole."""
    gmsh.clear()
    occ = gmsh.model.occ
    ball = occ.addSphere(0, 0, 0, RADIUS, -1, -math.pi / 2, 0, math.pi)
    pole = occ.addPoint(0, 0, -RADIUS)
    occ.fragment([(3, ball)], [(0, pole)])
    occ.synchronize()
    field = gmsh.model.mesh.field
    at = field.add("MathEval")
    field.setString(at, "F", size)
    field.setAsBackgroundMesh(at)
    for key, value in (("MeshSizeExtendFromBoundary", 0), ("MeshSizeFromPoints", 0), ("RandomSeed", 1 + angle), ("MeshSizeMax", 0.3)):
        gmsh.option.setNumber(f"Mesh.{key}", value)
    gmsh.option.setNumber("Mesh.Algorithm", 5 if angle else 6)
    gmsh.model.mesh.generate(3)
    gmsh.model.mesh.setOrder(2)
    tags, places, _ = gmsh.model.mesh.getNodes()
    points = np.array(places).reshape(-1, 3)
    number = {tag: k for k, tag in enumerate(tags)}
    cells = np.array([number[t] for t in gmsh.model.mesh.getElementsByType(11)[1]]).reshape(-1, 10)
    sides = {}
    for _, surface in gmsh.model.getEntities(2):
        nodes = np.array([number[t] for t in gmsh.model.mesh.getElementsByType(9, surface)[1]]).reshape(-1, 6)
        middle = points[nodes].reshape(-1, 3)
        side = "cut" if np.abs(middle[:, 1]).max() < 1e-9 else "hub" if np.abs(middle[:, 2]).max() < 1e-9 else "skin"
        if side == "skin":
            far = np.linalg.norm(points[nodes] + [0.0, 0.0, RADIUS], axis=2).max(axis=1) > 1.25 * HALF_WIDTH * RADIUS
            sides.setdefault("rest", []).append(nodes[far])
            nodes = nodes[~far]
        sides.setdefault(side, []).append(nodes)
    points[:, 2] = sense * (points[:, 2] + RADIUS)
    if sense < 0:
        cells = cells[:, [0, 2, 1, 3, 6, 5, 4, 7, 9, 8]]
    return points, cells, {f"{name}-{side}": np.concatenate(nodes) for side, nodes in sides.items()}


def write(path, bodies):
    """A Gmsh file of version 2.2."""
    names = [(3, name) for name in bodies] + [(2, side) for _, (_, _, sides) in bodies.items() for side in sides]
    tags = {name: k + 1 for k, (_, name) in enumerate(names)}
    points, lines, first = [], [], 0
    for name, (places, cells, sides) in bodies.items():
        points.append(places)
        lines += [(11, tags[name], nodes + first) for nodes in cells]
        lines += [(9, tags[side], nodes + first) for side, facets in sides.items() for nodes in facets]
        first += len(places)
    with path.open("w") as out:
        out.write("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n")
        out.write(f"{len(names)}\n" + "".join(f'{d} {tags[name]} "{name}"\n' for d, name in names) + "$EndPhysicalNames\n$Nodes\n")
        points = np.concatenate(points)
        out.write(f"{len(points)}\n" + "".join(f"{k + 1} {x:.16g} {y:.16g} {z:.16g}\n" for k, (x, y, z) in enumerate(points)))
        out.write(f"$EndNodes\n$Elements\n{len(lines)}\n")
        for k, (kind, tag, nodes) in enumerate(lines):
            out.write(f"{k + 1} {kind} 2 {tag} {tag} " + " ".join(str(n + 1) for n in nodes) + "\n")
        out.write("$EndElements\n")
    return path


def mesh(facets, is_graded):
    import gmsh

    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    cell = HALF_WIDTH * RADIUS / facets
    bodies = {"up": body(gmsh, "up", sizes(cell, is_graded), 1.0, 0), "low": body(gmsh, "low", sizes(1.1 * cell, is_graded), -1.0, 1)}
    gmsh.finalize()
    return write(FOLDER / f"balls-{facets}.msh", bodies), len(bodies["up"][0])


def pushed(path, facets, rule, poisson, share):
    """Pressed to the half width, then pushed to about a share of the limit of FRICTION, in three increments; a rule of friction."""
    modulus, shear = 0.5 / (1 - poisson**2), 0.5 / (1 + poisson)
    radius, half = 0.5 * RADIUS, HALF_WIDTH * RADIUS
    approach = half**2 / radius
    load = 4 / 3 * modulus * half**3 / radius
    way = 3 * FRICTION * load * (2 - poisson) / (8 * shear * half) * (1 - (1 - share) ** (2 / 3))
    places = [(1, 0.0), (3, way)]
    steps = [{"increments": n, "support": {"up-hub": {"displacement": {"x": x, "y": 0.0, "z": -approach}}}} for n, x in places]
    law, out = elastic(1.0, poisson), FOLDER / f"pushed-{facets}-{'-'.join(rule)}-{poisson}"
    hubs = [held(f"{name}-hub", x=0.0, y=0.0, z=0.0) for name in ("up", "low")]
    keys = {"kind": "solid", "mesh": path, "material": {"up": law, "low": law}, "step": steps}
    keys["support"] = hubs + [held(f"{name}-cut", y=0.0) for name in ("up", "low")]
    contact = pair("up-skin", "low-skin", carries="up-skin", **rule)
    fields = ["contact_pressure", "contact_state", "friction_traction"]
    solver = {"error_estimate": "off", "tolerance": 1e-8}
    return run("balls", **keys, contact=[contact], solver=solver, output={"fields": fields, "every": 100}, out=out), out, way


def surface(out, count):
    """Distance from the axis, pressure and traction along the push at vertices of the carrier that touch."""
    arrays = vtu.read(max(out.rglob("*.vtu")))
    x, y, z = arrays["Points"][:count].T
    on = (np.hypot(x, y) < 2 * HALF_WIDTH * RADIUS) & (np.abs(z) < HALF_WIDTH**2 * RADIUS * 4) & (arrays["contact_pressure"][:count] > 0)
    return np.hypot(x, y)[on], arrays["contact_pressure"][:count][on], np.abs(arrays["friction_traction"][:count][on, 0])


def cattaneo(facets, poisson, is_graded=False, share=0.5):
    label = f"balls, {facets} facets{', graded' if is_graded else ''}, nu {poisson}"
    path, count = mesh(facets, is_graded)
    found, out, way = pushed(path, facets, {"friction": FRICTION}, poisson, share)
    if not found.converged:
        return row(label, "converged", found.end, False)
    modulus, radius = 0.5 / (1 - poisson**2), 0.5 * RADIUS
    push, _, load = (2 * abs(x) for x in found.last["contacts"]["pair"]["force"])  # halves of balls
    half = (0.75 * load * radius / modulus) ** (1 / 3)
    peak, part = 1.5 * load / (math.pi * half**2), push / (FRICTION * load)
    stick = half * (1 - part) ** (1 / 3)
    counts = [(s["sqp_iterations"], s["preconditioner_applications"]) for s in found.steps]
    row(f"{label}: run", "", f"pushed to {part:.4f} of the limit; programs, applications {counts}; {found.seconds:.0f} s", None)
    r, _, traction = surface(out, count)
    exact = lambda c: FRICTION * peak / half * (np.sqrt(np.maximum(0, half**2 - r**2)) - np.sqrt(np.maximum(0, c**2 - r**2)))
    radii = np.linspace(0, half, 20001)
    misses = [np.sum((traction - exact(c)) ** 2) for c in radii]
    zone = radii[int(np.argmin(misses))]
    row(f"{label}: radius that sticks", f"{stick / half:.4f} within 1e-2", f"{zone / half:.4f}, off by {zone / stick - 1:+.1e}", away(zone, stick) <= 1e-2)
    error = math.sqrt(np.mean((traction - exact(stick)) ** 2)) / (FRICTION * peak)
    inside = r < 0.6 * stick
    middle = np.mean(traction[inside]) / np.mean(exact(stick)[inside])
    row(f"{label}: traction inside .6 of it", "1 within 1e-2", f"off by {middle - 1:+.1e}; mean square of all over the limit {error:.1e}", abs(middle - 1) <= 1e-2)
    return None if is_graded else compare_way(label, (path, facets, poisson, share), (push, load, half))


def compare_way(label, scene, forces):
    """The way of the push, beside that of a run in which all sticks."""
    (path, facets, poisson, share), (push, load, half) = scene, forces
    stuck, _, way = pushed(path, facets, {"tresca": 100.0}, poisson, share)
    if not stuck.converged:
        return row(f"{label}: all sticks", "converged", stuck.end, False)
    shear, part = 0.5 / (1 + poisson), push / (FRICTION * load)
    whole = 2 * abs(stuck.last["contacts"]["pair"]["force"][0])
    all_sticks = push * (2 - poisson) / (4 * shear * half)
    told = 3 * FRICTION * load * (2 - poisson) / (8 * shear * half) * (1 - (1 - part) ** (2 / 3))
    measured = way - way * push / whole + all_sticks
    return row(f"{label}: way of the push", f"{told:.6g} within 1e-2", f"{measured:.6g}, off by {measured / told - 1:+.1e}", away(measured, told) <= 1e-2)


def main():
    common.arguments(__doc__)
    for facets in (4,) if common.given.quick else (4, 6, 8):
        for poisson in (0.0, 0.3):
            cattaneo(facets, poisson)
    if not common.given.quick:
        cattaneo(8, 0.0, is_graded=True)
    common.finish()


main()
