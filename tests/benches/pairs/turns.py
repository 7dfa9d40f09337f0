#!/usr/bin/env python3
"""Momentum and moment of pairs, and turns of everything: what supports bear is what the contact says, and nothing
changes where all turn together.

Rubber, with friction and without: a half disc pressed on a block and slid along it, then ten turns of all supports
about the origin in `--parts` increments. Forces and moments are compared over the pressing force.
"""
import math

import numpy as np

from shared import common, grid, held, mesh, pair, row, rubber, run
from sliding import half_disc

PRESS, SLIDE, TURNS = 0.1, 0.05, 10


def scene(friction):
    disc = half_disc("disc", 1.0, 0.15, 0.6)
    block = grid("block", (17, 4), lambda s, t: (4 * s - 2.0, t - 1.0))
    material = {"disc": rubber(1.0), "block": rubber(3.0, 100.0)}
    contact = pair("disc-skin", "block-y1") | ({"friction": friction} if friction else {})
    keys = {"mesh": mesh("turns", disc, block, curved=True), "material": material, "contact": [contact]}
    return keys | {"support": [held("disc-top"), held("block-y0")], "solver": {"tolerance": 1e-13}}


def pose(x, y, angle):
    """Moved by (x, y), then turned about the origin: the turn of what was moved."""
    turn = {"rotation": [0.0, 0.0, angle], "about": [-x, -y, 0.0]}
    return {"translation": [x, y, 0.0]} | turn


def steps(parts):
    both = lambda x, y, angle: {"disc-top": pose(x, y, angle), "block-y0": pose(0.0, 0.0, angle)}
    ways = [(2, (0.0, -PRESS, 0.0)), (2, (SLIDE, -PRESS, 0.0)), (parts, (SLIDE, -PRESS, 2 * math.pi * TURNS))]
    return [{"increments": n, "support": both(*way)} for n, way in ways]


def balance(label, step, first="disc-top", second="block-y0"):
    """What the supports bear beside what the contact says, over its force."""
    contact = step["contacts"]["pair"]
    size = np.linalg.norm(contact["force"])
    up, low = (step["supports"][name] for name in (first, second))
    points = [np.array(s["reference_point"][:2]) for s in (up, low)]
    moments = [s["moment"][2] + p[0] * s["force"][1] - p[1] * s["force"][0] for s, p in zip((up, low), points)]
    misses = {
        "force": np.abs(np.add(up["force"], low["force"])).max(), "moment": abs(sum(moments)),
        "force of the contact": np.abs(np.add(up["force"], contact["force"])).max(),
        "moment of the contact": abs(moments[0] + contact["moment"][2]),
    }
    words = ", ".join(f"{what} {miss / size:.1e}" for what, miss in misses.items())
    row(f"{label}: balance", "all <= 1e-13 of the force", words, max(misses.values()) <= 1e-13 * size)


def main():
    common.arguments(__doc__, parts=40)
    for friction in (0.0, 0.3):
        label = f"friction {friction}"
        found = run("turns", **scene(friction), step=steps(common.given.parts))
        if not found.converged:
            row(label, "converged", found.end, False)
            continue
        before, after = found.steps[3], found.last
        balance(f"{label}, pressed", found.steps[1])
        balance(f"{label}, slid", before)
        balance(f"{label}, turned", after)
        own, other = (np.array(s["contacts"]["pair"]["force"]) for s in (before, after))
        away = np.abs(own - other).max() / np.linalg.norm(own)
        lost = abs(after["strain_energy"] / before["strain_energy"] - 1)
        words = f"force {away:.1e}, energy {lost:.1e}; programs {[s['sqp_iterations'] for s in found.steps[:8]]} .."
        row(f"{label}: {TURNS} turns in {common.given.parts}", "within 1e-12", words, max(away, lost) <= 1e-12)
        if friction:
            shares = [s["contacts"]["pair"]["friction"]["dissipated_total"] for s in (before, after)]
            row(f"{label}: dissipated while turning", "<= 1e-12 of it", f"{shares[1] / shares[0] - 1:.1e}", abs(shares[1] / shares[0] - 1) <= 1e-12)
    common.finish()


if __name__ == "__main__":
    main()
