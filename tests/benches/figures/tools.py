#!/usr/bin/env python3
"""Rigid tools: references of independent codes, and triangulated tools against the analytic ones.

Triangulated are a torus, a box with rounded edges and a cylinder with rounded rims, the last two as programs of CAD write
them: large flat facets beside small ones. Force and peak pressure of all increments, iterations of the last.
"""
import json
import math
import struct

import numpy as np

import common
from common import FOLDER, case, case_mesh, close, row, solve, worst

# Stated digits of the references (friction.md, section 2).
DIGITS = {"tool-torus": 1e-7, "tool-cone": 2e-6, "tool-box": 3e-5, "drum": 1e-7}
# (force, peak pressure)
ASKED = (1e-4, 1e-3)


def apart(a, b):
    return math.dist(a, b) / max(math.hypot(*b), 1e-300)


def references():
    known = json.loads(case("tools/references.json").read_text())
    for key, right in known.items():
        name, mesh = (key.split("|") + [""])[:2]
        # That of a pushed tool is its travel, told by a test.
        if name not in DIGITS or "steps" not in right:
            continue
        mesh = right["mesh"] if "mesh" in right else f"{mesh}.msh"
        folder = case("tools/meshes") if (case("tools/meshes") / mesh).exists() else case("..") / "meshes"
        run = solve(case(f"tools/{name}.toml"), f"mesh={folder / mesh}", "solver.contact_space=linear")
        if not run.converged or len(run.steps) != len(right["steps"]):
            row(f"reference {key}", "converged", run.end, False)
            continue
        forces = [apart(found["obstacles"][tool]["force"], exact["force"])
                  for found, step in zip(run.steps, right["steps"]) for tool, exact in step["obstacles"].items()]
        energies = [close(found["strain_energy"], step["strain_energy"]) for found, step in zip(run.steps, right["steps"])]
        most = max(worst(forces), worst(energies))
        row(f"reference {key}: force, energy", f"<= {DIGITS[name]:g}", f"{worst(forces):.1e}, {worst(energies):.1e}", most <= DIGITS[name])


def write(name, vertices, facets):
    """A binary STL file, oriented outwards."""
    vertices, facets = np.asarray(vertices, float), np.asarray(facets)
    a, b, c = (vertices[facets[:, k]] for k in range(3))
    if np.einsum("ij,ij->i", a, np.cross(b, c)).sum() < 0:
        facets = facets[:, [0, 2, 1]]
    records = np.zeros(len(facets), dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("more", "<u2")])
    records["corners"] = vertices[facets]
    path = FOLDER / f"{name}.stl"
    path.write_bytes(b"binary".ljust(80) + struct.pack("<I", len(facets)) + records.tobytes())
    return path, len(facets)


def bands(rows, around, closed):
    """Facets of a grid of points `rows x around`, each row a ring; the last row meets the first one where `closed`."""
    facets = []
    for q in range(rows if closed else rows - 1):
        for i in range(around):
            j, below = (i + 1) % around, (q + 1) % rows
            facets += [[q * around + i, q * around + j, below * around + j], [q * around + i, below * around + j, below * around + i]]
    return facets


def torus(major=0.35, minor=0.25, around=64, rows=40):
    points = [[(major + minor * math.cos(v)) * math.cos(u), (major + minor * math.cos(v)) * math.sin(u), minor + minor * math.sin(v)]
              for v in np.arange(rows) / rows * math.tau for u in np.arange(around) / around * math.tau]
    return write("torus", points, bands(rows, around, True))


def rounded_cylinder(radius=0.4, half=0.3, rounding=0.05, around=96, parts=8):
    angles = math.tau * (np.arange(around) + 0.37) / around
    rims = [(radius - rounding + rounding * math.sin(t), sign * (half - rounding + rounding * abs(math.cos(t))))
            for sign, first, last in ((-1, 0, math.pi / 2), (1, math.pi / 2, math.pi)) for t in np.linspace(first, last, parts + 1)]
    points = [[r * math.cos(a), y, radius + r * math.sin(a)] for r, y in rims for a in angles]
    last = (len(rims) - 1) * around
    fans = [f for i in range(1, around - 1) for f in ([0, i + 1, i], [last, last + i, last + i + 1])]
    return write("cylinder", points, bands(len(rims), around, False) + fans)


def rounded_box(half=(0.3, 0.25, 0.2), rounding=0.05, parts=8, flats=6):
    """Each side a grid: rounding by angles, a flat part, rounding."""
    half = np.array(half)
    inner = half - rounding
    angles = np.linspace(-math.pi / 4, 0, parts + 1)
    line = [(-1.0, t) for t in angles] + [(s, 0.0) for s in np.linspace(-1, 1, flats + 1)[1:]] + [(1.0, t) for t in -angles[::-1][1:]]
    numbers, points, facets = {}, [], []

    def vertex(point):
        key = tuple(np.round(point, 9))
        if key not in numbers:
            numbers[key] = len(points)
            points.append(point)
        return numbers[key]

    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        for sign in (-1.0, 1.0):
            grid = [[None] * len(line) for _ in line]
            for i, (s1, t1) in enumerate(line):
                for j, (s2, t2) in enumerate(line):
                    direction = np.zeros(3)
                    direction[axis], direction[u], direction[v] = sign, math.tan(t1), math.tan(t2)
                    direction /= np.linalg.norm(direction)
                    at = np.zeros(3)
                    at[axis], at[u], at[v] = sign * inner[axis], s1 * inner[u], s2 * inner[v]
                    grid[i][j] = vertex(at + rounding * direction + [0, 0, half[2]])
            for i in range(len(line) - 1):
                for j in range(len(line) - 1):
                    a, b, c, d = grid[i][j], grid[i + 1][j], grid[i + 1][j + 1], grid[i][j + 1]
                    quad = [[a, b, c], [a, c, d]] if sign > 0 else [[a, c, b], [a, d, c]]
                    facets += [f for f in quad if len(set(f)) == 3]
    return write("box", points, facets)


TOOLS = {
    "torus": (torus, '{ kind = "torus", centre = [0.0, 0.0, 0.25], axis = [0.0, 0.0, 1.0], radius = 0.35, tube_radius = 0.25 }', 0.03),
    "rounded box": (rounded_box, '{ kind = "box", centre = [0.0, 0.0, 0.2], half_sizes = [0.3, 0.25, 0.2], rounding = 0.05 }', 0.03),
    "rounded cylinder": (rounded_cylinder, '{ kind = "capped-cylinder", from = [0.0, -0.3, 0.4], to = [0.0, 0.3, 0.4], radius = 0.4, rounding = 0.05 }', 0.04),
}


def triangulated(name, space):
    make, shape, depth = TOOLS[name]
    path, count = make()
    text = case("tools/tool-box.toml").read_text()
    start, rest = text.split("shape = ")
    rest = rest.split("\n", 1)[1].replace("-0.03]", f"-{depth}]")
    files = []
    for label, own in (("analytic", shape), ("triangulated", f'{{ kind = "surface", file = "{path}" }}')):
        files.append(FOLDER / f"{label}.toml")
        files[-1].write_text(start + f"shape = {own}\n" + rest)
    sets = [f"mesh={case_mesh('indent_l2')}", f"solver.contact_space={space}", "solver.tolerance=1e-8"]
    exact, found = (solve(file, *sets) for file in files)
    what = f"{name} of {count} facets, {space}: force, peak pressure, iterations"
    if not (exact.converged and found.converged):
        row(what, "converged", f"{exact.end}; {found.end}", False)
        return
    pairs = [(a["obstacles"]["tool"], b["obstacles"]["tool"]) for a, b in zip(exact.steps, found.steps)]
    force = worst(apart(b["force"], a["force"]) for a, b in pairs)
    peak = worst(close(a["max_pressure"], b["max_pressure"]) for a, b in pairs)
    more = found.last["sqp_iterations"] - exact.last["sqp_iterations"]
    row(what, f"<= {ASKED[0]:g}, {ASKED[1]:g}, + 2",
        f"{force:.1e}, {peak:.1e}, {more:+d} ({sum(exact.applications)} and {sum(found.applications)} applications, {exact.seconds:.2f} and {found.seconds:.2f} s)",
        force <= ASKED[0] and peak <= ASKED[1] and more <= 2)


def main():
    given = common.arguments(__doc__)
    references()
    for name in TOOLS:
        for space in ("linear",) if given.quick else ("linear", "quadratic"):
            triangulated(name, space)
    common.finish()


main()
