#!/usr/bin/env python3
"""CalculiX on cube-drag and hertz-press. usage: /usr/bin/python3 calculix_friction.py SCENE LEVEL penalty|mortar [--meshes DIR]
Needs: apt install calculix-ccx python3-numpy python3-gmsh

C3D10 tetrahedra, geometrically linear, SPOOLES with threads. Contact is regularised in both ways: pressure = stiffness x overclosure,
and a stick slope that lets what sticks creep. `penalty` is face to face with the stiffness and slope that its manual advises (50 Young's
moduli, and a tenth); on cube-drag its iterations cycle in the increments that are asked for, so there it cuts them by itself. `mortar` (dual
Lagrange multipliers) takes the increments as they are and holds 1e4 Young's moduli, whose error is below that of the mesh; its "hard"
contact is softer than that.
Seconds are those of the whole program, a tenth of a second for its deck included.
"""
import argparse
import os
import re
import resource
import subprocess
import sys
import tempfile
import time

import report
from calculix_deck import DIRECT, Body, model, steps
from friction_scenes import SCENES, YOUNG, values_of
from scenes import WHOLE_BODY, grid

AUTOMATIC = ("*STATIC", "0.1, 1.")
# Type of the pair, stiffness and stick slope in Young's moduli a length.
CONTACT = {"penalty": ("SURFACE TO SURFACE", 50.0, 5.0), "mortar": ("MORTAR", 1e4, 1e4)}
# Residual and correction, relative to average forces and to the increment.
CONTROLS = ["*CONTROLS, PARAMETERS=FIELD", "1e-6, 1e-4, , , 1e-6"]


def interaction(kind):
    pair, stiffness, slope = CONTACT[kind]
    return ["*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR", f"{stiffness * YOUNG!r}"], slope * YOUNG, pair


def ccx(lines, folder):
    """Runs a deck; gives its output and its wall seconds."""
    with open(os.path.join(folder, "job.inp"), "w", encoding="ascii") as file:
        file.write("\n".join([*lines, ""]))
    start = time.perf_counter()
    ended = subprocess.run(["ccx", "-i", "job"], cwd=folder, capture_output=True, text=True, check=False)
    seconds = time.perf_counter() - start
    output = ended.stdout + ended.stderr
    if ended.returncode != 0 or "Job finished" not in output:
        faults = [line.strip(" *") for line in output.splitlines() if "*ERROR" in line]
        sys.exit(faults[0] if faults else f"ended without a result, exit code {ended.returncode}")
    return output, seconds


def last_force(folder):
    """What the tool exerts on the body: the supports hold the rest of the balance."""
    with open(os.path.join(folder, "job.dat"), encoding="ascii") as file:
        rows = re.findall(r"total force.*\n\s*\n\s*(\S+)\s+(\S+)\s+(\S+)", file.read())
    return [-float(text) for text in rows[-1]]


def version():
    asked = subprocess.run(["ccx", "-v"], capture_output=True, text=True, check=False)
    found = re.search(r"Version (\S+)", asked.stdout)
    return "CalculiX " + (found.group(1) if found else "unknown")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene", choices=sorted(SCENES))
    parser.add_argument("level", help="n6, l1, ..")
    parser.add_argument("contact", choices=sorted(CONTACT))
    parser.add_argument("--meshes", help="folder of finer meshes")
    arguments = parser.parse_args()
    scene = SCENES[arguments.scene]
    body = Body(grid(arguments.scene, arguments.level, arguments.meshes))
    head = model(body, scene, interaction(arguments.contact))
    cut = arguments.contact == "penalty" and arguments.scene == "cube-drag"
    clock = report.Clock()
    with tempfile.TemporaryDirectory() as folder:
        output, seconds = ccx(head + steps(scene, AUTOMATIC if cut else DIRECT, CONTROLS), folder)
        force = last_force(folder)
    clock.seconds["solve"] = seconds
    memory = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss * 1024e-6
    iterations = len(re.findall(r"\n iteration \d", output))
    print(f"{arguments.scene} {arguments.level}: {iterations} iterations of Newton's method", file=sys.stderr)
    report.emit(arguments.scene, arguments.level, f"CalculiX {arguments.contact}", 3 * len(body.nodes), clock, report.threads(), version(),
                peak_memory_mb=memory, **values_of(force, WHOLE_BODY[arguments.scene]))


if __name__ == "__main__":
    main()
