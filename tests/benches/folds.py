#!/usr/bin/env python3
"""Random slits, open rings and bellows that are pressed until they touch themselves: each and its mirror image, whose
other lip carries the pressure, must converge, balance, and store the same energy.

Bellows are bodies of revolution, mirrored up and down. A wavy strip in the plane bends to the side before it touches: it
took up to 185 programs an increment without any contact.

usage: folds.py PROGRAM [COUNT [SEED]]      needs `pip install numpy`
"""
import json
import math
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

LAW = 'model = "neo-hookean"\nshear_modulus = 1.0\nbulk_modulus = {bulk}\n'
SCENE = """kind = "{section}"
mesh = "fold.msh"
[material.body]
{law}
[[contact]]
name = "fold"
between = "skin"
self = true
{friction}
[[support]]
name = "head"
on = "head"
displacement = {{ x = 0.0, y = 0.0 }}
[[support]]
name = "foot"
on = "foot"
displacement = {{ x = 0.0, y = 0.0 }}
[[step]]
increments = {increments}
support.head = {{ displacement = {{ x = 0.0, y = {way} }} }}
"""


def grid(across, up, place):
    """Points and triangles of a grid, `place` of (0..1, 0..1)."""
    points = [place(i / across, j / up) for j in range(up + 1) for i in range(across + 1)]
    at = lambda i, j: j * (across + 1) + i
    cells = [(i, j) for j in range(up) for i in range(across)]
    halves = [((at(i, j), at(i + 1, j), at(i + 1, j + 1)), (at(i, j), at(i + 1, j + 1), at(i, j + 1))) for i, j in cells]
    return points, [triangle for pair in halves for triangle in pair]


def glued(parts):
    """Several grids as one, equal points once."""
    numbers, cells = {}, []
    for own, triangles in parts:
        known = [numbers.setdefault((round(x, 9), round(y, 9)), len(numbers)) for x, y in own]
        cells += [tuple(known[v] for v in triangle) for triangle in triangles]
    places = [None] * len(numbers)
    for own, _ in parts:
        for x, y in own:
            places[numbers[(round(x, 9), round(y, 9))]] = (x, y)
    return places, cells


def turned(points, cells):
    """Cells with their corners against the clock."""
    area = lambda a, b, c: (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    return [t if area(*(points[v] for v in t)) > 0 else (t[0], t[2], t[1]) for t in cells]


def boundary(cells):
    sides = {side for a, b, c in cells for side in ((a, b), (b, c), (c, a))}
    return [(a, b) for a, b in sides if (b, a) not in sides]


def slit(rng):
    """A square with a slit like a lens along a wavy line."""
    half, opening, slope, wave = rng.uniform(0.4, 0.7), rng.uniform(0.02, 0.07), rng.uniform(-0.2, 0.2), rng.uniform(-0.05, 0.05)

    def part(side, across):
        def place(s, t):
            k = round(s * (across + 4))
            beside = 0.5 * (1 - half)
            x = -1 + k * beside if k <= 2 else half + (k - across - 2) * beside if k >= across + 2 else half * (2 * (k - 2) / across - 1)
            inside = max(0.0, 1 - (x / half) ** 2)
            lip = slope * x + wave * inside * math.sin(6 * x) + side * opening * inside
            return (x, lip + t * (side - lip))

        return grid(across + 4, 6, place)

    points, cells = glued([part(-1, rng.integers(10, 16)), part(1, rng.integers(10, 16))])
    return points, cells, lambda y: abs(abs(y) - 1) < 1e-9, -2.4 * opening - 0.06


def open_ring(rng):
    """A ring that is open on the right, its lips of different meshes."""
    inner, opening = rng.uniform(0.6, 0.8), rng.uniform(0.05, 0.12)

    def part(side, along):
        def place(s, t):
            radius = 1 + t * (inner - 1)
            end = math.asin(opening / radius)
            angle = math.pi + s * (end - math.pi)
            return (radius * math.cos(angle), side * radius * math.sin(angle) if s > 0 else 0.0)

        return grid(along, 4, place)

    points, cells = glued([part(1, rng.integers(20, 30)), part(-1, rng.integers(20, 30))])
    return points, cells, None, -2.5 * opening


def bellows(rng):
    """A wavy strip about an axis."""
    folds, pitch, depth, wall = int(rng.integers(2, 4)), 1.0, rng.uniform(0.2, 0.3), rng.uniform(0.07, 0.11)
    radius = rng.uniform(0.8, 2.0)

    def place(s, t):
        y = s * folds * pitch
        slope = -2 * math.pi / pitch * depth * math.sin(2 * math.pi * y / pitch)
        size = math.hypot(1, slope)
        return (radius + depth * math.cos(2 * math.pi * y / pitch) + (t - 0.5) * wall / size, y - (t - 0.5) * wall * slope / size)

    points, cells = grid(int(32 * folds), 2, place)
    ends = (wall, folds * pitch)
    return points, cells, ends, -0.6 * folds * pitch


def groups(kind, points, cells, ends):
    found = {"skin": [], "head": [], "foot": []}
    for a, b in boundary(cells):
        (ax, ay), (bx, by) = points[a], points[b]
        if kind == "slit":
            if ends(ay) and ends(by):
                found["head" if ay > 0 else "foot"].append((a, b))
            elif max(abs(ax), abs(bx)) < 1 - 1e-9:
                found["skin"].append((a, b))
        elif kind == "open ring":
            found["skin"].append((a, b))
            on_skin = abs(math.hypot(ax, ay) - 1) < 1e-9 and abs(math.hypot(bx, by) - 1) < 1e-9
            if on_skin and min(ax, bx) > 0.5 and max(ax, bx) < 0.95:
                found["head" if ay > 0 else "foot"].append((a, b))
        else:
            high = [abs(y - ends[1]) < 1e-9 for y in (ay, by)]
            low = [abs(y) < 1e-9 for y in (ay, by)]
            name = "head" if all(high) else "foot" if all(low) else "skin"
            found[name].append((a, b))
    return found


def write(path, points, cells, sides):
    names = list(sides)
    facets = [(k + 1, side) for k, name in enumerate(names) for side in sides[name]]
    lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$PhysicalNames", str(len(names) + 1)]
    lines += [f'1 {k + 1} "{name}"' for k, name in enumerate(names)] + ['2 9 "body"', "$EndPhysicalNames"]
    lines += ["$Nodes", str(len(points))] + [f"{k + 1} {x!r} {y!r} 0" for k, (x, y) in enumerate(points)] + ["$EndNodes"]
    lines += ["$Elements", str(len(facets) + len(cells))]
    lines += [f"{n + 1} 1 2 {tag} {tag} {a + 1} {b + 1}" for n, (tag, (a, b)) in enumerate(facets)]
    first = len(facets) + 1
    lines += [f"{first + n} 2 2 9 9 {a + 1} {b + 1} {c + 1}" for n, (a, b, c) in enumerate(cells)] + ["$EndElements"]
    path.write_text("\n".join(lines) + "\n")


def solved(program, folder, scene):
    (folder / "fold.toml").write_text(scene)
    run = subprocess.run([program, "solve", folder / "fold.toml", "--json"], capture_output=True, text=True)
    steps = [json.loads(line) for line in run.stdout.splitlines() if '"event":"step"' in line]
    return steps, run.stderr


def main():
    program, count = Path(sys.argv[1]).resolve(), int(sys.argv[2]) if len(sys.argv) > 2 else 100
    rng = np.random.default_rng(int(sys.argv[3]) if len(sys.argv) > 3 else 1)
    failed, apart, programs = [], [], []
    for number in range(count):
        kind, make = [("slit", slit), ("open ring", open_ring), ("bellows", bellows)][number % 3]
        points, cells, ends, way = make(rng)
        points = [(float(x), float(y)) for x, y in points]
        # Friction breaks no mirror: either lip slides on the other one.
        friction = "" if number % 2 else f"friction = {rng.uniform(0.1, 0.5):.3f}"
        section, axes = ("axisymmetric", [1]) if kind == "bellows" else ("plane-strain", [0, 1])
        scene = SCENE.format(section=section, law=LAW.format(bulk=rng.choice([5.0, 20.0, 100.0])), friction=friction, increments=12, way=way)
        energies = []
        for mirror in (1, -1):
            turned_over = mirror < 0 and kind == "bellows"
            places = [(x, ends[1] - y) if turned_over else (x if kind == "bellows" else mirror * x, y) for x, y in points]
            own = turned(places, cells)
            with tempfile.TemporaryDirectory() as folder:
                write(Path(folder) / "fold.msh", places, own, groups(kind, places, own, ends) if kind != "open ring" or mirror > 0 else
                      mirrored(points, cells, ends, own))
                steps, text = solved(program, Path(folder), scene)
            last = steps[-1] if steps else {"termination": text[-200:]}
            if last["termination"] != "converged":
                failed.append((number, kind, mirror, len(steps), last["termination"]))
                break
            head, foot = (np.array(last["supports"][name]["force"])[axes] for name in ("head", "foot"))
            if np.abs(head + foot).max() > 1e-6 * np.abs(head).max():
                failed.append((number, kind, mirror, "balance", head, foot))
            energies.append(last["strain_energy"])
            programs += [step["sqp_iterations"] for step in steps]
        else:
            apart.append((abs(energies[1] / energies[0] - 1), number, kind, last["contacts"]["fold"]["contact_width"]))
            print(number, kind, friction, *energies, f"{apart[-1][0]:.1e}", f"width {apart[-1][3]:.3f}", flush=True)
    print("failed", *failed, sep="\n")
    by_kind = {kind: [one[0] for one in apart if one[2] == kind] for _, _, kind, _ in apart}
    print("energies of mirror images apart, median and largest", {k: (float(np.median(v)), max(v)) for k, v in by_kind.items()})
    print("programs an increment, median and largest", np.median(programs), max(programs))


def mirrored(points, cells, ends, own):
    """The groups of the mirror image of an open ring, whose opening is on the left."""
    sides = groups("open ring", points, turned(points, cells), ends)
    there = set(boundary(own))
    return {name: [(a, b) if (a, b) in there else (b, a) for a, b in found] for name, found in sides.items()}


if __name__ == "__main__":
    main()
