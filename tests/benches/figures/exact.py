#!/usr/bin/env python3
"""Cost of the exact certificate: seconds of `solver.stability = "exact"` beyond those of "off", over those of "off".

Bonded blocks of Mooney-Rivlin rubber with some 30 thousand unknowns in 2D and 3D, pressed by 10 % in four increments;
fresh processes by turns, medians; preparation apart. "follow" stands beside it.
"""
import common
import meshes
from common import MOONEY, by_turns, median, plane, row, scene, solve, support

KINDS = ("off", "follow", "exact")


def block(dim, count):
    up = "xyz"[dim - 1]
    point, normal, travel = ([0.0] * (dim - 1) + [x] + [0.0] * (3 - dim) for x in (1.0, -1.0, -0.1))
    return scene(f"block{dim}", mesh=meshes.box(f"block{dim}", [count] * dim, [1.0] * dim), material={"body": MOONEY},
                 support=[support(f"{up}0", **{a: 0.0 for a in "xyz"[:dim]})], obstacle=[plane("press", f"{up}1", point, normal)],
                 step=[{"increments": 4, "obstacle": {"press": {"translation": travel}}}])


def seconds(run):
    return sum(s["seconds"]["total"] - s["seconds"]["prepare"] for s in run.steps)


def main():
    common.arguments(__doc__, repeats=3)
    for dim, count in ((2, 57), (3, 10)):
        file = block(dim, count)
        runs = by_turns(*(lambda k=k: solve(file, f"solver.stability={k}") for k in KINDS), repeats=common.given.repeats)
        times = {kind: median([seconds(r) for r in found]) for kind, found in zip(KINDS, runs)}
        verdicts = {kind: {s.get("stability") for s in found[0].steps} for kind, found in zip(KINDS, runs)}
        unknowns = sum(runs[0][0].last.get("unknowns", {}).values())
        for kind in KINDS[1:]:
            share = times[kind] / times["off"] - 1
            met = share <= 0.5 and all(r.converged for r in runs[2]) if kind == "exact" else None
            row(f"{dim}D, {unknowns} unknowns: cost of {kind} over the increment", "<= 0.5" if kind == "exact" else "-",
                f"{share:.2f} ({times['off']:.2f} s off, {times[kind]:.2f} s), {verdicts[kind]}", met)
    common.finish()


main()
