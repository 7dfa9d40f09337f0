#!/usr/bin/env python3
"""Contact of a half-space and of layers against the theory of linear elasticity: ball, cylinder, flat punch, ball on a layer.

The half-space is a body of 200 contact radii (of the punch, 1000), held far away. A layer is bonded or slides on its base; its force is that of the
integral equation of Lebedev and Ufliand, solved here (the series of Dimitriadis et al., Biophys. J. 82, 2002, differs from it by
the share that is told). Forces of two meshes give their limit by the third order.
"""
import math

import gmsh
import numpy as np

import common
from common import FOLDER, row, scene, solve, support

WIDTH = 0.1
FAR = 200 * WIDTH
RATIOS = (0.3, 0.5)
# Layers are further from their limit than what is asked of a half-space.
ASKED = {"theory": 0.03, "punch": 0.01, "limit": 1e-4, "layer": 1e-3}
SERIES = {True: (1.133, 1.283, 0.769, 0.0975), False: (0.884, 0.781, 0.386, 0.0048)}


def reduced(ratio):
    """Reduced modulus of a body of shear modulus 1."""
    return 2 / (1 - ratio)


def sized(size):
    """Lets `size` at (x, y, z) alone decide how fine a mesh is."""
    gmsh.model.mesh.setSizeCallback(lambda dim, tag, x, y, z, own: size(x, y, z))
    for option in ("MeshSizeExtendFromBoundary", "MeshSizeFromPoints", "MeshSizeFromCurvature"):
        gmsh.option.setNumber("Mesh." + option, 0)
    gmsh.option.setNumber("Mesh.MshFileVersion", 2.2)


def quarter(name, size, thickness=None, disc=None):
    """A quarter of half a ball, or of a layer; `disc` is a face `top` of its own of that radius."""
    gmsh.initialize(), gmsh.option.setNumber("General.Terminal", 0)
    far = 8 * thickness + 3 * WIDTH if thickness else 5 * FAR if disc else FAR
    shapes = gmsh.model.occ
    body = shapes.addSphere(0, 0, 0, far, angle1=-math.pi / 2, angle2=0, angle3=math.pi / 2) if thickness is None \
        else shapes.addCylinder(0, 0, -thickness, 0, 0, thickness, far, angle=math.pi / 2)
    if disc:
        shapes.fragment([(3, body)], [(3, shapes.addCylinder(0, 0, -disc, 0, 0, disc, disc, angle=math.pi / 2))])
    shapes.synchronize()
    faces, near = {}, 1e-5 * far
    for _, face in gmsh.model.getEntities(2):
        if len(gmsh.model.getAdjacencies(2, face)[0]) > 1:
            continue
        x0, y0, z0, x1, y1, z1 = gmsh.model.getBoundingBox(2, face)
        kind = "x0" if x1 - x0 < near else "y0" if y1 - y0 < near else "top" if z1 - z0 < near and abs(z1) < near else "held"
        if kind == "held" and thickness is not None and z1 - z0 > near or kind == "top" and disc and x1 > disc + near:
            kind = "side"
        faces.setdefault(kind, []).append(face)
    for kind, members in faces.items():
        gmsh.model.addPhysicalGroup(2, members, name=kind)
    gmsh.model.addPhysicalGroup(3, [solid for _, solid in gmsh.model.getEntities(3)], name="body")
    sized(lambda x, y, z: size(math.hypot(x, y), z))
    gmsh.option.setNumber("Mesh.Algorithm3D", 10)
    return written(name, 3)


def half_disc(name, size):
    """The right half of the lower half of a disc of radius FAR."""
    gmsh.initialize(), gmsh.option.setNumber("General.Terminal", 0)
    shapes = gmsh.model.geo
    middle, right, low, edge = (shapes.addPoint(*p, 0) for p in ((0, 0), (FAR, 0), (0, -FAR), (1.6 * WIDTH, 0)))
    top, rest, held = shapes.addLine(middle, edge), shapes.addLine(edge, right), shapes.addCircleArc(right, middle, low)
    axis = shapes.addLine(low, middle)
    face = shapes.addPlaneSurface([shapes.addCurveLoop([top, rest, held, axis])])
    shapes.synchronize()
    for kind, line in (("top", top), ("held", held), ("x0", axis)):
        gmsh.model.addPhysicalGroup(1, [line], name=kind)
    gmsh.model.addPhysicalGroup(2, [face], name="body")
    sized(lambda x, y, z: size(x, y))
    return written(name, 2)


def written(name, dimension):
    path = FOLDER / f"{name}.msh"
    gmsh.model.mesh.generate(dimension)
    gmsh.write(str(path))
    gmsh.finalize()
    return path


def around(radius, parts):
    """Fine where a contact of that radius is, growing away from it."""
    return lambda r, z: WIDTH / parts + 0.35 * math.hypot(max(0, r - 1.1 * radius), max(0, -z - 0.5 * radius))


def pressed(mesh, ratio, shape, travel, held):
    """The tool on the quarter."""
    up = "z" if "z" in held else "y"
    supports = [support("held", **held), support("x0", x=0.0)] + ([support("y0", y=0.0)] if up == "z" else [])
    move = [0.0, 0.0, -travel] if up == "z" else [0.0, -travel, 0.0]
    file = scene("theory", mesh=mesh, material={"body": {"model": "linear-elastic", "shear_modulus": 1.0, "poisson_ratio": ratio}},
                 support=supports, obstacle=[{"name": "tool", "on": "top", "shape": shape}],
                 step=[{"obstacle": {"tool": {"translation": move}}}], solver={"tolerance": 1e-8})
    return solve(file)


def judged(what, runs, exact, share, limit_asked):
    """Two meshes against theory, and the finer one against the limit of both."""
    if not all(run.converged for run in runs):
        row(what, "converged", "; ".join(run.end for run in runs), False)
        return
    coarse, fine = (share(run.last["obstacles"]["tool"]) for run in runs)
    limit = fine + (fine - coarse) / 7
    off, rest = fine / exact - 1, abs(fine / limit - 1)
    asked = ASKED["theory"]
    row(f"{what}: over theory, to the limit", f"{asked:g}, {limit_asked:g}", f"{off:+.4f}, {rest:.1e}", abs(off) <= asked and rest <= limit_asked)


def ball(parts):
    travel = WIDTH**2
    shape = {"kind": "sphere", "centre": [0.0, 0.0, 1.0], "radius": 1.0}
    for ratio in RATIOS:
        meshes = [quarter(f"ball{n}", around(WIDTH, n)) for n in parts]
        runs = [pressed(mesh, ratio, shape, travel, {"x": 0.0, "y": 0.0, "z": 0.0}) for mesh in meshes]
        judged(f"ball, a/R 0.1, ratio {ratio}: force", runs, 4 / 3 * reduced(ratio) * travel**1.5, lambda tool: -4 * tool["force"][2], ASKED["limit"])


def cylinder(parts):
    """Peak pressure for the force at hand: the travel of a half-plane has no theory."""
    shape = {"kind": "sphere", "centre": [0.0, 1.0, 0.0], "radius": 1.0}
    for ratio in RATIOS:
        meshes = [half_disc(f"cylinder{n}", around(WIDTH, n)) for n in parts]
        runs = [pressed(mesh, ratio, shape, 0.0275, {"x": 0.0, "y": 0.0}) for mesh in meshes]
        peak = lambda tool: tool["max_pressure"] / math.sqrt(-2 * tool["force"][1] * reduced(ratio) / math.pi)
        judged(f"cylinder, a/R 0.1, ratio {ratio}: peak pressure of its force", runs, 1.0, peak, ASKED["limit"])
        judged(f"cylinder, a/R 0.1, ratio {ratio}: force", runs, runs[-1].last["obstacles"]["tool"]["force"][1], lambda tool: tool["force"][1], ASKED["limit"])


def punch(parts):
    """A plane that may touch a disc alone: pressures are infinite at its edge."""
    travel = 0.001
    shape = {"kind": "half-space", "point": [0.0, 0.0, 0.0], "normal": [0.0, 0.0, -1.0]}
    for ratio in RATIOS:
        size = lambda n: lambda r, z: WIDTH / n + 0.35 * math.hypot(r - WIDTH, z)
        runs = [pressed(quarter(f"punch{n}", size(n), disc=WIDTH), ratio, shape, travel, {"x": 0.0, "y": 0.0, "z": 0.0}) for n in parts]
        if not all(run.converged for run in runs):
            row(f"flat punch, ratio {ratio}", "converged", "; ".join(run.end for run in runs), False)
            continue
        off = [-4 * run.last["obstacles"]["tool"]["force"][2] / (2 * reduced(ratio) * WIDTH * travel) - 1 for run in runs]
        row(f"flat punch, ratio {ratio}: force over theory, {parts[0]} and {parts[1]} edges a radius", f"{ASKED['punch']:g}", f"{off[0]:+.4f}, {off[1]:+.4f}", abs(off[1]) <= ASKED["punch"])


def share_of_layer(ratio, is_bonded):
    """L(u): what a layer leaves of the compliance of a half-space for waves of length 2 pi h / u."""
    k = 3 - 4 * ratio

    def share(u):
        e2, e4 = np.exp(-2 * u), np.exp(-4 * u)
        if is_bonded:
            return (2 * k * (1 - e4) - 8 * u * e2) / (2 * k * (1 + e4) + 2 * (4 * u * u + 1 + k * k) * e2)
        return (1 - 2 * e2 + e4) / (1 - e4 + 4 * u * e2)

    return share


def layer_force(radius, travel, thickness, ratio, is_bonded):
    """Force and contact radius a of a ball on a layer:

    phi(t) - 2/pi int_0^a phi(s) int_0^inf (1 - L(x h)) cos(x t) cos(x s) dx ds = E*/pi (d - t^2 / R),   phi(a) = 0,   F = 2 pi int_0^a phi
    """
    wave, weight = np.polynomial.legendre.leggauss(400)
    wave, weight = 15 * (wave + 1), 15 * weight
    missing = weight * (1 - share_of_layer(ratio, is_bonded)(wave)) / thickness
    place, share = np.polynomial.legendre.leggauss(64)
    place, share = 0.5 * (place + 1), 0.5 * share

    def solved(a):
        t = np.append(a * place, a)
        cosines = np.cos(np.outer(t, wave / thickness))
        matrix = np.eye(len(t))
        matrix[:, :-1] -= 2 / math.pi * (cosines * missing) @ cosines[:-1].T * (a * share)
        phi = np.linalg.solve(matrix, reduced(ratio) / math.pi * (travel - t * t / radius))
        return phi[-1], 2 * math.pi * a * share @ phi[:-1]

    low, high = (factor * math.sqrt(radius * travel) for factor in (0.3, 2))
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if solved(middle)[0] > 0 else (low, middle)
    return solved(low)[1], low


def layer(parts, confinements):
    for is_bonded in (True, False):
        for chi in confinements:
            thickness = WIDTH / chi
            travel = 0.01 * thickness
            radius = WIDTH**2 / travel
            exact, a = layer_force(radius, travel, thickness, 0.5, is_bonded)
            series = 16 / 3 * math.sqrt(radius) * travel**1.5 * (1 + sum(k * chi ** (i + 1) for i, k in enumerate(SERIES[is_bonded])))
            size = lambda n: lambda r, z: min(around(a, n)(r, z), thickness / 2 + 0.2 * r)
            meshes = [quarter(f"layer{n}", size(n), thickness) for n in parts]
            held = {"x": 0.0, "y": 0.0, "z": 0.0} if is_bonded else {"z": 0.0}
            shape = {"kind": "sphere", "centre": [0.0, 0.0, radius], "radius": radius}
            runs = [pressed(mesh, 0.5, shape, travel, held) for mesh in meshes]
            what = f"{'bonded' if is_bonded else 'sliding'} layer, sqrt(R d)/h = {chi} (the series: {series / exact - 1:+.3f}): force"
            judged(what, runs, exact, lambda tool: -4 * tool["force"][2], ASKED["layer"])


def main():
    given = common.arguments(__doc__)
    quick = given.quick
    # Coarse meshes are farther from their limit.
    ASKED["limit"] = 1e-3 if quick else 1e-4
    ball((3, 6) if quick else (6, 12))
    cylinder((16, 32) if quick else (32, 64))
    punch((16, 32) if quick else (32, 64))
    layer((3, 6) if quick else (6, 12), (0.5,) if quick else (0.25, 0.5, 1.0))
    common.finish()


main()
