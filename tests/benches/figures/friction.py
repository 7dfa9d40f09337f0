#!/usr/bin/env python3
"""Friction: discrete references of two independent codes in the linear contact space, and seconds over those of the smooth scene.

References: force (vector), energy, dissipation (over the energy) of each increment; counts of stick, slip and open where all margins exceed 1e-5.
Seconds: medians of the ratios of pairs, the rough scene by turns with the one of mu = 0. Keep the machine quiet.
"""
import json

import common
from common import by_turns, case, case_mesh, close, median, row, solve, worst

COUNTS = ("stick_vertices", "slip_vertices", "open_vertices")
MARGINS = ("open_margin", "pressure_margin", "stick_margin", "slip_margin")
# Scene file, name of its obstacle, mesh.
PAIRS = (
    ("hertz-plane.toml", "hemi_l3"),
    ("hertz-sphere.toml", "indent_l2"),
    ("hertz-sphere.toml", "indent_l3"),
    ("hertz-sphere.toml", "indent_l4"),
    ("mr-block.toml", "cube_n6"),
    ("mr-sphere.toml", "indent_l2"),
)


def apart(found, known):
    """Distance of two force vectors over the length of the second."""
    length = sum(x * x for x in known) ** 0.5
    return sum((a - b) ** 2 for a, b in zip(found, known)) ** 0.5 / max(length, 1e-300)


def reference(key, known):
    scene, mesh, *changes = key.split("|")
    values = dict(change.split("=") for change in changes)
    names = list(known["steps"][0]["obstacles"])
    own = case(f"friction/meshes/{mesh}.msh")
    sets = [f"mesh={own if own.exists() else case_mesh(mesh)}", "solver.contact_space=linear"]
    sets += [f"obstacle.{name}.friction={values['friction']}" for name in names if "friction" in values]
    sets += [f"solver.quadrature_degree={values['degree']}" for _ in [0] if "degree" in values]
    run = solve(case(f"friction/{scene}.toml"), *sets)
    if not run.converged or len(run.steps) != len(known["steps"]):
        row(f"reference {key}", "converged", run.end, False)
        return
    forces, energies, losses, counts = [], [], [], 0
    for found, right in zip(run.steps, known["steps"]):
        energies.append(close(found["strain_energy"], right["strain_energy"]))
        for name, exact in right["obstacles"].items():
            ours = found["obstacles"][name]
            forces.append(apart(ours["force"], exact["force"]))
            lost = abs(ours["dissipated_energy"] - exact.get("dissipated_energy", ours["dissipated_energy"]))
            losses.append(lost / right["strain_energy"])
            if all(exact.get(margin, 1.0) > 1e-5 for margin in MARGINS) and "stick_vertices" in exact:
                counts += any(ours[name] != exact[name] for name in COUNTS)
    tolerance = known.get("tolerance", 1e-7)
    tolerance = max(tolerance, 1e-6 if "degree" in values else 1e-7)
    most = max(worst(forces), worst(energies), worst(losses))
    row(f"reference {key}: force, energy, dissipation, wrong counts", f"<= {tolerance:g}, 0",
        f"{worst(forces):.1e}, {worst(energies):.1e}, {worst(losses):.1e}, {counts}", most <= tolerance and counts == 0)


def obstacle_of(file):
    return next(line.split('"')[1] for line in case(file).read_text().split("[[obstacle]]")[1].splitlines() if line.startswith("name"))


def seconds(file, mesh, space, coefficient):
    sets = [f"mesh={case_mesh(mesh)}", f"solver.contact_space={space}"]
    rough = f"obstacle.{obstacle_of(file)}.friction={coefficient}"
    smooth, with_it = by_turns(lambda: solve(case(file), *sets), lambda: solve(case(file), *sets, rough), repeats=3)
    ratio = median([b.seconds / a.seconds for a, b in zip(smooth, with_it)])
    limit = 1.5 if coefficient <= 0.5 else 2.0
    last = with_it[0]
    newton = sum(s.get("newton_steps", 0) for s in last.steps) / max(1, sum(s["sqp_iterations"] for s in last.steps))
    ends = "" if last.converged and smooth[0].converged else f"; {smooth[0].end}, {last.end}"
    row(f"{file[:-5]} {mesh} {space}, mu {coefficient}: seconds over the smooth ones", f"<= {limit}",
        f"{ratio:.2f} ({median([r.seconds for r in smooth]):.2f} s; {sum(smooth[0].applications)} and {sum(last.applications)} applications, {newton:.1f} Newton steps a program{ends})",
        ratio <= limit and not ends)


def main():
    given = common.arguments(__doc__, only="references,seconds")
    known = json.loads(case("friction/references.json").read_text())
    if "references" in given.only:
        for key, found in known.items():
            if not key.startswith("_"):
                reference(key, found)
    if "seconds" in given.only:
        for space in ("quadratic", "linear"):
            for file, mesh in PAIRS[:3] if given.quick else PAIRS:
                for coefficient in (0.3, 1.0):
                    seconds(file, mesh, space, coefficient)
    common.finish()


main()
