#!/usr/bin/env python3
"""A ball on a block in random poses, elastic and rubber: each result against the same pose from a fresh session.

A session of each ten poses is one scene of that many steps; a quarter of the poses press, lift far away (to 1e3
lengths) and press again. Relative differences of force and energy, of what is below a thousandth of the largest to that.
"""
import random

import common
from common import case, case_mesh, row, solve, worst

SESSION = 10
MATERIALS = {"elastic": {"model": "linear-elastic", "shear_modulus": 1.0, "poisson_ratio": 0.5}, "rubber": common.MOONEY}


def poses(count, seed):
    """Translations: pressed by up to 0.08, just above, or far away."""
    rng = random.Random(seed)
    for _ in range(count):
        aside = [rng.uniform(0, 0.25) for _ in "xy"]
        kind = rng.random()
        if kind < 0.65:
            yield [*aside, -rng.uniform(0.002, 0.08)]
        elif kind < 0.75:
            yield [*aside, rng.uniform(0.0, 0.1)]
        else:
            far = 10 ** rng.uniform(0, 3)
            yield [far * rng.uniform(-1, 1), far * rng.uniform(-1, 1), far * rng.uniform(0.1, 1)]


def file_of(name, material, places):
    supports = [common.support("z0", **common.ALL), common.support("x0", x=0.0), common.support("y0", y=0.0)]
    ball = {"name": "ball", "on": "z1", "shape": {"kind": "sphere", "centre": [0.0, 0.0, 1.0], "radius": 1.0}}
    steps = [{"obstacle": {"ball": {"translation": list(place)}}} for place in places]
    return common.scene(name, mesh=case_mesh("indent_l1"), material={"body": material}, support=supports, obstacle=[ball], step=steps)


def differences(one, other, largest):
    """Of force and energy."""
    forces = [s["obstacles"]["ball"]["force"] for s in (one, other)]
    size = max(max(map(abs, forces[1])), 1e-3 * largest[0])
    energies = [s["strain_energy"] for s in (one, other)]
    return max(abs(a - b) for a, b in zip(*forces)) / size, abs(energies[0] - energies[1]) / max(energies[1], 1e-3 * largest[1])


def main():
    common.arguments(__doc__, count=1000, seed=1)
    for label, material in MATERIALS.items():
        places = list(poses(40 if common.given.quick else common.given.count, common.given.seed))
        fresh = [solve(file_of("fresh", material, [place])).last for place in places]
        largest = [max((of(s) for s in fresh if s["termination"] == "converged"), default=0.0)
                   for of in (lambda s: max(map(abs, s["obstacles"]["ball"]["force"])), lambda s: s["strain_energy"])]
        failed, found, bound = [], [], 1e-7
        for start in range(0, len(places), SESSION):
            part = places[start : start + SESSION]
            run = solve(file_of("session", material, part))
            for i, place in enumerate(part):
                step = run.steps[i] if i < len(run.steps) else run.last
                if "converged" != step["termination"] or fresh[start + i]["termination"] != "converged":
                    failed.append((start + i, step["termination"], step.get("cause"), fresh[start + i]["termination"]))
                    continue
                found.append((*differences(step, fresh[start + i], largest), start + i))
                bound = 10 * step.get("tolerance", 1e-8)
        off = [f for f in found if max(f[:2]) > bound]
        row(f"{label}, {len(places)} poses: converged in the session and fresh", "all", f"{len(failed)} not {failed[:3]}", not failed)
        row(f"{label}: force and energy against a fresh session", f"<= {bound:.0e}",
            f"{worst(f[0] for f in found):.1e}, {worst(f[1] for f in found):.1e}; {len(off)} above {[f[2] for f in off[:5]]}", not off)
    common.finish()


main()
