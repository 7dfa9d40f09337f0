#!/usr/bin/env python3
"""Cylinders and balls in contact against Hertz: half width and largest pressure that belong to the force, and for balls
the force that belongs to the approach, under refinement: facets a half width.

Quarter rings of second order about hubs that are led together. Hertz takes the bodies for half-spaces, which leaves out
what grows with the half width over the radius: numbers are those at two half widths, and their limit without width.
"""
import math

from shared import common, elastic, held, mesh, pair, row, run, sector

# Coordinates have eight digits behind the point in the file.
RADIUS = 1000.0
HALF_WIDTHS = (0.02, 0.01)
# Radii and moduli of the upper and the lower body.
PAIRS = {"equal": ((1.0, 1.0), (1.0, 1.0)), "unequal": ((1.0, 2.0), (1.0, 3.0))}


def solved(kind, name, poisson, facets, half_width, approach):
    (upper, lower), young = PAIRS[name]
    cell, even = RADIUS * half_width / facets, 1.4 * RADIUS * half_width
    bodies = [sector("up", RADIUS * upper, 0.0, cell, even), sector("low", RADIUS * lower, 0.0, cell, even, -1.0)]
    path = mesh(f"{kind}-{name}", *bodies, curved=True)
    supports = [held(f"{b}-axis", x=0.0) for b in ("up", "low")] + [held("low-hub"), held("up-hub")]
    material = {b: elastic(e, poisson) for b, e in zip(("up", "low"), young)}
    step = {"support": {"up-hub": {"displacement": {"x": 0.0, "y": -approach * RADIUS}}}}
    keys = {"kind": kind, "mesh": path, "material": material, "support": supports, "step": [step]}
    return run(f"{kind}-{name}", **keys, contact=[pair("up-skin", "low-skin")], solver={"error_estimate": "off"})


def constants(name, poisson):
    """Modulus and radius of the pair, in radii."""
    (upper, lower), young = PAIRS[name]
    return 1 / sum((1 - poisson**2) / e for e in young), 1 / (1 / upper + 1 / lower)


def cylinders(name, poisson, facets, half_width):
    """Half width and peak pressure over those of Hertz."""
    radii, young = PAIRS[name]
    modulus, radius = constants(name, poisson)
    line = math.pi * modulus * half_width**2 / (4 * radius)
    approach = sum(line / math.pi * (1 - poisson**2) / e * (2 * math.log(2 * r / half_width) - 1) for e, r in zip(young, radii))
    found = solved("plane-strain", name, poisson, facets, half_width, approach)
    if not found.converged:
        return found, None
    contact = found.last["contacts"]["pair"]
    force = 2 * abs(contact["force"][1]) / RADIUS
    half, peak = math.sqrt(4 * force * radius / (math.pi * modulus)), math.sqrt(force * modulus / (math.pi * radius))
    return found, {"half width": contact["contact_width"] / RADIUS / half, "peak pressure": contact["peak_pressure"] / peak}


def balls(name, poisson, facets, half_width):
    """The same of balls, and the force over Hertz's of the approach."""
    modulus, radius = constants(name, poisson)
    approach = half_width**2 / radius
    found = solved("axisymmetric", name, poisson, facets, half_width, approach)
    if not found.converged:
        return found, None
    contact = found.last["contacts"]["pair"]
    force = abs(contact["force"][1]) / RADIUS**2
    half = (0.75 * force * radius / modulus) ** (1 / 3)
    peak = (6 * force * modulus**2 / (math.pi**3 * radius**2)) ** (1 / 3)
    ratios = {"half width": math.sqrt(contact["contact_area"] / math.pi) / RADIUS / half, "peak pressure": contact["peak_pressure"] / peak}
    return found, ratios | {"force by approach": force / (4 / 3 * modulus * math.sqrt(radius) * approach**1.5)}


def tell(what, name, poisson, facets):
    label = f"{what.__name__} {name}, nu {poisson}, {facets} facets"
    runs = [what(name, poisson, facets, half_width) for half_width in HALF_WIDTHS]
    for found, ratios in runs:
        if ratios is None:
            return row(label, "converged", found.end, False)
    counts = [(found.last["sqp_iterations"], found.last["preconditioner_applications"]) for found, _ in runs]
    for key in runs[0][1]:
        wide, narrow = (ratios[key] - 1 for _, ratios in runs)
        limit = 2 * narrow - wide
        # Widths end within a facet; pressures and forces within half a per cent from 16 facets on.
        most = 1 / facets if key == "half width" else 5e-3
        met = abs(limit) <= most if facets >= 16 or key == "half width" else None
        words = f"off by {limit:+.1e} ({wide:+.1e}, {narrow:+.1e} at widths {HALF_WIDTHS}); programs, applications {counts}"
        row(f"{label}: {key}", f"Hertz within {most:.2g}", words, met)
    return None


def main():
    common.arguments(__doc__, only="")
    for facets in (8, 16) if common.given.quick else (8, 16, 32):
        for poisson in (0.3, 0.4999):
            for name in PAIRS:
                for what in (cylinders, balls):
                    if common.given.only in f"{what.__name__} {name} {poisson}":
                        tell(what, name, poisson, facets)
    common.finish()


main()
