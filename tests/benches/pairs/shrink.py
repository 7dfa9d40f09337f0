#!/usr/bin/env python3
"""Shrink fits of two rings against closed forms: linear ones (Lame, plane strain) and rubber (incompressible
neo-Hookean, finite), each carrier, meshes that do not match, under refinement.

A quarter of the rings, second order. The mean pressure belongs to the force; the largest one is told over it.
"""
import math

import numpy as np
from scipy.integrate import quad
from scipy.optimize import brentq

import shared
from shared import away, common, grid, held, mesh, pair, row, rubber, run

# Radii of linear rings, coordinates having eight digits behind the point in the file, and interference: large beside
# what parabolas miss of arcs, 4e-5 of the radius on eight facets, and small for a linear law.
INNER, MIDDLE, OUTER, FIT = 500.0, 1000.0, 2000.0, 0.3


def ring(name, inside, outside, counts):
    where = lambda s, t: [(inside + (outside - inside) * s) * f(0.5 * np.pi * t) for f in (np.cos, np.sin)]
    return grid(name, counts, where)


def fitted(name, material, radii, along, carrier, **keys):
    """The mean pressure over a quarter at the radius where they meet, and the largest over it."""
    (a, skin), (bore, b) = radii
    bodies = [ring("in", a, skin, (max(2, along[0] // 2), along[0])), ring("out", bore, b, (max(2, along[1] // 2), along[1]))]
    path = mesh("rings", *bodies, curved=True)
    supports = [held(f"{body}-y0", y=0.0) for body in ("in", "out")] + [held(f"{body}-y1", x=0.0) for body in ("in", "out")]
    contact = pair("out-x0", "in-x1", carries=carrier)
    return run("rings", mesh=path, material=dict(zip(("in", "out"), material)), support=supports, contact=[contact], **keys)


def lame(young, poisson):
    """Pressure of rings at plane strain."""
    (r, (a, b)), gives = (MIDDLE, (INNER, OUTER)), 0.0
    for e, free, sign in zip(young, (a, b), (-1, 1)):
        ratio = (free**2 + r**2) / abs(free**2 - r**2)
        gives += r * (1 - poisson**2) / e * (ratio + sign * poisson / (1 - poisson))
    return FIT / gives


def rubbers(shears, skin):
    """Radius and pressure where rings .5 .. skin and 1 .. 2 of rubber meet."""
    def drop(shear, ends, radius, at):
        change = at**2 - radius**2
        stretch = lambda r: r**2 / (r**2 - change)
        return shear * quad(lambda r: (stretch(r) - 1 / stretch(r)) / r, *(math.sqrt(e**2 + change) for e in ends), epsabs=1e-13)[0]

    both = lambda at: (-drop(shears[0], (0.5, skin), skin, at), drop(shears[1], (1.0, 2.0), 1.0, at))
    least = max(1.0, math.sqrt(skin**2 - 0.25)) + 1e-4
    radius = brentq(lambda at: both(at)[0] - both(at)[1], least, skin - 1e-9, xtol=1e-14)
    return radius, both(radius)[1]


def tell(label, found, radius, exact, most):
    if not found.converged:
        return row(label, "converged", found.end, False)
    contact = found.last["contacts"]["pair"]
    mean = 0.5 * sum(abs(x) for x in contact["force"][:2]) / radius
    words = f"{mean:.9g}, off by {mean / exact - 1:+.1e}; largest {contact['peak_pressure'] / mean:.3f} of it"
    return row(label, f"{exact:.9g} within {most:g}", words, away(mean, exact) <= most)


def main():
    common.arguments(__doc__)
    levels = ((8, 12), (16, 24)) if common.given.quick else ((8, 12), (16, 24), (32, 48))
    radii = ((INNER, MIDDLE + 0.5 * FIT), (MIDDLE - 0.5 * FIT, OUTER))
    for along in levels:
        for carrier in ("out-x0", "in-x1"):
            for young in ((1.0, 1.0), (1000.0, 1.0)):
                for poisson in (0.3, 0.5):
                    law = [shared.elastic(e, poisson) for e in young]
                    found = fitted("linear", law, radii, along, carrier, solver={"error_estimate": "off"})
                    most = {8: 1e-2, 16: 1e-3, 32: 5e-4}[along[0]]
                    tell(f"linear {young}, nu {poisson}, {along}, {carrier}", found, MIDDLE, lame(young, poisson), most)
            for shears, skin in (((1.0, 1.0), 1.05), ((1000.0, 1.0), 1.05), ((1.0, 1.0), 1.2), ((1.0, 10.0), 1.2)):
                radius, exact = rubbers(shears, skin)
                # Hoops at the bore of a soft ring in a stiff one are squeezed to .55 of their length, where rubber
                # wrinkles: the even solution is not stable there, and followed all the same.
                solver = {"on_instability": "continue"} if shears[1] > shears[0] else {}
                found = fitted("rubber", [rubber(m) for m in shears], ((0.5, skin), (1.0, 2.0)), along, carrier, solver=solver)
                tell(f"rubber {shears}, skin {skin}, {along}, {carrier}", found, radius, exact, {8: 1e-2, 16: 1e-4, 32: 1e-4}[along[0]])
    common.finish()


if __name__ == "__main__":
    main()
