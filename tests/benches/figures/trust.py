#!/usr/bin/env python3
"""Every scene of cases/trust against its references.json: terminations, forces, energies, verdicts, warnings.

Numbers are compared relatively (of zero: to the largest force or energy of the step); `lift` compares its third step
with its first, fields too, to ten tolerances.
"""
import json

import numpy as np

import common
import vtu
from common import FOLDER, close, row, solve


def at(step, path):
    """The value of a dotted path."""
    for key in path.removeprefix("abs:").split("."):
        step = step[int(key) if isinstance(step, list) else key]
    return abs(step) if path.startswith("abs:") else step


def scale(step):
    """The largest force of a step."""
    forces = [abs(x) for kind in ("obstacles", "supports") for one in step[kind].values() for x in one["force"]]
    return max(forces, default=0.0)


def exact(name, run, expected, tolerance):
    for path, value in expected.items():
        found = at(run.last, path) if run.steps else None
        if isinstance(value, str):
            row(f"{name}: {path}", value, found, found == value)
        elif found is None:
            row(f"{name}: {path}", f"{value:.9g} within {tolerance:g}", run.end, False)
        else:
            error = close(found, value) if value else abs(found) / scale(run.last)
            row(f"{name}: {path}", f"{value:.9g} within {tolerance:g}", f"{found:.9g} ({error:.1e})", error <= tolerance)


def any_of(name, run, choices):
    """One of: a number above another, a warning of that word."""
    told = [f"{w['kind']}: {w['message']}" for w in run.last.get("warnings", [])]
    met, words = False, []
    for choice in choices:
        for path, value in choice.items():
            if path == "warning":
                met |= any(value in line for line in told)
                words.append(f"warnings {[line.split(':')[0] for line in told]}")
            else:
                found = at(run.last, path)
                met |= found > float(value.lstrip(">"))
                words.append(f"{path} {found:.4g}")
    row(name, f"any of {json.dumps(choices)}", "; ".join(words), met)


def lift(name):
    out = FOLDER / name
    run = solve(common.case(f"trust/{name}.toml"), out=out)
    bound = 10 * (run.last.get("tolerance") or 1e-8)
    row(f"{name}: third step", "converged", run.end, run.converged and len(run.steps) == 3)
    if len(run.steps) < 3:
        return
    first, third = run.steps[0], run.steps[2]
    force = max(abs(a - b) for a, b in zip(first["obstacles"]["ball"]["force"], third["obstacles"]["ball"]["force"])) / scale(first)
    energy = close(first["strain_energy"], third["strain_energy"])
    row(f"{name}: force, energy of step 3 against 1", f"<= {bound:.0e}", f"{force:.1e}, {energy:.1e}", max(force, energy) <= bound)
    files = sorted(out.glob(f"{name}_[0-9]*.vtu"))
    fields = [vtu.read(files[i]) for i in (0, 2)]
    for field in ("displacement", "pressure", "contact_pressure", "gap", "contact_state"):
        values = fields[0][field]
        away = np.abs(values - fields[1][field]).max() / max(np.abs(values).max(), 1e-300)
        row(f"{name}: field {field}", f"<= {bound:.0e} of its largest", f"{away:.1e}", away <= bound)


def main():
    common.arguments(__doc__)
    for name, reference in json.loads(common.case("trust/references.json").read_text()).items():
        if name == "lift":
            lift(name)
            continue
        sets = ["solver.contact_space=linear"] if name == "side-by-side-1e6" else []
        run = solve(common.case(f"trust/{name}.toml"), *sets)
        if "expect" in reference:
            exact(name, run, reference["expect"], reference["tolerance"])
        elif "expect_any" in reference:
            any_of(name, run, reference["expect_any"])
        elif run.converged:
            exact(name, run, reference["expect_if_converged"], reference["tolerance"])
        else:
            row(name, "these values if converged", run.end, True)
    common.finish()


main()
