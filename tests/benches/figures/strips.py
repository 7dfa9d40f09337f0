#!/usr/bin/env python3
"""Bonded strips and layers, 8 and 32 times as wide as high, pressed by a tenth in ten increments by a plane or a sliding support.

Linear (Poisson ratio 1/2, and K = 1000 mu) and neo-Hookean rubber; asked is that they converge, 32:1 within 20 s in 3D
and 1 s in 2D. Rubber 32:1 with free ends has, on these meshes, no equilibrium beyond some 7.5 % (an independent solver).
"""
import common
import meshes
from common import ALL, NEO, plane, row, scene, solve, support

BULK = 1000.0
ELASTIC = {"model": "linear-elastic", "shear_modulus": 1.0}
MATERIALS = {
    "linear, nu 1/2": ELASTIC | {"poisson_ratio": 0.5},
    "linear, K 1000": ELASTIC | {"poisson_ratio": (3 * BULK - 2) / (2 * (3 * BULK + 1))},
    "rubber": NEO,
    "rubber, K 1000": NEO | {"bulk_modulus": BULK},
}
MESHES = {(2, 8): [24, 3], (2, 32): [48, 3], (3, 8): [16, 16, 2], (3, 32): [16, 16, 2]}
MOST = {2: 1.0, 3: 20.0}


def layer(dim, width, name, material, lid):
    up = "xyz"[dim - 1]
    mesh = meshes.box(f"layer{dim}{width}", MESHES[dim, width], [float(width)] * (dim - 1) + [1.0])
    base = [support(f"{up}0", **{a: ALL[a] for a in "xyz"[:dim]})]
    normal, point, travel = ([0.0] * (dim - 1) + [x] + [0.0] * (3 - dim) for x in (-1.0, 1.0, -0.1))
    keys = {"mesh": mesh, "material": {"body": material}}
    if lid == "obstacle":
        step = {"increments": 10, "obstacle": {"lid": {"translation": travel}}}
        return scene(name, **keys, support=base, obstacle=[plane("lid", f"{up}1", point, normal)], step=[step])
    step = {"increments": 10, "support": {"lid": {"displacement": {up: -0.1}}}}
    return scene(name, **keys, support=base + [support(f"{up}1", "lid", **{up: 0.0})], step=[step])


def main():
    common.arguments(__doc__)
    for dim, width in MESHES:
        for number, (label, material) in enumerate(MATERIALS.items()):
            for lid in ("obstacle", "support"):
                if common.given.quick and (dim, width) == (3, 32) and number > 1:
                    continue
                run = solve(layer(dim, width, f"strip{dim}{width}{number}{lid}", material, lid))
                most = MOST[dim] if width == 32 else None
                asked = "converged" + (f", <= {most:g} s" if most else "")
                met = run.converged and (most is None or run.seconds <= most)
                counts = run.applications
                row(f"{dim}D {width}:1 {label}, lid {lid}", asked,
                    f"{run.end}, {run.seconds:.2f} s, {sum(counts)} applications (dearest {max(counts, default=0)})", met)
    common.finish()


main()
