#!/usr/bin/env python3
"""A block of neo-Hookean rubber in a box without friction, its lid pressed down: an obstacle against a support that does the same.

Measured for K = 1e2 .. 1e6 shear moduli, squeezes of 1 to 20 %, n = 2 .. 16 cells an edge, in 2D and 3D: ratio of the
applications of the preconditioner, and the relative error of the force against the exact (homogeneous) one.
"""
import common
import meshes
from common import NEO, plane, row, scene, solve, support, worst

SQUEEZES, BULKS, COUNTS = (0.01, 0.05, 0.1, 0.2), (1e2, 1e3, 1e4, 1e5, 1e6), (2, 4, 8, 16)


def exact(bulk, squeeze):
    """Force on unit area of the homogeneous state, mu = 1."""
    s = 1.0 - squeeze
    return s ** (1 / 3) - s ** (-5 / 3) * (2 + s * s) / 3 + bulk * (s - 1)


def scenes(dim, count):
    """Both scenes of a mesh; bulk modulus and travel are set later."""
    mesh = meshes.box(f"box{dim}{count}", [count] * dim, [1.0] * dim)
    axes, up = "xyz"[:dim], "xyz"[dim - 1]
    sides = [support([f"{a}0", f"{a}1"], **{a: 0.0}) for a in axes[:-1]] + [support(f"{up}0", **{up: 0.0})]
    point, normal = ([0.0] * 3 for _ in "12")
    point[dim - 1], normal[dim - 1] = 1.0, -1.0
    body = {"body": NEO | {"bulk_modulus": 1.0}}
    return (
        scene(f"lid{dim}{count}", mesh=mesh, material=body, support=sides, obstacle=[plane("lid", f"{up}1", point, normal)],
              step=[{"obstacle": {"lid": {"translation": [0.0] * 3}}}]),
        scene(f"held{dim}{count}", mesh=mesh, material=body, support=sides + [support(f"{up}1", "lid", **{up: 0.0})],
              step=[{"support": {"lid": {"displacement": {up: 0.0}}}}]),
    )


def compare(dim, count, bulk, squeeze, files):
    """Ratio of applications, force errors and ends of both."""
    up = "xyz"[dim - 1]
    material = f"material.body.bulk_modulus={bulk:.1f}"
    travel = [0.0] * 3
    travel[dim - 1] = -squeeze
    pressed = solve(files[0], material, f"step.0.obstacle.lid.translation={travel}")
    held = solve(files[1], material, f"step.0.support.lid.displacement.{up}={-squeeze}")
    label = f"{dim}D n{count} K {bulk:.0e} {100 * squeeze:g} %"
    if not (pressed.converged and held.converged):
        row(label, "both converge", f"obstacle {pressed.end}, support {held.end}", False)
        return None
    forces = [run.last[kind]["lid"]["force"][dim - 1] for run, kind in ((pressed, "obstacles"), (held, "supports"))]
    counts = [sum(run.applications) for run in (pressed, held)]
    errors = [abs(f / exact(bulk, squeeze) - 1) for f in forces]
    if counts[0] > 1.5 * counts[1] or max(errors) > 1e-7:
        print(f"  {label}: {counts[0]} against {counts[1]} applications, errors {errors[0]:.1e}, {errors[1]:.1e}", flush=True)
    return counts[0] / max(counts[1], 1), errors[0], errors[1], abs(forces[0] / forces[1] - 1), counts[0] - counts[1]


def main():
    common.arguments(__doc__)
    for dim in (2, 3):
        for count in COUNTS[:2] if common.given.quick else COUNTS:
            files = scenes(dim, count)
            found = [compare(dim, count, bulk, squeeze, files) for bulk in BULKS[:: 2 if common.given.quick else 1] for squeeze in SQUEEZES]
            found = [x for x in found if x]
            at, over = f"{dim}D n{count}, {len(found)} scenes", [x for x in found if x[0] > 1.5]
            row(f"{at}: applications, obstacle over support", "<= 1.5",
                f"{worst(x[0] for x in found):.2f} ({len(over)} above, by {worst(x[4] for x in over):g} applications at most)", not over)
            error = worst(x[1] for x in found)
            row(f"{at}: force against the exact one", "<= 1e-7", f"{error:.1e} (support {worst(x[2] for x in found):.1e})", error <= 1e-7)
            apart = worst(x[3] for x in found)
            row(f"{at}: force, obstacle against support", "<= 1e-7", f"{apart:.1e}", apart <= 1e-7)
    common.finish()


main()
