#!/usr/bin/env python3
"""The cases of two bodies with 12 digits, against the program and against this project's own independent solver.

A row a case and number: that of the case, the program's, the independent solver's on the same scene (`--peer 0` without),
and their differences. Asked is what the rules of the cases leave: straight edges and gap by volume nothing, closest
points, cells that stay straight under curved edges and a pinned node up to some thousandths. `--only NAME`
takes some. Needs: pip install numpy scipy meshio gmsh.
"""
import json
from pathlib import Path

import numpy as np

from shared import away, common, held, pair, row, vtu

MOONEY = {"model": "mooney-rivlin", "c10": 0.4, "c01": 0.1}
NEO = {"model": "neo-hookean", "shear_modulus": 1.0}
SHARP = {"tolerance": 1e-11, "quadrature_degree": 6}


def linear(shear):
    return {"model": "linear-elastic", "shear_modulus": shear, "poisson_ratio": 0.5}


def scaled(law, factor):
    return {key: value if key == "model" else factor * value for key, value in law.items()}


def case(name):
    return json.loads((Path(common.given.cases) / "two-bodies" / f"{name}.json").read_text())


def path(name):
    return Path(common.given.cases) / "two-bodies" / f"{name}.msh"


def moved(on, x=None, y=None):
    return {"displacement": {k: v for k, v in (("x", x), ("y", y)) if v is not None}}


def solved(name, keys):
    """The last result of the program, and that of the independent solver where it takes the scene."""
    scene = common.scene(name.replace("-", "_"), **keys)
    own = common.solve(scene)
    peer = None
    if common.given.peer and "values" not in str(keys["support"]):
        from pair_contact import solve
        from pair_scene import PairProblem

        try:
            peer = list(solve(PairProblem(scene), limit=120.0))
        except (ValueError, KeyError, ArithmeticError) as fault:  # What that solver does not take is told.
            print(f"    {name}: independent solver: {type(fault).__name__}: {fault}")
    return own, peer


def compare(name, keys, numbers, most):
    """Rows of numbers by what: (of the case, reading of the last result)."""
    own, peer = solved(name, keys)
    if not own.converged:
        return row(name, "converged", own.end, False)
    for what, (asked, read) in numbers.items():
        mine = read(own.last)
        words = f"{mine:.12g}, off by {away(mine, asked):.1e}"
        if peer and peer[-1].get("converged"):
            other = read(peer[-1])
            words += f"; independent {other:.12g}, off by {away(mine, other):.1e}"
        row(f"{name}: {what}", f"{asked:.12g} within {most:g}", words, away(mine, asked) <= most)
    return None


def energy(asked, of_volume=0.0):
    """The cases leave out what changes of volume store."""
    return {"energy": (asked, lambda last: last["strain_energy"] - of_volume)}


def force(asked, axis=1, name="pair"):
    return {f"force {'xy'[axis]}": (asked, lambda last: last["contacts"][name]["force"][axis])}


def peak(asked, name="pair"):
    return {"peak pressure": (asked, lambda last: last["contacts"][name]["peak_pressure"])}


def patch_flat():
    found = case("patch_flat_7_5")["results"]
    # The normal displacement of u = -0.1 (X - (.5, 0)) on all outer sides.
    sides = [("x0", "x", 0.05), ("x1", "x", -0.05)]
    supports = [held(f"{b}_{side}", **{axis: value}) for b in "ab" for side, axis, value in sides]
    supports += [held("a_y1", y=-0.1), held("b_y0", y=0.1)]
    body = MOONEY | {"bulk_modulus": 10.0}
    keys = {"mesh": path("patch_flat_7_5"), "material": {"body_a": body, "body_b": body}, "support": supports}
    keys |= {"contact": [pair("a_y0", "b_y1", carries="a_y0")], "solver": SHARP}
    numbers = energy(found["energy"], 2 * 5.0 * 0.19**2) | force(found["force_on_slave"][1]) | peak(found["pressure_uniform"])
    compare("patch_flat_7_5", keys, numbers, 1e-9)


def confined(name, carrier, bulk, squeeze, sides, bump=0.0):
    found = case(name)["results"]
    found = found.get("current_area", found)
    low, up, bottom, top, *walls = sides
    law = NEO | {"bulk_modulus": bulk}
    bodies = ("a", "b") if name[8] == "-" else ("body_a", "body_b")
    supports = [held(wall, x=0.0) for wall in walls]
    supports += [held(bottom, y=0.0), held(top, y=-squeeze)]
    if bump:
        supports[-2] = floor(name, bottom, bump)
    keys = {"mesh": path(name), "material": dict.fromkeys(bodies, law), "support": supports}
    keys |= {"contact": [pair(carrier, up if carrier == low else low, carries=carrier)], "solver": SHARP}
    height = 1.2 if name[8] == "-" else 2.0
    asked = energy(found.get("strain_energy", found.get("energy")), bulk / 2 * squeeze**2 / height)
    on_slave = found.get("contact_force_on_slave", found.get("force_on_slave"))[1]
    # On the uneven floor the change of volume is not the same everywhere: the force alone. Of 2 that the volume stores
    # eight digits of the rest are left.
    compare(name, keys, force(on_slave) if bump else asked | force(on_slave), 2e-3 if bump else 2e-8)


def floor(name, on, bump):
    """A support whose nodes rise by bump sin^2(pi x)."""
    nodes = points_of(name, path(name), on)
    file = common.FOLDER / f"{name}-floor.txt"
    lines = ["node, x, y, z"] + [f"{k}, 0, {bump * np.sin(np.pi * x) ** 2:.17g}, 0" for k, (x, _) in nodes]
    file.write_text("\n".join(lines) + "\n")
    return {"name": on, "on": on, "displacement": {"y": 0.0}, "values": file}


def points_of(name, mesh, on):
    """Nodes of a group, vertices and middles of its edges, by their numbers in the results."""
    import meshio

    read = meshio.read(mesh)
    tag = read.field_data[on][0]
    ends = np.concatenate([c.data[d == tag] for c, d in zip(read.cells, read.cell_data["gmsh:physical"]) if c.type == "line"])
    out = common.FOLDER / f"{name}-nodes"
    groups = {key: linear(1.0) for key, (_, dimension) in read.field_data.items() if dimension == 2}
    keys = {"mesh": mesh, "material": groups, "support": [held(key) for key, (_, d) in read.field_data.items() if d == 1]}
    common.solve(common.scene(f"{name}_nodes", **keys), out=out)
    places = vtu.read(next(out.glob("*.vtu")))["Points"][:, :2]
    wanted = np.concatenate([read.points[ends.ravel(), :2], read.points[ends, :2].mean(axis=1)])
    apart = np.linalg.norm(places[:, None] - wanted, axis=2).min(axis=1)
    return [(k, places[k]) for k in np.flatnonzero(apart < 1e-9)]


def patch_bend(name):
    found = case(name)["results"]
    turn = np.array([[np.cos(0.5), -np.sin(0.5)], [np.sin(0.5), np.cos(0.5)]])
    supports = []
    for on, shear in (("master_left", 1.0), ("slave_right", 10.0)):
        lines = ["node, x, y, z"]
        for k, place in points_of(name, path(name), on):
            x, y = place @ turn
            u = turn @ (np.array([(-1 + 1.5 * y) * x, y - 0.75 * y**2 - 0.75 * x**2]) / (4 * shear))
            lines.append(f"{k}, {u[0]:.17g}, {u[1]:.17g}, 0")
        file = common.FOLDER / f"{name}-{on}.txt"
        file.write_text("\n".join(lines) + "\n")
        supports.append({"name": on, "on": on, "displacement": {"x": 0.0, "y": 0.0}, "values": file})
    keys = {"mesh": path(name), "material": {"master": linear(1.0), "slave": linear(10.0)}, "support": supports}
    keys |= {"contact": [pair("slave_left", "master_right", carries="slave_left")], "solver": {"tolerance": 1e-12}}
    on_slave = found["contact_force_on_slave"]
    numbers = energy(0.16328125) | force(on_slave[0], 0) | force(on_slave[1], 1)
    compare(name, keys, numbers, 1e-10)


def floating():
    found = case("float-stiff-on-soft")["results"]
    keys = {"mesh": path("float-stiff-on-soft"), "material": {"a": linear(1.0), "b": linear(1000.0)}}
    keys |= {"support": [held("a_bot")], "traction": [{"on": "b_top", "value": [0.0, -0.05, 0.0]}]}
    keys |= {"contact": [pair("b_bot", "a_top", carries="b_bot")], "solver": SHARP}
    numbers = energy(found["strain_energy"]) | force(found["contact_force_on_slave"][1])
    compare("float-stiff-on-soft", keys, numbers, 1e-9)


def cylinders(name, shears):
    found = case(name)["results"]["current_area"]
    supports = [held("s_axis", x=0.0), held("m_axis", x=0.0)]
    steps = {"support": {"s_eq": moved("s_eq", y=None), "m_eq": moved("m_eq", y=None)}}
    ways = {"s_eq": -0.05, "m_eq": 0.05} if slave_is_above(name) else {"s_eq": 0.05, "m_eq": -0.05}
    supports += [held(on, y=0.0) for on in ways]
    steps = {"increments": 4, "support": {on: moved(on, y=way) for on, way in ways.items()}}
    material = {"master": rubber(shears[0]), "slave": rubber(shears[1])}
    keys = {"mesh": path(name), "material": material, "support": supports, "step": [steps]}
    keys |= {"contact": [pair("s_con", "m_con", carries="s_con")], "solver": SHARP}
    numbers = energy(found["strain_energy"]) | force(found["contact_force_on_slave"][1]) | peak(found["lambda_max_10pt"])
    compare(name, keys, numbers, 1e-2)


def rubber(shear):
    return NEO | {"shear_modulus": shear}


def slave_is_above(name):
    import meshio

    read = meshio.read(path(name))
    tag = read.field_data["s_con"][0]
    rows = [c.data[d == tag] for c, d in zip(read.cells, read.cell_data["gmsh:physical"])]
    return np.concatenate([read.points[r.ravel(), 1] for r in rows if len(r)]).mean() > 0


def slide():
    found = case("slide-equal")["results"]["current_area"]
    steps = [{"increments": 2, "support": {"d_top": moved("d_top", 0.0, -0.08)}}]
    steps += [{"increments": 2, "support": {"d_top": moved("d_top", 0.1, -0.08)}}]
    keys = {"mesh": path("slide-equal"), "material": {"slab": NEO, "disc": NEO}, "step": steps}
    keys |= {"support": [held("s_bot"), held("d_top")], "contact": [pair("d_con", "s_top", carries="d_con")], "solver": SHARP}
    numbers = energy(found["strain_energy"]) | force(found["contact_force_on_slave"][1]) | peak(found["lambda_max_10pt"])
    compare("slide-equal", keys, numbers, 5e-3)


def iron(name, factor, carrier):
    found = case(name)
    steps = [{"support": {"a_y1": moved("a_y1", p["x"], p["y"])}} for p in found["path"]]
    material = {"body_a": scaled(MOONEY, factor), "body_b": MOONEY}
    keys = {"mesh": path(name), "material": material, "step": steps, "solver": SHARP}
    keys |= {"support": [held("b_y0"), held("b_x0", x=0.0), held("b_x1", x=0.0), held("a_y1")]}
    keys |= {"contact": [pair("a_y0", "b_y1", carries=carrier)]}
    last = found["path"][-1]
    compare(name, keys, energy(last["E"]) | force(last["F"][1]), 1e-3)


def shrunk(name, carrier):
    found = case(name)["results"]
    first, second = carrier, {"ring_x0": "core_x1", "core_x1": "ring_x0"}[carrier]
    supports = [held("core_x0")] + [held(f"{b}_y0", y=0.0) for b in ("ring", "core")]
    supports += [held(f"{b}_y1", x=0.0) for b in ("ring", "core")]
    keys = {"mesh": path(name), "material": {"body_ring": NEO, "body_core": NEO}, "support": supports}
    keys |= {"contact": [pair(first, second, carries=carrier)], "solver": SHARP}
    compare(name, keys, energy(found["energy"]) | force(found["force_on_slave"][0], 0), 1e-2)


def linear_shrunk():
    """The interference as a fiftieth of it in the mesh: linear bodies answer in proportion, but for a thousandth."""
    found, part = case("shrink-12-17")["results"], 2e-2
    mesh = common.FOLDER / "shrink-12-17.msh"
    bend("shrink-12-17", mesh, "inner_right", lambda p: p * (1 + 0.075 * part / np.hypot(*p)))
    supports = [held(f"{b}_bot", y=0.0) for b in ("inner", "outer")] + [held(f"{b}_top", x=0.0) for b in ("inner", "outer")]
    keys = {"mesh": mesh, "material": {"inner": linear(1.0), "outer": linear(1.0)}, "support": supports}
    keys |= {"contact": [pair("inner_right", "outer_left", carries="inner_right")], "solver": SHARP}
    numbers = {"energy": (found["strain_energy"], lambda last: last["strain_energy"] / part**2)}
    numbers |= {f"force {'xy'[i]}": (f, lambda last, i=i: last["contacts"]["pair"]["force"][i] / part)
                for i, f in enumerate(found["contact_force_on_slave"])}
    compare("shrink-12-17", keys, numbers, 1e-2)


def bend(name, target, on, where):
    """The mesh of second order with the nodes of a group moved."""
    import gmsh

    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.open(str(path(name)))
    if gmsh.model.mesh.getElementTypes()[-1] == 2:
        gmsh.model.mesh.setOrder(2)
    group = next(g for g in gmsh.model.getPhysicalGroups(1) if gmsh.model.getPhysicalName(*g) == on)
    tags, places = gmsh.model.mesh.getNodesForPhysicalGroup(*group)
    for tag, place in zip(tags, places.reshape(-1, 3)):
        gmsh.model.mesh.setNode(tag, [*where(place[:2]), 0.0], [])
    gmsh.option.setNumber("Mesh.MshFileVersion", 2.2)
    gmsh.write(str(target))
    gmsh.finalize()


def parabola(name, shears):
    """The gap x^2/2 as a hundred-thousandth of it in the mesh."""
    results, part = case(name)["results"], 1e-5
    mesh = common.FOLDER / f"{name}.msh"
    bend(name, mesh, "a_y0", lambda p: (p[0], p[1] + part * p[0] ** 2 / 2))
    steps = [{"support": {"a_y1": moved("a_y1", 0.0, -part * float(d))}} for d in results]
    keys = {"mesh": mesh, "material": {"body_a": linear(shears[0]), "body_b": linear(shears[1])}, "step": steps}
    keys |= {"support": [held("a_x0", x=0.0), held("b_x0", x=0.0), held("b_y0"), held("a_y1")]}
    keys |= {"contact": [pair("a_y0", "b_y1", carries="a_y0")], "solver": SHARP}
    last = list(results.values())[-1]
    numbers = {"force y": (last["F"], lambda end: end["contacts"]["pair"]["force"][1] / part)}
    numbers |= {"peak pressure": (last["pmax"], lambda end: end["contacts"]["pair"]["peak_pressure"] / part)}
    compare(name, keys, numbers, 1e-3)


def fold():
    found = case("fold_12_10")
    mesh = common.FOLDER / "fold_12_10.msh"
    parts("fold_12_10", mesh, {"top_pad": ("f_top", lambda x: x >= 1.8 - 1e-9), "low_pad": ("f_bottom", lambda x: x >= 1.8 - 1e-9)})
    ways = (0.04, 0.1, 0.13, 0.16, 0.18, 0.2, 0.22, 0.24)
    steps = [{"support": {"top_pad": moved("", None, -q), "low_pad": moved("", None, q)}} for q in ways]
    keys = {"mesh": mesh, "material": {"body_f": MOONEY}, "step": steps, "solver": SHARP}
    keys |= {"support": [held("f_left", x=0.0), held("top_pad", y=0.0), held("low_pad", y=0.0)]}
    keys |= {"contact": [pair("f_upper", "f_lower", carries="f_upper")]}
    results = found["results"]
    compare("fold_12_10", keys, energy(results["energy"]) | force(results["force_on_slave"][1]), 1e-3)


def slit():
    found = case("slit-12-9")["results"]["current_area"]
    mesh = common.FOLDER / "slit-12-9.msh"
    # The case pins the node nearest to x = 0; a support holds a facet.
    parts("slit-12-9", mesh, {"top_pin": ("top", lambda x: -1e-9 <= x < 0.11), "bot_pin": ("bot", lambda x: abs(x) < 0.06)})
    step = {"increments": 2, "support": {"top": moved("", None, -0.1), "bot": moved("", None, 0.1)}}
    keys = {"mesh": mesh, "material": {"block": NEO}, "step": [step], "solver": SHARP}
    keys |= {"support": [held("top", y=0.0), held("bot", y=0.0), held("top_pin", x=0.0), held("bot_pin", x=0.0)]}
    keys |= {"contact": [pair("low", "up", carries="low")]}
    compare("slit-12-9", keys, energy(found["strain_energy"]) | force(found["contact_force_on_slave"][1]), 2e-2)


def parts(name, target, groups):
    """The mesh of straight edges with further groups: facets of a group whose ends meet a condition on x."""
    import meshio

    read = meshio.read(path(name))
    kinds = {"line": 1, "triangle": 2}
    rows = [(kinds[c.type], int(g), ends.tolist()) for c, gs in zip(read.cells, read.cell_data["gmsh:physical"]) for ends, g in zip(c.data, gs)]
    names = {key: (int(tag), int(dimension)) for key, (tag, dimension) in read.field_data.items()}
    for new, (of, within) in groups.items():
        names[new] = (max(tag for tag, _ in names.values()) + 1, 1)
        rows += [(1, names[new][0], ends) for kind, g, ends in list(rows)
                 if kind == 1 and g == names[of][0] and all(within(read.points[k, 0]) for k in ends)]
    lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$PhysicalNames", str(len(names))]
    lines += [f'{dimension} {tag} "{key}"' for key, (tag, dimension) in names.items()]
    lines += ["$EndPhysicalNames", "$Nodes", str(len(read.points))]
    lines += [f"{k + 1} {x:.17g} {y:.17g} 0" for k, (x, y, *_) in enumerate(read.points)]
    lines += ["$EndNodes", "$Elements", str(len(rows))]
    lines += [f"{k + 1} {kind} 2 {g} {g} " + " ".join(str(e + 1) for e in ends) for k, (kind, g, ends) in enumerate(rows)]
    target.write_text("\n".join([*lines, "$EndElements", ""]))


BOX = ("a_top", "b_bot", "a_bot", "b_top", "a_left", "a_right", "b_left", "b_right")
SQUARES = ("b_y1", "a_y0", "b_y0", "a_y1", "a_x0", "a_x1", "b_x0", "b_x1")
CASES = {
    "patch_flat_7_5": patch_flat,
    "patch-bend-3-8": lambda: patch_bend("patch-bend-3-8"),
    "patch-bend-5-3": lambda: patch_bend("patch-bend-5-3"),
    "confined_8_5_flat_K2e4": lambda: confined("confined_8_5_flat_K2e4", "a_y0", 2e4, 0.02, SQUARES),
    "confined-flat-6-8": lambda: confined("confined-flat-6-8", "b_bot", 1e3, 0.1, BOX),
    "confined-bump-6-8": lambda: confined("confined-bump-6-8", "b_bot", 50.0, 0.1, BOX, 0.06),
    "float-stiff-on-soft": floating,
    "hertz2-equal": lambda: cylinders("hertz2-equal", (1.0, 1.0)),
    "hertz2-stiff-slave": lambda: cylinders("hertz2-stiff-slave", (1.0, 10.0)),
    "hertz_linear_16_14_equal": lambda: parabola("hertz_linear_16_14_equal", (1.0, 1.0)),
    "hertz_linear_16_14_soft_slave_1_10": lambda: parabola("hertz_linear_16_14_soft_slave_1_10", (1.0, 10.0)),
    "iron_straight": lambda: iron("iron_straight", 1.0, "a_y0"),
    "iron_straight_slider_x10_slave_block": lambda: iron("iron_straight_slider_x10_slave_block", 10.0, "b_y1"),
    "shrink-12-17": linear_shrunk,
    "shrink_16_11_straight": lambda: shrunk("shrink_16_11_straight", "ring_x0"),
    "shrink_16_11_straight_slave_core": lambda: shrunk("shrink_16_11_straight_slave_core", "core_x1"),
    "slide-equal": slide,
    "fold_12_10": fold,
    "slit-12-9": slit,
}


def main():
    common.arguments(__doc__, only="", peer=1)
    for name, one in CASES.items():
        if not common.given.only or common.given.only in name:
            one()
    common.finish()


main()
