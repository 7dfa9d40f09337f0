#!/usr/bin/env python3
"""Friction between bodies: a block on a block at its limit, two equal cylinders pushed across (Cattaneo and Mindlin), two
cylinders that roll on each other (Carter).

Stick zones and tractions are against those that belong to the forces found. Cylinders are half rings about hubs, half
widths a two hundredth of the radius: linear bodies feel the slope of their surfaces at rest, by some five per cent of
the tractions at a fiftieth.
"""
import math

import numpy as np

import shared
from shared import (
    along,
    away,
    common,
    elastic,
    grid,
    held,
    knots,
    mesh,
    mirrored,
    pair,
    row,
    run,
    vtu,
)

RADIUS, HALF_WIDTH, FRICTION = 1000.0, 0.005, 0.4


def block_on_block(name, limit, excess):
    """A block pressed by 1 and pulled by the limit times 1 + excess."""
    low = grid("low", (10, 3), lambda s, t: (3 * s - 1, t - 1))
    up = grid("up", (5, 3), lambda s, t: (s, 0.4 * t))
    law = elastic(10.0, 0.4)
    keys = {"mesh": mesh("blocks", low, up), "material": {"low": law, "up": law}, "support": [held("low-y0")]}
    keys["traction"] = [{"on": "up-y1", "value": [limit * (1 + excess), -1.0, 0.0]}]
    return run("blocks", **keys, contact=[pair("up-y0", "low-y1", **{name: limit})], solver={"tolerance": 1e-10, "error_estimate": "off"})


def at_the_limit():
    for name, limit in (("friction", 0.2), ("tresca", 0.05)):
        below, above = (block_on_block(name, limit, excess) for excess in (-1e-6, 1e-6))
        words = f"{below.end} at 1 - 1e-6, {above.end} at 1 + 1e-6"
        row(f"block on block, {name}", "sticks at 1 - 1e-6, slides at 1 + 1e-6", words, below.converged and not above.converged)


def half_ring(name, facets, half_width=HALF_WIDTH, hub=0.3):
    """The lower half of a ring whose foot is the origin."""
    cell, even = RADIUS * half_width / facets, 1.4 * RADIUS * half_width
    half, deep = knots(cell / RADIUS, even / RADIUS, 0.5 * np.pi, 1.4), knots(cell, even, RADIUS * (1 - hub), 1.4)
    angles, depths = along(np.concatenate([-half[:0:-1], half])), along(deep)

    def where(s, t):
        angle, r = angles(s), RADIUS - depths(t)
        return r * np.sin(angle), RADIUS - r * np.cos(angle)

    body = grid(name, [2 * len(half) - 2, len(deep) - 1], where)
    for old, new in (("y0", "skin"), ("y1", "hub")):
        body.sides[new], body.middles[new] = body.sides.pop(old), body.middles.pop(old)
    return body


def pushed(facets, share, poisson):
    """Two cylinders pressed, then pushed across to about that share of the limit, in two increments."""
    modulus = 0.5 / (1 - poisson**2)
    line = math.pi * modulus * HALF_WIDTH**2 / 2
    reach = 2 * line / math.pi * (1 - poisson**2) * (2 * math.log(2 / HALF_WIDTH) - 1)
    up = half_ring("up", facets)
    path, count = mesh("cylinders", up, mirrored(up, "low"), curved=True), 2 * len(up.points)
    # Rings are twice as soft across, for they bend.
    across = share * FRICTION * reach * 2.2
    ways = [(1, 0.0), (2, across)]
    steps = [{"increments": n, "support": {"up-hub": {"displacement": {"x": x * RADIUS, "y": -reach * RADIUS}}}} for n, x in ways]
    law, out = elastic(1.0, poisson), common.FOLDER / f"pushed-{facets}-{share}"
    keys = {"mesh": path, "material": {"up": law, "low": law}, "support": [held("low-hub"), held("up-hub")], "step": steps}
    fields = ["contact_pressure", "contact_state", "friction_traction"]
    contact = pair("up-skin", "low-skin", friction=FRICTION, carries="up-skin")
    found = run("cylinders", **keys, contact=[contact], solver={"error_estimate": "off"}, output={"fields": fields, "every": 100}, out=out)
    return found, surface(out, count) if found.converged else None


def cattaneo(facets, share, poisson=0.3):
    label = f"Cattaneo, {facets} facets, push {share}"
    found, nodes = pushed(facets, share, poisson)
    if not found.converged:
        return row(label, "converged", found.end, False)
    contact = found.last["contacts"]["pair"]
    force, push = abs(contact["force"][1]) / RADIUS, abs(contact["force"][0]) / RADIUS
    modulus = 0.5 / (1 - poisson**2)
    half, peak = math.sqrt(2 * force / (math.pi * modulus)), math.sqrt(2 * force * modulus / math.pi)
    part = push / (FRICTION * force)
    stick = half * math.sqrt(1 - part)
    x, pressure, traction = nodes
    limit = FRICTION * peak
    exact = limit * (np.sqrt(np.maximum(0, 1 - (x / half) ** 2)) - stick / half * np.sqrt(np.maximum(0, 1 - (x / stick) ** 2)))
    error = math.sqrt(np.trapezoid((np.abs(traction) - exact) ** 2, x) / np.trapezoid(exact**2, x))
    sticks = x[(pressure > 0) & (np.abs(traction) < (1 - 1e-4) * FRICTION * pressure)]
    zone = 0.5 * np.ptp(sticks) if len(sticks) else 0.0
    words = f"{zone / half:.4f}, off by {(zone - stick) / half:+.1e}; pushed to {part:.4f} of the limit"
    row(f"{label}: stick zone over half width", f"{stick / half:.4f} within {1 / facets:.3f}", words, abs(zone - stick) <= half / facets)
    middle = np.abs(traction[np.abs(x).argmin()])
    told = limit * (1 - stick / half)
    words = f"{middle:.6g}, off by {middle / told - 1:+.1e}; programs {[s['sqp_iterations'] for s in found.steps]}"
    row(f"{label}: traction in the middle", f"{told:.6g} within 1e-2", words, away(middle, told) <= 1e-2)
    row(f"{label}: traction, mean square", "", f"off by {error:.1e}", None)
    return None


def surface(out, count):
    """Place along the carrier over the radius, pressure and traction across, at its vertices, the first `count` points."""
    arrays = vtu.read(max(out.rglob("*.vtu")))
    x, y, _ = arrays["Points"][:count].T
    depth = np.abs(np.hypot(x, y - RADIUS) - RADIUS)
    on = np.flatnonzero((depth < 1e-6) & (y > -1e-9) & (np.abs(x) < 1.3 * HALF_WIDTH * RADIUS) & (arrays["contact_state"][:count] >= 0))
    on = on[np.argsort(x[on])]
    return x[on] / RADIUS, arrays["contact_pressure"][on], arrays["friction_traction"][on, 0]


def arc(name, radius, cell, fine, hub=0.3):
    """A part of a ring whose foot is the origin, its facets fine from -fine[0] to fine[1] along its skin."""
    sides = [knots(cell / radius, width / radius, 0.4 * np.pi) for width in fine]
    angles, depths = along(np.concatenate([-sides[0][:0:-1], sides[1]])), along(knots(cell, fine[0], radius * (1 - hub)))

    def where(s, t):
        angle, r = angles(s), radius - depths(t)
        return r * np.sin(angle), radius - r * np.cos(angle)

    counts = [sum(map(len, sides)) - 2, len(knots(cell, fine[0], radius * (1 - hub))) - 1]
    body = grid(name, counts, where)
    for old, new in (("y0", "skin"), ("y1", "hub")):
        body.sides[new], body.middles[new] = body.sides.pop(old), body.middles.pop(old)
    return body


def rolled(radii, facets, share, half_width=0.04, widths=4.0, friction=0.3):
    """Two cylinders of rubber that roll on each other: the lower one is turned, the upper one held back by a moment that
    pulls with a share of the limit of friction. Gives the run and the creepage over the last quarter of the way."""
    cell, fine = half_width / facets, (1.5 * half_width, (widths + 1.5) * half_width)
    up, low = arc("up", radii[0], cell, fine), mirrored(arc("low", radii[1], cell, fine), "low")
    line = math.pi * 2.0 * half_width**2 / 4 * sum(1 / r for r in radii)
    approach = sum(line / math.pi / 4 * (2 * math.log(2 * r / half_width) - 1) for r in radii)
    about = {"up-hub": [0.0, radii[0], 0.0], "low-hub": [0.0, -radii[1], 0.0]}
    upper = {"translation": [0.0, -approach, 0.0], "about": about["up-hub"]}
    lower = lambda angle: {"rotation": [0.0, 0.0, angle], "about": about["low-hub"]}
    drag = {"moment": {"z": share * friction * line * radii[0]}}
    count, way = round(8 * widths), widths * half_width
    steps = [{"increments": 2, "support": {"up-hub": upper}}]
    steps += [{"increments": 2, "support": {"up-hub": upper | drag}}]
    steps += [{"increments": count, "support": {"low-hub": lower(way / radii[1])}}]
    keys = {"mesh": mesh("rolling", up, low, curved=True), "material": {b: shared.rubber(1.0) for b in ("up", "low")}}
    contact = pair("up-skin", "low-skin", friction=friction)
    found = run("rolling", **keys, support=[held("up-hub"), held("low-hub")], contact=[contact], step=steps)
    if not found.converged:
        return found, None
    turned = [[s["supports"][name]["rotation"][2] for name in about] for s in found.steps[-1 - count // 4 :: count // 4]]
    ways = [abs(end - start) * r for start, end, r in zip(*turned, radii)]
    return found, ways[0] / ways[1] - 1


def rolling(name, radii, facets, half_width=0.04, friction=0.3):
    """Carter: the creepage of a pull, half the difference of both senses: unequal cylinders creep of themselves."""
    label = f"rolling, {name}, {facets} facets"
    creeps, pulls, widths = [], [], []
    for sense in (0.4, -0.4):
        found, creep = rolled(radii, facets, sense, half_width, friction=friction)
        if creep is None:
            return row(label, "converged", found.end, False)
        force = found.last["contacts"]["pair"]["force"]
        creeps.append(creep)
        pulls.append(abs(force[0] / force[1]) / friction)
        widths.append(math.sqrt(4 * abs(force[1]) / (math.pi * 2.0 * sum(1 / r for r in radii))))
    creep, pull, half = 0.5 * abs(creeps[0] - creeps[1]), sum(pulls) / 2, sum(widths) / 2
    told = friction * half * sum(1 / r for r in radii) * (1 - math.sqrt(1 - pull))
    words = f"{creep:.5f}, off by {creep / told - 1:+.1e}; both senses {creeps[0]:+.5f}, {creeps[1]:+.5f}"
    words += f"; pulls {pulls[0]:.4f}, {pulls[1]:.4f} of the limit; half width {half:.4f}"
    return row(f"{label}: creepage", f"{told:.5f} within 5e-2", words, away(creep, told) <= 5e-2)


def main():
    common.arguments(__doc__, only="")
    if common.given.only in "block":
        at_the_limit()
    if common.given.only in "cattaneo":
        for facets in (8,) if common.given.quick else (8, 16):
            for share in (0.3, 0.6, 0.9):
                cattaneo(facets, share)
    if common.given.only in "rolling":
        for facets in (4,) if common.given.quick else (4, 8):
            rolling("equal", (1.0, 1.0), facets)
            rolling("unequal", (1.0, 2.0), facets)
    common.finish()


if __name__ == "__main__":
    main()
