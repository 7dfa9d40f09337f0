"""Limits under refinement: values over mesh sizes h are fitted by v = v0 + c h^2. The limit is that without the coarsest
level; its uncertainty is the largest distance of the fits that leave any one level out, or none. Errors are against the
mean of both limits. The contact radius is that of a circle of the area that closed functions carry."""
import math

import numpy as np

from common import row

# Cell sizes at the pole of the levels of the Gmsh meshes indent and hemi.
SIZES = {1: 0.10, 2: 0.05, 3: 0.0333, 4: 0.025, 5: 0.0175}
QUANTITIES = {
    "force": lambda s, name: abs(s["obstacles"][name]["force"][2]),
    "peak pressure": lambda s, name: s["obstacles"][name]["max_pressure"],
    "contact radius": lambda s, name: math.sqrt(4 * s["obstacles"][name]["contact_area"] / math.pi),
}


def fit(sizes, values):
    """The value at h = 0."""
    return float(np.polynomial.polynomial.polyfit(np.array(sizes) ** 2, values, 1)[0])


def limit(sizes, values):
    finer = fit(sizes[1:], values[1:])
    others = [fit(sizes, values)] + [fit(sizes[:i] + sizes[i + 1 :], values[:i] + values[i + 1 :]) for i in range(len(sizes))]
    return finer, max(abs(other - finer) for other in others)


def compare(scene, ends, name, levels):
    """Rows for both spaces; `ends[space]` are the last increments of the levels."""
    sizes = [SIZES[level] for level in levels]
    for quantity, of in QUANTITIES.items():
        values = {space: [of(step, name) for step in ends[space]] for space in ends}
        found = {space: limit(sizes, values[space]) for space in ends}
        (a, da), (b, db) = found["linear"], found["quadratic"]
        row(f"{scene}: limit of {quantity}, quadratic against linear", "within their uncertainty",
            f"{b:.6g} +- {db:.1g}, {a:.6g} +- {da:.1g}", abs(a - b) <= da + db)
        errors = {space: [abs(v / (0.5 * (a + b)) - 1) for v in values[space]] for space in ends}
        means = {space: math.exp(np.mean(np.log(np.maximum(errors[space], 1e-12)))) for space in ends}
        shown = ", ".join(f"{q:.1e}/{p:.1e}" for q, p in zip(errors["quadratic"], errors["linear"]))
        row(f"{scene}: error of {quantity}, quadratic/linear by level", "geometric mean not larger",
            f"{shown}; {means['quadratic']:.1e}/{means['linear']:.1e}", means["quadratic"] <= means["linear"])
