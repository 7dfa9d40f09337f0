#!/usr/bin/env python3
"""Rubber under a sphere (mr-sphere) and a bonded block of rubber (mr-block): applications of the preconditioner and seconds.

Also the limits of both contact spaces over the levels (force, energy, peak pressure, contact radius) and their errors.
"""
import common
import limits
from common import case, case_mesh, median, row, scene, solve, support

SPACES = ("linear", "quadratic")


def sphere(level, space):
    return solve(case("mr-sphere.toml"), f"mesh={case_mesh(f'indent_l{level}')}", f"solver.contact_space={space}")


def counts_of_sphere(levels):
    ends = {space: [] for space in SPACES}
    for space in SPACES:
        for level in levels:
            run = sphere(level, space)
            most = max(run.applications, default=0)
            row(f"mr-sphere l{level} {space}: applications an increment", "<= 90", f"{run.applications}, {run.end}", run.converged and most <= 90)
            ends[space].append(run.last)
    return ends


def block_by(kind):
    """mr-block pressed to 45 % in 18 increments."""
    mesh, travel, rest = case_mesh("cube_n6"), -0.45, dict(increments=18)
    body = {"body": common.MOONEY}
    base = support("z0", **common.ALL)
    if kind == "support":
        step = rest | {"support": {"press": {"displacement": {"z": travel}}}}
        return solve(scene("slide", mesh=mesh, material=body, support=[base, support("z1", "press", z=0.0)], step=[step]))
    press = common.plane("press", "z1", [0.0, 0.0, 1.0], [0.0, 0.0, -1.0])
    step = rest | {"obstacle": {"press": {"translation": [0.0, 0.0, travel]}}}
    return solve(scene("press", mesh=mesh, material=body, support=[base], obstacle=[press], step=[step]))


def block():
    runs = [block_by(kind) for kind in ("obstacle", "support")]
    done = [[s for s in run.steps if s["termination"] == "converged"] for run in runs]
    reached = [len(steps) for steps in done]
    both = min(reached)
    counts = [sum(s["preconditioner_applications"] for s in steps[:both]) for steps in done]
    row("mr-block n6: increments of 2.5 % reached, obstacle and support", "equal but for one", f"{reached[0]} and {reached[1]} of 18", reached[0] >= reached[1] - 1)
    row(f"mr-block n6: applications of the first {both}, obstacle over support", "<= 1.2", f"{counts[0]}/{counts[1]} = {counts[0] / max(counts[1], 1):.2f}", counts[0] <= 1.2 * counts[1])


def main():
    common.arguments(__doc__, repeats=3)
    levels = (1, 2) if common.given.quick else (1, 2, 3, 4)
    ends = counts_of_sphere(levels)
    if len(levels) == 4 and all(s["termination"] == "converged" for e in ends.values() for s in e):
        limits.compare("mr-sphere", ends, "ball", levels)
    block()
    times = [sphere(3, "quadratic") for _ in range(common.given.repeats)]
    seconds = median([run.seconds for run in times])
    row("mr-sphere l3, five increments", "<= 2 s", f"{seconds:.2f} s", all(r.converged for r in times) and seconds <= 2)
    if not common.given.quick:
        run = solve(case("mr-block.toml"), f"mesh={case_mesh('cube_n16')}")
        row("mr-block n16, ten increments", "<= 6 s", f"{run.seconds:.2f} s, {run.end}", run.converged and run.seconds <= 6)
    common.finish()


main()
