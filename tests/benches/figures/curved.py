#!/usr/bin/env python3
"""Curved bodies on meshes of second order (g) beside straight facets (s): disc and ball between plates, ring on a shaft.

Errors are relative. The figures asked are those of an independent plane code on meshes of its own; as chance has its part
in where facets lie, the geometric mean over all sizes may be twice its errors. Needs: pip install gmsh.
"""
import math

import numpy as np

import common
import meshes
import vtu
from common import FOLDER, NEO, plane, row, scene, solve, support

ELASTIC = {"model": "linear-elastic", "shear_modulus": 1.0, "poisson_ratio": 0.5}
ORDERS = {"s": 1, "g": 2}
# Size of cells: error of the force and of the peak pressure asked; errors of the force on straight facets beside them.
DISC = {0.2: (0.0135, 0.031), 0.1: (0.0055, 9e-3), 0.05: (1.9e-3, 6e-4), 0.025: (2.1e-4, 2e-4), 0.0125: (2.8e-5, 1.3e-4)}
STRAIGHT = {0.2: 0.106, 0.1: 0.028, 0.05: 7.4e-3, 0.025: 1.6e-3, 0.0125: 3.7e-4}
# Facets a circle: error of the force at squeezes of 10 and 20 %.
RUBBER = {16: (9e-3, 4e-3), 32: (2e-3, 3e-3), 64: (2e-3, 2e-3), 128: (5e-4, 1e-4)}
# Facets a circle: error of the mean pressure and of the pressure in L2 at an interference of 5 %.
RING = {32: (2e-4, 0.11), 64: (None, None), 128: (None, None), 256: (2e-7, 0.016)}
# Ratio of errors, straight over second order, least of the disc's: 0.0074 / 0.0019.
FACTOR = 3.9


def away(value, exact):
    return abs(value / exact - 1)


def pressed(name, mesh, material, squeeze, up="y", increments=1):
    """A quarter disc or an eighth of a ball under a plate that comes down by `squeeze`; gives force and peak pressure."""
    axis = "xyz".index(up)
    point, normal, travel = ([x if i == axis else 0.0 for i in range(3)] for x in (1.0, -1.0, -squeeze))
    sides = [support(f"{a}0", **{a: 0.0}) for a in "xyz"[: axis + 1]]
    step = {"increments": increments, "obstacle": {"plate": {"translation": travel}}}
    run = solve(scene(name, mesh=mesh, material={"body": material}, support=sides, obstacle=[plane("plate", "rim", point, normal)], step=[step]))
    if not run.converged:
        row(name, "converged", run.end, False)
        return math.nan, math.nan, 1
    plate = run.last["obstacles"]["plate"]
    return -plate["force"][axis], plate["max_pressure"], run.last["unknowns"]["displacement"]


def graded(finest, pole, slope=0.1, coarsest=0.1):
    """Size of cells that grows from the pole."""
    return lambda x, y, z: min(coarsest, finest + slope * math.dist((x, y, z), pole))


def needed(error, errors, unknowns):
    """Unknowns for an error, between the levels around it, or beyond the last two."""
    at = next((i for i in range(1, len(errors)) if errors[i] < error), len(errors) - 1)
    (e0, e1), (n0, n1) = (np.log(values[at - 1 : at + 1]) for values in (errors, unknowns))
    return math.exp(n0 + (math.log(error) - e0) * (n1 - n0) / (e1 - e0))


def against(label, errors, asked):
    """Errors over those asked in the mean, and the order of both, from fits; `asked` by size of cells."""
    sizes, known = np.log(list(asked))[: len(errors)], np.log(list(asked.values()))[: len(errors)]
    order, its_order = (np.polyfit(sizes, logs, 1)[0] for logs in (np.log(errors), known))
    ratio = math.exp(np.mean(np.log(errors) - known))
    row(f"{label}: error over that asked, geometric mean", "<= 2", f"{ratio:.2f}", ratio <= 2)
    row(f"{label}: order", f">= {its_order:.2f} - 0.3", f"{order:.2f}", order >= its_order - 0.3)


def disc():
    fine = graded(1 / 400, (0, 1, 0), 0.05, 0.01)
    reference = pressed("disc-fine", meshes.quarter_disc("disc-fine", fine, 2), ELASTIC, 0.05)
    found = {"s": [], "g": []}
    for size in list(DISC)[: 3 if common.given.quick else 5]:
        for kind, order in ORDERS.items():
            name = f"disc-{kind}-{size}"
            found[kind].append(pressed(name, meshes.quarter_disc(name, lambda *_, h=size: h, order), ELASTIC, 0.05))
    for at, what in enumerate(("force", "peak pressure")):
        s, g = ([away(f[at], reference[at]) for f in found[kind]] for kind in "sg")
        shown = ", ".join(f"{y:.1e} (straight {x:.1e})" for x, y in zip(s, g))
        row(f"disc, h {list(DISC)[: len(s)]}: error of {what}", ", ".join(f"{d[at]:.1e}" for d in DISC.values()), shown, None)
        against(f"disc, {what}", g, {h: d[at] for h, d in DISC.items()})
    sizes = [h**-2 for h in DISC]
    for error in (0.01, 0.001):
        known = needed(error, list(STRAIGHT.values()), sizes) / needed(error, [d[0] for d in DISC.values()], sizes)
        s, g = (needed(error, [away(f[0], reference[0]) for f in found[kind]], [f[2] for f in found[kind]]) for kind in "sg")
        row(f"disc: unknowns for a force to {100 * error:g} %, straight over second order", f">= 0.8 x {known:.1f}, from the errors asked",
            f"{s:.0f} / {g:.0f} = {s / g:.1f}", s / g >= 0.8 * known)


def disc_of_rubber():
    fine = meshes.quarter_disc("rubber-fine", graded(1 / 160, (0, 1, 0), 0.1, 0.02), 2)
    for at, squeeze in enumerate((0.1, 0.2)):
        reference = pressed(f"rubber-fine-{squeeze}", fine, NEO, squeeze, increments=4)[0]
        errors = {}
        for kind, order in ORDERS.items():
            meshed = {n: meshes.quarter_disc(f"rubber-{kind}-{n}", lambda *_, n=n: 2 * math.pi / n, order) for n in RUBBER}
            errors[kind] = [away(pressed(f"rubber-{kind}-{n}-{squeeze}", mesh, NEO, squeeze, increments=4)[0], reference) for n, mesh in meshed.items()]
        label = f"disc of rubber, {100 * squeeze:g} %"
        shown = ", ".join(f"{g:.1e} (straight {s:.1e})" for s, g in zip(errors["s"], errors["g"]))
        row(f"{label}, {list(RUBBER)} facets: error of force", ", ".join(f"{r[at]:.0e}" for r in RUBBER.values()), shown, None)
        ratio = math.exp(np.mean([math.log(g / r[at]) for g, r in zip(errors["g"], RUBBER.values())]))
        row(f"{label}: error over that asked, geometric mean", "<= 2", f"{ratio:.2f}", ratio <= 2)


def ball():
    """No figures in space are known: the factor of the plane is asked."""
    sizes = (0.3, 0.2) if common.given.quick else (0.3, 0.2, 0.12)
    grade = lambda h: graded(h / 2, (0, 0, 1), 0.3, h)
    reference, _, _ = pressed("ball-fine", meshes.eighth_ball("ball-fine", grade(sizes[-1] / 2), 2), ELASTIC, 0.05, "z")
    for size in sizes:
        s, g = (away(pressed(f"ball-{k}-{size}", meshes.eighth_ball(f"ball-{k}-{size}", grade(size), o), ELASTIC, 0.05, "z")[0], reference) for k, o in ORDERS.items())
        row(f"ball, h {size}: error of force, straight over second order", f">= {FACTOR}", f"{s:.1e} / {g:.1e} = {s / g:.1f}", s >= FACTOR * g)


def ring(facets, order, interference):
    """Errors of the mean pressure and of the pressure in L2 against 2 mu d / a (1 - a^2 / b^2)."""
    name = f"ring{facets}-{order}-{interference}"
    shape = {"kind": "cylinder", "point": [0.0] * 3, "axis": [0.0, 0.0, 1.0], "radius": 1.0 + interference}
    run = solve(scene(name, mesh=meshes.quarter_ring(name, facets, order), material={"body": ELASTIC},
                      support=[support("x0", x=0.0), support("y0", y=0.0)],
                      obstacle=[{"name": "shaft", "on": "inner", "shape": shape}]), out=FOLDER / name)
    if not run.converged:
        row(name, "converged", run.end, False)
        return math.nan, math.nan
    mean = sum(run.last["obstacles"]["shaft"]["force"][:2]) / 2
    read = vtu.read(next((FOLDER / name).glob(f"{name}_*.vtu")))
    radius, angle = np.hypot(*read["Points"].T[:2]), np.arctan2(*read["Points"].T[1::-1])
    inner = np.flatnonzero(radius < 1 + 1e-9)
    ends = read["contact_pressure"][inner[np.argsort(angle[inner])]][::2]
    return away(mean, 1.5 * interference), l2(ends / (1.5 * interference) - 1, mean / (1.5 * interference) - 1)


def l2(ends, mean):
    """Root mean square of a function that is quadratic on segments, with these values at their ends and that mean on each:
    the files have pressures at vertices, and what stands at middles is interpolated."""
    a, c = ends[:-1], ends[1:]
    b = (6 * mean - a - c) / 4
    t = np.array([-1, 0, 1]) * math.sqrt(0.6)
    shape = np.outer(t * (t - 1) / 2, a) + np.outer(1 - t * t, b) + np.outer(t * (t + 1) / 2, c)
    return math.sqrt(np.mean(np.array([5, 8, 5]) / 18 @ shape**2))


def rings():
    facets = list(RING)[: 2 if common.given.quick else 4]
    for interference in (0.05, 0.005):
        found = [ring(n, 2, interference) for n in facets]
        straight = [ring(n, 1, interference)[0] for n in facets]
        shown = lambda values: ", ".join(f"{x:.1e}" for x in values)
        label = f"ring on a shaft, {100 * interference:g} %, {facets} facets"
        row(f"{label}: error of mean pressure, straight", "-", shown(straight), None)
        mean, local = ([f[i] for f in found] for i in (0, 1))
        orders = [math.log2(a / b) for a, b in zip(mean, mean[1:])]
        met = orders[0] >= 3.5 and mean[0] <= (4e-4 if interference == 0.05 else 1.4e-3)
        row(f"{label}: error of mean pressure, orders", "<= 4e-4 (5 %), 1.4e-3 (0.5 %) at 32, order 4", f"{shown(mean)}; {shown(orders)}", met)
        orders = [math.log2(a / b) for a, b in zip(local, local[1:])]
        met = (local[0] <= 0.22 and min(orders) >= 0.8) if interference == 0.05 else None
        row(f"{label}: error of pressure in L2, orders", "<= 0.22 at 32, order 1" if interference == 0.05 else "-", f"{shown(local)}; {shown(orders)}", met)


def main():
    common.arguments(__doc__)
    disc(), disc_of_rubber(), rings(), ball()
    common.finish()


main()
