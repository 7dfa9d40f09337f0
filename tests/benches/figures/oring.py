#!/usr/bin/env python3
"""An O-ring of 50 x 5.33 mm between two plates, squeezed by 20 %, and a bonded bush whose pin moves 3 mm into 10 mm of rubber.

O-ring: whole section and its upper half, cells of 0.6 to 0.12 mm, 1, 10 and 40 increments: the squeeze reached, the
force (660 N), whether it is monotone, seconds. Bush: half a tube of 20/40 x 30 mm, K = 1000 mu, cells of 3, 2.5
and 1.8 mm, ten increments: applications and seconds of the dearest increment over the mean of its neighbours. Needs gmsh.
"""
import common
import meshes
from common import close, plane, row, scene, solve, support

RUBBER = {"model": "mooney-rivlin", "c10": 0.8, "c01": 0.2}
SIZES, INCREMENTS = (0.6, 0.4, 0.3, 0.2, 0.12), (1, 10, 40)
FORCE = 660.0
# Relative; coarse sections are polygons.
WITHIN = {0.6: 0.05, 0.4: 0.05, 0.3: 0.02, 0.2: 0.01, 0.12: 0.01}


def ring(size, half):
    name = f"ring{'-half' if half else ''}-{size}"
    keys = {"mesh": meshes.ring_section(name, size, half), "kind": "axisymmetric", "material": {"body": RUBBER}}
    top = plane("top", "skin", [0.0, 2.665, 0.0], [0.0, -1.0, 0.0])
    step = {"increments": 10, "obstacle": {"top": {"translation": [0.0, -0.533 if half else -1.066, 0.0]}}}
    if half:
        return scene(name, **keys, support=[support("cut", y=0.0)], obstacle=[top], step=[step])
    bottom = plane("bottom", "skin", [0.0, -2.665, 0.0], [0.0, 1.0, 0.0])
    return scene(name, **keys, obstacle=[bottom, top], step=[step])


def squeeze(half):
    label = "half section" if half else "whole section"
    forces = {}
    for size in SIZES[:3] if common.given.quick else SIZES:
        file = ring(size, half)
        for count in INCREMENTS:
            run = solve(file, f"step.0.increments={count}")
            if not run.converged:
                row(f"{label}, size {size}, {count} increments", "reaches 20 %", f"{20 * run.last['time']:.1f} %: {run.end}, {run.wall:.1f} s", False)
                continue
            path = [-s["obstacles"]["top"]["force"][1] for s in run.steps]
            forces[size, count] = path[-1]
            rises = all(a < b for a, b in zip(path, path[1:]))
            fast = run.seconds <= 5 or size != 0.2
            snaps = sum(s["snapped"] is not None for s in run.steps)
            asked = f"{FORCE:g} N within {100 * WITHIN[size]:g} %, rises" + (", <= 5 s" if size == 0.2 else "")
            row(f"{label}, size {size}, {count} increments", asked, f"{path[-1]:.2f} N, {'rises' if rises else 'falls on the way'}, {run.seconds:.2f} s, {snaps} snapped",
                close(path[-1], FORCE) <= WITHIN[size] and rises and fast)
    for count in INCREMENTS:
        found = [forces[key] for key in forces if key[1] == count]
        away = [abs(f - found[-1]) for f in found]
        row(f"{label}, {count} increments: force over sizes", "monotone", ", ".join(f"{f:.2f}" for f in found), all(a >= b for a, b in zip(away, away[1:])))
    for size in {key[0] for key in forces}:
        ends = [forces[key] for key in forces if key[0] == size]
        row(f"{label}, size {size}: force over increments", "equal", f"apart by {close(max(ends), min(ends)):.1e}", close(max(ends), min(ends)) <= 1e-3)


def neighbours(values):
    """The largest value over the mean of its neighbours, and which increment that is."""
    around = [[values[j] for j in (i - 1, i + 1) if 0 <= j < len(values)] for i in range(len(values))]
    ratios = [v * len(n) / max(sum(n), 1e-9) for v, n in zip(values, around)]
    return max(ratios), ratios.index(max(ratios)) + 1


def bush(size):
    held = {"x": 0.0, "y": 0.0, "z": 0.0}
    keys = {"mesh": meshes.half_bush(f"bush-{size}", size), "material": {"body": common.NEO | {"bulk_modulus": 1000.0}}}
    supports = [support("pin", **held), support("sleeve", **held), support("cut", y=0.0)]
    step = {"increments": 10, "support": {"pin": {"displacement": {"x": 3.0, "y": 0.0, "z": 0.0}}}}
    run = solve(scene(f"bush-{size}", **keys, support=supports, step=[step]))
    row(f"bush, size {size}", "complete", f"{run.end}, {sum(run.last.get('unknowns', {}).values())} unknowns, {run.wall:.1f} s", run.converged)
    if len(run.steps) > 2:
        seconds = [s["seconds"]["total"] - s["seconds"]["prepare"] for s in run.steps]
        for what, values in (("applications", run.applications), ("seconds", seconds)):
            ratio, at = neighbours(values)
            row(f"bush, size {size}: dearest increment over its neighbours, {what}", "<= 5", f"{ratio:.1f} (increment {at}: {values[at - 1]:.4g})", ratio <= 5)


def main():
    common.arguments(__doc__)
    squeeze(False), squeeze(True)
    for size in (2.5,) if common.given.quick else (3.0, 2.5, 1.8):
        bush(size)
    common.finish()


main()
