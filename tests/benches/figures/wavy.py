#!/usr/bin/env python3
"""Random wavy tools, by heights on a grid, pressed into a block: all are solved, the set of closed pressures hardly revised."""
import numpy as np

import common
import meshes
from common import ALL, FOLDER, row, scene, solve, support

TOOLS, QUICK = 200, 40
REVISIONS, SHARE = 3, 0.95


def waves(seed):
    """Five waves, together at most 0.04 high, above the unit square, which the lowest point in it touches."""
    random = np.random.default_rng(seed)
    line = np.linspace(-0.3, 1.3, 81)
    x, y = np.meshgrid(line, line, indexing="ij")
    heights = np.zeros_like(x)
    for _ in range(5):
        k, l = random.uniform(-9, 9, 2)
        heights += random.uniform(0.2, 1) * np.sin(k * x + l * y + random.uniform(0, 2 * np.pi))
    heights *= 0.04 / np.abs(heights).max()
    over_body = (x >= 0) & (x <= 1) & (y >= 0) & (y <= 1)
    heights += 1 - heights[over_body].min()
    path = FOLDER / "waves.grid"
    np.savetxt(path, heights, comments="", header="counts 81 81\norigin -0.3 -0.3\nspacing 0.02 0.02")
    return path


def main():
    given = common.arguments(__doc__)
    mesh = meshes.box("block", [8, 8, 8], [1.0, 1.0, 1.0])
    revisions, applications, failed = [], [], []
    count = QUICK if given.quick else TOOLS
    for seed in range(count):
        shape = {"kind": "height-field", "file": waves(seed), "inside": True}
        keys = {"mesh": mesh, "material": {"body": {"model": "linear-elastic", "shear_modulus": 1.0, "poisson_ratio": 0.5}}}
        file = scene("wavy", **keys, support=[support("z0", **ALL)], obstacle=[{"name": "waves", "on": "z1", "shape": shape}],
                     step=[{"obstacle": {"waves": {"translation": [0.0, 0.0, -0.03]}}}], solver={"tolerance": 1e-6})
        run = solve(file)
        if not run.converged:
            failed.append(seed)
            continue
        revisions.append(run.last["active_set_changes"])
        applications.append(run.last["preconditioner_applications"])
    row(f"{count} wavy tools", "all converged", f"{len(failed)} did not {failed[:5]}", not failed)
    share = np.mean(np.array(revisions) <= REVISIONS)
    row(f"of these with at most {REVISIONS} revisions of the set", f">= {SHARE:g}", f"{share:.3f} (at most {max(revisions)}, {np.mean(applications):.0f} applications)", share >= SHARE)
    common.finish()


main()
