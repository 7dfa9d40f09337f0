#!/usr/bin/env python3
"""Ironing without friction: a half disc of rubber presses a rubber block and slides over it, forth and back.

The ripple of the pressing force and the force along the slide, which would be zero, over the pressing force after a
parabola for the trend across the block, over one pitch of its facets; and what the cycle leaves in the strain energy.
"""
import numpy as np

from shared import along, common, grid, held, knots, mesh, pair, row, rubber, run


def half_disc(name, radius, cell, even):
    """Its lower half: a grid from the rim at the foot to a straight top, sides NAME-skin and -top."""
    half = knots(cell / radius, even / radius, 0.45 * np.pi)
    angles = along(np.concatenate([-half[:0:-1], half]))
    depths = along(knots(cell, even, 0.6 * radius))

    def where(s, t):
        angle, r = angles(s), radius - depths(t)
        return r * np.sin(angle), radius - r * np.cos(angle)

    body = grid(name, [2 * len(half) - 2, len(knots(cell, even, 0.6 * radius)) - 1], where)
    for old, new in (("y0", "skin"), ("y1", "top")):
        body.sides[new], body.middles[new] = body.sides.pop(old), body.middles.pop(old)
    return body


def slid(pitch, cell, contrast, carrier, press, parts):
    """Presses, slides over one pitch and back, `parts` increments each way."""
    count = round(4.0 / pitch)
    disc = half_disc("disc", 1.0, cell, 0.6)
    block = grid("block", (count, count // 4), lambda s, t: (4 * s - 2.0, t - 1.0))
    ways = [(0.0, -press), (0.25 * pitch, -press), (1.25 * pitch, -press), (0.25 * pitch, -press)]
    increments = [2, 1, parts, parts]
    steps = [{"increments": n, "support": {"disc-top": {"displacement": {"x": x, "y": y}}}} for n, (x, y) in zip(increments, ways)]
    supports = [held("disc-top"), held("block-y0"), held("block-x0", x=0.0), held("block-x1", x=0.0)]
    keys = {"mesh": mesh("ironing", disc, block, curved=True), "material": {"disc": rubber(contrast), "block": rubber(1.0)}}
    contact = pair("disc-skin", "block-y1", carries=carrier)
    return run("ironing", **keys, support=supports, contact=[contact], step=steps, solver={"tolerance": 1e-11})


def tell(pitch, cell, contrast, carrier, press=0.12, parts=8):
    label = f"pitch {pitch}, facets {cell}, {contrast}:1, {carrier}"
    found = slid(pitch, cell, contrast, carrier, press, parts)
    if not found.converged:
        return row(label, "converged", found.end, False)
    forces = np.array([s["contacts"]["pair"]["force"][:2] for s in found.steps[3 - 1 :]])[: parts + 1]
    places = np.arange(parts + 1)
    rest = [f - np.polyval(np.polyfit(places, f, 2), places) for f in forces.T]
    ripple, along_it = (np.ptp(r) / forces[:, 1].mean() for r in rest[::-1])
    programs = [s["sqp_iterations"] for s in found.steps]
    cut = f"programs {programs[2]} to press, {max(programs[3:])} at most to slide"
    row(f"{label}: ripple of the force", "<= 1e-3", f"{ripple:.1e}, force along {along_it:.1e}; {cut}", ripple <= 1e-3)
    start, end = (found.steps[k]["strain_energy"] for k in (2, -1))
    row(f"{label}: energy after the cycle", "<= 1e-8", f"{abs(end / start - 1):.1e}", abs(end / start - 1) <= 1e-8)
    work = -np.trapezoid(forces[:, 0], dx=pitch / parts)
    gained = found.steps[2 + parts]["strain_energy"] - start
    row(f"{label}: work along the pitch against energy", "", f"{abs(work - gained) / start:.1e} of the energy", None)
    return None


def main():
    common.arguments(__doc__)
    pitches = (0.2,) if common.given.quick else (0.2, 0.1, 0.05)
    for pitch in pitches:
        for contrast, carrier in ((1.0, "disc-skin"), (1.0, "block-y1"), (10.0, "block-y1")):
            tell(pitch, 0.73 * pitch, contrast, carrier)
    common.finish()


if __name__ == "__main__":
    main()
