#!/usr/bin/env python3
"""NAFEMS R0081, contact benchmarks 1 (steel roller on an aluminium block) and 2 (punch with a rounded edge, about the
axis): displacement and pressure in the middle, without friction and with a coefficient of 0.1, under refinement.

The published numbers are those of code_aster (tests SSNP154, SSNA122), at finite displacement: see `PUBLISHED`. Asked is
0.5 % of those of its quadratic cells, in bench 1 of its newer version, and of Hertz's pressure without friction there. Needs: pip install gmsh numpy.
"""
import numpy as np

from shared import away, common, elastic, held, pair, row, run, vtu

STEEL, ALUMINIUM = elastic(210e3), elastic(70e3)
HERTZ = 3585.37
# Displacement and stress in the middle by bench, friction and cells.
PUBLISHED = {
    (1, 0.0): {"linear": (-1.306904, -3800.5), "quadratic": (-1.308019, -3513.4), "newer": (-1.274234, -3589.5)},
    (1, 0.1): {"linear": (-1.301080, -3670.3), "quadratic": (-1.302636, -3542.7), "newer": (-1.270311, -3643.6)},
    (2, 0.0): {"linear": (-0.1307341, -91.1006), "quadratic": (-0.1329412, -94.1221)},
    (2, 0.1): {"linear": (-0.1285802, -88.6652), "quadratic": (-0.1307935, -95.4740)},
}


def finite(material):
    """Rubber of the same moduli."""
    young, poisson = material["young_modulus"], material["poisson_ratio"]
    return {"model": "neo-hookean", "shear_modulus": young / (2 + 2 * poisson), "bulk_modulus": young / (3 - 6 * poisson)}


def meshed(name, outlines, size):
    """A mesh of second order of two outlines, each corners and the arcs' centres: [(point, group, centre or None)]."""
    import gmsh

    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    geo, groups = gmsh.model.geo, {}
    for body, outline in outlines.items():
        points = [geo.addPoint(*point, 0.0) for point, _, _ in outline]
        lines = []
        for k, (_, group, centre) in enumerate(outline):
            ends = points[k], points[(k + 1) % len(points)]
            lines.append(geo.addCircleArc(ends[0], geo.addPoint(*centre, 0.0), ends[1]) if centre else geo.addLine(*ends))
            groups.setdefault(f"{body}-{group}", []).append(lines[-1])
        surface = geo.addPlaneSurface([geo.addCurveLoop(lines)])
        groups[body] = [surface]
    geo.synchronize()
    for group, members in groups.items():
        dimension = 2 if group in outlines else 1
        gmsh.model.setPhysicalName(dimension, gmsh.model.addPhysicalGroup(dimension, members), group)
    gmsh.model.mesh.setSizeCallback(lambda d, t, x, y, z, lc: size(x, y))
    for option in ("FromPoints", "FromCurvature", "ExtendFromBoundary"):
        gmsh.option.setNumber(f"Mesh.MeshSize{option}", 0)
    gmsh.option.setNumber("Mesh.ElementOrder", 2)
    gmsh.option.setNumber("Mesh.MshFileVersion", 2.2)
    gmsh.model.mesh.generate(2)
    path = common.FOLDER / f"{name}.msh"
    gmsh.write(str(path))
    gmsh.finalize()
    return path


def roller(cell):
    """Half of it: the force of 35 kN is a traction on 2 mm of the rim at the top."""
    end = (50 * np.sin(0.04), 50 + 50 * np.cos(0.04))
    centre = (0.0, 50.0)
    disc = [((0.0, 0.0), "foot", centre), ((50.0, 50.0), "rim", centre), (end, "load", centre), ((0.0, 100.0), "axis", None)]
    block = [((0.0, 0.0), "axis", None), ((0.0, -200.0), "base", None), ((100.0, -200.0), "side", None), ((100.0, 0.0), "top", None)]
    size = lambda x, y: cell + 0.15 * max(0.0, min(np.hypot(x, y) - 8.0, 2 + np.hypot(x, y - 100)))
    return meshed("roller", {"up": disc, "low": block}, size), -17500.0 / (50 * 0.04), "plane-strain"


def punch(cell):
    corner = (40.0, 10.0)
    up = [((0.0, 0.0), "foot", None), ((40.0, 0.0), "foot", corner), ((50.0, 10.0), "side", None)]
    up += [((50.0, 100.0), "load", None), ((0.0, 100.0), "axis", None)]
    block = [((0.0, 0.0), "axis", None), ((0.0, -200.0), "base", None), ((100.0, -200.0), "side", None), ((100.0, 0.0), "top", None)]
    size = lambda x, y: cell + 0.15 * max(0.0, min(np.hypot(x - 41, y) - 2.0, 30.0))
    return meshed("punch", {"up": up, "low": block}, size), -100.0, "axisymmetric"


def solved(bench, cell, friction, is_finite):
    path, load, kind = (roller, punch)[bench - 1](cell)
    material = {"up": STEEL, "low": ALUMINIUM}
    if is_finite:
        material = {body: finite(law) for body, law in material.items()}
    supports = [held("up-axis", x=0.0), held("low-axis", x=0.0), held("low-base")]
    contact = pair("low-top", "up-foot") | ({"friction": friction} if friction else {})
    keys = {"kind": kind, "mesh": path, "material": material, "support": supports, "contact": [contact]}
    keys |= {"traction": [{"on": "up-load", "value": [0.0, load, 0.0]}], "probe": [{"name": "middle", "point": [0.0, 0.0, 0.0]}]}
    out = common.FOLDER / f"bench-{bench}-{cell}-{friction}-{is_finite}"
    steps = [{"increments": 4 if friction or is_finite else 1}]
    found = run(f"bench-{bench}", **keys, step=steps, solver={"error_estimate": "off"}, output={"every": 100}, out=out)
    return found, middle(out) if found.converged else None


def middle(out):
    """The contact pressure in the middle, of the body that carries it."""
    arrays = vtu.read(max(out.rglob("*.vtu")))
    at = np.linalg.norm(arrays["Points"], axis=1) < 1e-9
    return float(arrays["contact_pressure"][at].max())


def tell(bench, cell, friction, is_finite):
    label = f"bench {bench}, friction {friction}, {'finite' if is_finite else 'linear'}, cells of {cell}"
    found, pressure = solved(bench, cell, friction, is_finite)
    if not found.converged:
        return row(label, "converged", found.end, False)
    down = found.last["probes"]["middle"]["displacement"][1]
    published = PUBLISHED[bench, friction]
    asked, stress = published.get("newer", published["quadratic"])
    others = ", ".join(f"{kind} {away(down, u):.1e} and {away(-pressure, s):.1e}" for kind, (u, s) in published.items())
    row(f"{label}: displacement", f"{asked} within 5e-3", f"{down:.7g}; off by {others}", away(down, asked) <= 5e-3)
    stress = -HERTZ if bench == 1 and not friction else stress
    row(f"{label}: pressure", f"{-stress} within 5e-3", f"{pressure:.6g}, off by {away(-pressure, stress):.1e}", away(-pressure, stress) <= 5e-3)
    return None


def main():
    common.arguments(__doc__, only=0)
    for bench, cells in ((1, (0.6, 0.3, 0.15)), (2, (1.0, 0.5, 0.25))):
        if common.given.only not in (0, bench):
            continue
        for cell in cells[:1] if common.given.quick else cells:
            for friction in (0.0, 0.1):
                for is_finite in (False, True):
                    tell(bench, cell, friction, is_finite)
    common.finish()


main()
