#!/usr/bin/env python3
"""Forces and energies of the benchmark scenes in both contact spaces against the exact discrete ones of independent codes.

Rubber is integrated by a rule of degree 8 there, as `solver.quadrature_degree` asks here. Relative errors, the largest of all increments.
"""
import json

import common
from common import case, case_mesh, close, row, solve

AXES = "xyz"


def compare(scene, mesh, space, steps, factor, tolerance, axis):
    """`steps` have force and strain energy; `factor` (force, energy): of the whole body over those of the model."""
    sets = [f"mesh={case_mesh(mesh)}", f"solver.contact_space={space}"]
    run = solve(case(f"{scene}.toml"), *sets, *(["solver.quadrature_degree=8"] if scene.startswith("mr-") else []))
    label = f"{scene} {mesh} {space}"
    if not run.converged or len(run.steps) != len(steps):
        row(label, "converged", run.end, False)
        return
    force, energy = 0.0, 0.0
    for found, known in zip(run.steps, steps):
        (obstacle,) = found["obstacles"].values()
        force = max(force, close(abs(obstacle["force"][axis]) * factor[0], known["force"]))
        energy = max(energy, close(found["strain_energy"] * factor[1], known["strain_energy"]))
    row(f"{label}: force, energy", f"<= {tolerance:g}", f"{force:.1e}, {energy:.1e}", max(force, energy) <= tolerance)


def main():
    common.arguments(__doc__)
    linear = json.loads(case("references.json").read_text())
    quadratic = json.loads(case("contact-space/references.json").read_text())
    for scene, known in linear.items():
        if "obstacle" not in known:
            continue
        factor = (known["whole_body_factor"],) * 2
        axis = AXES.index(known["force_axis"])
        for mesh, digits in known["meshes"].items():
            compare(scene, mesh, "linear", digits["steps"], factor, known["tolerance"], axis)
        for mesh, digits in quadratic.get(scene, {}).items():
            steps = digits.get("degree_8", [digits])
            compare(scene, mesh, "quadratic", steps, (factor[0], 1), 1e-7 if "degree_8" in digits else 1e-9, axis)
    common.finish()


main()
