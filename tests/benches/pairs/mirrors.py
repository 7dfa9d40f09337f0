#!/usr/bin/env python3
"""A body against its image in a plane is the body on that plane, rigid: forces and energies to 1e-9 where surfaces are
flat. Round ones meet along rays, so that the same gaps are weighted otherwise: told under refinement.
"""
from shared import (
    common,
    elastic,
    grid,
    held,
    mesh,
    mirrored,
    pair,
    row,
    rubber,
    run,
    sector,
)

SHARP = {"tolerance": 1e-12}
PLANE = {"kind": "half-space", "point": [0.0, 0.0, 0.0], "normal": [0.0, 1.0, 0.0]}


def block(name):
    return grid(name, (10, 5), lambda s, t: (s, t))


def compare(label, body, law, way, most, kind="plane-strain", top="up-y1", foot="up-y0", axis=None):
    """The way of the body towards the plane; the image has the opposite one. Gives the difference of forces."""
    up = body("up")
    low = mirrored(up, "low")
    lower = {name: name.replace("up", "low") for name in (top, foot, axis) if name}
    supports = [held(top)] + ([held(axis, x=0.0)] if axis else [])
    steps = [{"support": {top: {"displacement": {"x": 0.0, "y": -way}}}}]
    keys = {"kind": kind, "solver": SHARP}
    tool = run("tool", mesh=mesh("tool", up, curved=True), material={"up": law}, support=supports, step=steps,
               obstacle=[{"name": "pair", "on": foot, "shape": PLANE}], **keys)
    supports += [held(lower[top])] + ([held(lower[axis], x=0.0)] if axis else [])
    steps[0]["support"][lower[top]] = {"displacement": {"x": 0.0, "y": way}}
    both = run("both", mesh=mesh("both", up, low, curved=True), material={"up": law, "low": law}, support=supports, step=steps,
               contact=[pair(foot, lower[foot])], **keys)
    if not (tool.converged and both.converged):
        return row(label, "converged", f"tool {tool.end}, pair {both.end}", False)
    found, exact = both.last["contacts"]["pair"], tool.last["obstacles"]["pair"]
    misses = {"force": abs(found["force"][1] / exact["force"][1] - 1)}
    misses["energy"] = abs(both.last["strain_energy"] / tool.last["strain_energy"] / 2 - 1)
    programs = both.last["sqp_iterations"], tool.last["sqp_iterations"]
    words = ", ".join(f"{what} {miss:.1e}" for what, miss in misses.items())
    words += f"; largest pressures {found['peak_pressure']:.6g} and {exact['max_pressure']:.6g}; programs {programs}"
    return row(label, f"within {most:g}" if most else "", words, max(misses.values()) <= most if most else None)


def main():
    common.arguments(__doc__)
    laws = {"linear": elastic(1.0), "rubber K 20": rubber(1.0, 20.0), "rubber": rubber(1.0)}
    round_ends = {"top": "up-hub", "foot": "up-skin", "axis": "up-axis"}
    for label, law in laws.items():
        compare(f"block, {label}", block, law, 0.1, 1e-9)
        compare(f"cylinder, {label}", block, law, 0.1, 1e-9, kind="axisymmetric", axis="up-x0")
        # Along rays from one curved surface to another the gap is another quadrature than to a plane.
        for facets in (8, 16, 32):
            ball = lambda name, facets=facets: sector(name, 1.0, 0.0, 0.4 / facets, 0.4)
            way = 0.01 if label == "linear" else 0.05
            for kind in ("plane-strain", "axisymmetric"):
                what = {"plane-strain": "ring", "axisymmetric": "hollow ball"}[kind]
                compare(f"{what}, {label}, {facets} facets", ball, law, way, None, kind=kind, **round_ends)
    common.finish()


main()
