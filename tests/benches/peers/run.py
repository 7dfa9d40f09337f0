#!/usr/bin/env python3
"""Measures Signorini and its peers by turns and writes peers.csv and paired.csv.

usage: run.py --signorini PROGRAM [--sizes n6,n10,l1,l2] [--scenes NAME,..] [--solvers NAME,..] [--repeats 3] [--limit 600] [--out DIR] [--add]

Every run is a fresh process. In each round every case runs once, Signorini before each peer on the same scene and
mesh, so that the noise of the machine spreads over both; a case is its run of median seconds. Keep the machine quiet.
peers.csv is what `signorini bench --peers` draws; paired.csv has Signorini's rows of the same rounds beside it, and the
end of the output the ratio of each pair. A solver that is not installed is left out with a line.
"""
import argparse
import csv
import json
import math
import os
import subprocess
import sys
import tempfile
import time

from report import COLUMNS, processor, threads
from scenes import HERE, PREFIX, ROOT, SHIPPED, WHOLE_BODY, cube

FRICTION = ("cube-drag", "hertz-press")
LINEAR, CONTACT, RUBBER = ("cube-bend", "A1m"), ("hertz-plane", "hertz-sphere"), ("mr-uniax", "mr-block", "mr-sphere")
# Scenes by the letter of their levels.
SCENES = {"n": (*LINEAR, "mr-uniax", "mr-block", "cube-drag"), "l": (*CONTACT, "mr-sphere", "hertz-press")}
# Levels that other scenes go without.
FRICTION_ONLY = ("n4", "n8")
SCENE_FILES = {"A1m": "manufactured", "hertz-press": "hertz-plane"}
# Changes of the scene file. The multipliers of the peers are of first order at best.
ROUGH = ["solver.contact_space=linear"]
SETTINGS = {
    "cube-drag": ROUGH,
    "hertz-press": [*ROUGH, "material.body.poisson_ratio=0.3", "obstacle.0.friction=0.3", "step.0.increments=4"],
}
SYSTEM_PYTHON = "/usr/bin/python3"

# Name, script, further arguments, scenes, interpreter, largest levels worth trying.
PEERS = {
    "ngsolve-two-level": ("ngsolve_linear.py", ["two-level"], LINEAR, sys.executable, ["n34"]),
    "ngsolve-pardiso": ("ngsolve_linear.py", ["pardiso"], LINEAR, sys.executable, ["n16"]),
    "ngsolve-active-set": ("ngsolve_contact.py", [], CONTACT, sys.executable, ["l5"]),
    "ngsolve-rubber": ("ngsolve_rubber.py", [], RUBBER, sys.executable, ["n10", "l3"]),
    "petsc-gamg": ("fenicsx_linear.py", [], LINEAR, SYSTEM_PYTHON, ["n16"]),
    "getfem": ("getfem_contact.py", [], CONTACT, SYSTEM_PYTHON, ["l4"]),
    "getfem-friction": ("getfem_friction.py", [], FRICTION, SYSTEM_PYTHON, ["n10", "l4"]),
    "calculix-mortar": ("calculix_friction.py", ["mortar"], FRICTION, SYSTEM_PYTHON, ["n8", "l1"]),
    "calculix-penalty": ("calculix_friction.py", ["penalty"], FRICTION, SYSTEM_PYTHON, ["n8", "l4"]),
}
# What a row of a failure is called, as the scripts call their rows.
LABELS = {
    "ngsolve-two-level": "NGSolve two-level",
    "ngsolve-pardiso": "NGSolve Pardiso",
    "ngsolve-active-set": "NGSolve active set",
    "ngsolve-rubber": "NGSolve active set",
    "petsc-gamg": "PETSc GAMG",
    "getfem": "GetFEM augmented Lagrangian",
    "getfem-friction": "GetFEM augmented Lagrangian",
    "calculix-mortar": "CalculiX mortar",
    "calculix-penalty": "CalculiX penalty",
}
ALL_SIZES = "n4,n6,n8,n10,n16,n24,n34,l1,l2,l3,l4,l5"

HEADER = """\
# What other solvers needed for scenes of `signorini bench` (give this file as --peers). Written by tests/benches/peers/run.py.
# Machine: {processor}, {threads} cores; {date}; median of {repeats} runs, taken by turns with Signorini's; one process a run.
# Seconds of wall time without mesh reading, output and error norms, with loads, assembly, set-up and solve. Peak memory of the process,
# error norms not yet taken; that of Python-driven solvers holds 120 to 150 MB of interpreter and libraries.
# NGSolve two-level: block-diagonal MINRES, displacement by node-block Gauss-Seidel / exact P1 solve / Gauss-Seidel, exact pressure mass,
#   relative preconditioned residual 1e-8. NGSolve Pardiso: direct on the saddle point. NGSolve active set: semismooth Newton, a direct
#   factor each iteration, exact P1 multiplier, to 1e-10; of rubber all increments. PETSc GAMG: MINRES, smoothed aggregation with six
#   rigid modes, exact pressure mass, 1e-8, one thread by build. GetFEM: integral augmented Lagrangian (its discrete problem differs
#   slightly), MUMPS, one thread.
# Versions: {versions}.
"""
ADDED = "# {scenes}: {processor}, {threads} cores; {date}; median of {repeats} runs, taken by turns; {versions}.\n"


def of_size(level):
    return int(level[1:])


def is_worth_trying(name, scene, level):
    _, _, scenes, _, largest = PEERS[name]
    if level in FRICTION_ONLY and scene not in FRICTION:
        return False
    return scene in scenes and any(level[0] == most[0] and of_size(level) <= of_size(most) for most in largest)


def cases(sizes, scenes, chosen):
    """Scene, level and peers of each pair, small meshes first."""
    for level in sorted(sizes, key=of_size):
        for scene in SCENES[level[0]]:
            fitting = [name for name in chosen if scene in scenes and is_worth_trying(name, scene, level)]
            if fitting:
                yield scene, level, fitting


def run(command, limit, folder=HERE):
    """The output of a process; none when it fails or takes too long."""
    environment = dict(os.environ, OMP_NUM_THREADS=str(threads()), MKL_NUM_THREADS=str(threads()))
    try:
        ended = subprocess.run(command, capture_output=True, text=True, timeout=limit, cwd=folder, env=environment, check=False)
    except subprocess.TimeoutExpired:
        return None, f"more than {limit} s"
    if ended.returncode != 0:
        lines = ended.stderr.strip().splitlines()
        return None, lines[-1] if lines else f"exit code {ended.returncode}"
    return ended.stdout, ""


def judged(row):
    """A peer's row; a failure where one of its values is no number."""
    numbers = {column: value for column, value in row.items() if not (isinstance(value, float) and math.isnan(value))}
    fault = "" if len(numbers) == len(row) else "ended without numbers"
    return ({**numbers, "failure": fault} if fault else row), fault


def peer(name, scene, level, arguments):
    script, more, scenes, python, _ = PEERS[name]
    options = [*more, "--meshes", arguments.meshes] if arguments.meshes and scenes is not LINEAR else more
    start = time.perf_counter()
    output, fault = run([python, script, scene, level, *options], arguments.limit)
    rows = [line for line in (output or "").splitlines() if line.startswith("{")]
    if rows:
        return judged(json.loads(rows[-1]))
    fault = fault or "no result"
    seconds = time.perf_counter() - start
    row = {"scene": scene, "level": level, "solver": LABELS[name], "seconds": seconds, "failure": fault}
    return {**row, "threads": threads(), "version": "", "processor": processor()}, fault


def msh_of(grid):
    """A grid as text of the Gmsh format 2.2."""
    names = sorted(set(grid.sides))
    lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$PhysicalNames", str(len(names) + 1)]
    lines += [f'2 {11 + k} "{name}"' for k, name in enumerate(names)] + ['3 1 "body"', "$EndPhysicalNames"]
    lines += ["$Nodes", str(len(grid.points))]
    lines += [f"{k} {x!r} {y!r} {z!r}" for k, (x, y, z) in enumerate(grid.points.tolist(), start=1)]
    lines += ["$EndNodes", "$Elements", str(len(grid.facets) + len(grid.cells))]
    number = 0
    for facet, side in zip((grid.facets + 1).tolist(), grid.sides):
        number += 1
        tag = 11 + names.index(side)
        lines.append(f"{number} 2 2 {tag} {tag} {facet[0]} {facet[1]} {facet[2]}")
    for cell in (grid.cells + 1).tolist():
        number += 1
        lines.append(f"{number} 4 2 1 1 {cell[0]} {cell[1]} {cell[2]} {cell[3]}")
    return "\n".join([*lines, "$EndElements", ""])


def mesh_file(scene, level, folder, meshes):
    if level[0] == "l":
        name = f"{PREFIX[scene]}_{level}.msh"
        own = os.path.join(meshes, name) if meshes else ""
        return own if os.path.exists(own) else os.path.join(SHIPPED, name)
    path = os.path.join(folder, f"cube_{level}.msh")
    if not os.path.exists(path):
        with open(path, "w", encoding="ascii") as file:
            file.write(msh_of(cube(of_size(level))))
    return path


def signorini(scene, level, folder, arguments):
    """A cold solve: seconds of the step without error norms, as the bench takes them."""
    file = os.path.join(ROOT, "client", "examples", f"{SCENE_FILES.get(scene, scene)}.toml")
    mesh = mesh_file(scene, level, folder, arguments.meshes)
    command = [arguments.signorini, "solve", "--json", "--quiet", file, "--set", f"mesh={mesh}", "--set", f"solver.tolerance={arguments.tolerance}"]
    command += [part for key in SETTINGS.get(scene, ()) for part in ("--set", key)]
    output, fault = run(command, arguments.limit, folder)
    if output is None:
        return None, fault
    lines = [json.loads(line) for line in output.splitlines()]
    step = [line for line in lines if line["event"] == "step"][-1]
    summary = [line for line in lines if line["event"] == "summary"][-1]
    seconds = summary["totals"]["seconds"]
    row = {
        "scene": scene,
        "level": level,
        "solver": "Signorini",
        "unknowns": sum(step["unknowns"].values()),
        "seconds": seconds["total"] - seconds.get("error_norms", 0.0),
        "seconds_assembly": seconds["prepare"] + seconds["assemble"],
        "seconds_setup": seconds["factorise"],
        "seconds_solve": seconds["krylov"] + seconds["contact"],
        "iterations": summary["totals"]["krylov_iterations"],
        "peak_memory_mb": (summary["peak_memory_bytes"] or 0) * 1e-6,
        "threads": threads(),
        "version": step["instruction_set"],
        "processor": processor(),
    }
    for obstacle in step["obstacles"].values():
        row["value_force"] = WHOLE_BODY[scene] * abs(obstacle["force"][2])
        if scene in FRICTION:
            row["value_tangential_force"] = WHOLE_BODY[scene] * math.hypot(*obstacle["force"][:2])
        row["value_strain_energy"] = WHOLE_BODY[scene] * step["strain_energy"]
    return row, ""


def median(rows):
    """The row of median seconds, the faster one of an even number; a failure if there was one."""
    rows = [row for row in rows if row.get("failure")] or rows
    rows = sorted(rows, key=lambda row: row["seconds"])
    row = dict(rows[(len(rows) - 1) // 2])
    row["runs"] = len(rows)
    return row


def measure(arguments, folder):
    """Rows of each case, ours and theirs, round by round."""
    found, dropped = {}, set()
    plan = list(cases(arguments.sizes, arguments.scenes, arguments.solvers))
    for turn in range(1, arguments.repeats + 1):
        for scene, level, names in plan:
            for name in names:
                if (scene, name) in dropped:
                    continue
                for solver, task in (
                    ("signorini", lambda: signorini(scene, level, folder, arguments)),
                    (name, lambda: peer(name, scene, level, arguments)),
                ):
                    row, fault = task()
                    told = fault or f"{row['seconds']:.3f} s"
                    print(f"round {turn}: {scene} {level} {solver}: {told}", file=sys.stderr, flush=True)
                    if row:
                        found.setdefault((scene, level, solver), []).append(row)
                    if fault and solver != "signorini":
                        # Finer meshes will not do better.
                        dropped.add((scene, name))
    return {key: median(rows) for key, rows in found.items()}


def text_of(row, column):
    value = row.get(column)
    if value is None:
        return ""
    # The error of mr-uniax is the rounding of its values.
    digits = 16 if column.startswith("value_") else 10
    return f"{value:.{digits}g}" if isinstance(value, float) else str(value)


def write(path, rows, header=""):
    with open(path, "w", newline="", encoding="utf-8") as file:
        file.write(header)
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(COLUMNS)
        # Curves are drawn in the order of the rows.
        by_size = sorted(rows, key=lambda row: (row["scene"], int(row.get("unknowns") or 0)))
        writer.writerows([text_of(row, column) for column in COLUMNS] for row in by_size)


def kept(path, new):
    """The comments of a file, and its rows but those that `new` has anew."""
    with open(path, encoding="utf-8") as file:
        lines = file.readlines()
    comments = [line for line in lines if line.startswith("#")]
    name = lambda row: (row["scene"], row["level"], row["solver"])
    anew = {name(row) for row in new}
    rows = csv.DictReader(line for line in lines if not line.startswith("#"))
    return "".join(comments), [row for row in rows if name(row) not in anew]


def tell_pairs(found):
    print("scene        level  solver                       peer s   ours s   ratio")
    for (scene, level, solver), row in found.items():
        ours = found.get((scene, level, "signorini"))
        if solver != "signorini" and ours and not row.get("failure"):
            ratio = row["seconds"] / ours["seconds"]
            print(f"{scene:12} {level:5} {row['solver']:28} {row['seconds']:8.3f} {ours['seconds']:8.3f} {ratio:7.1f}")


def parsed():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--signorini", default=os.path.join(ROOT, "target", "release", "signorini"))
    parser.add_argument("--sizes", default=ALL_SIZES, help=ALL_SIZES)
    parser.add_argument("--scenes", default=",".join(LINEAR + CONTACT + RUBBER + FRICTION))
    parser.add_argument("--solvers", default=",".join(PEERS), help=", ".join(PEERS))
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--limit", type=float, default=600.0, help="seconds of one run")
    parser.add_argument("--tolerance", default="1e-8", help="of Signorini")
    parser.add_argument("--meshes", help="folder of finer Gmsh meshes")
    parser.add_argument("--out", default=HERE)
    parser.add_argument("--add", action="store_true", help="to the rows that peers.csv has")
    arguments = parser.parse_args()
    arguments.signorini = os.path.abspath(arguments.signorini)
    arguments.sizes = arguments.sizes.split(",")
    arguments.scenes = arguments.scenes.split(",")
    arguments.solvers = arguments.solvers.split(",")
    return arguments


def main():
    arguments = parsed()
    with tempfile.TemporaryDirectory() as folder:
        found = measure(arguments, folder)
    peers = [row for (_, _, solver), row in found.items() if solver != "signorini"]
    about = {
        "scenes": ", ".join(sorted({row["scene"] for row in peers})),
        "processor": processor(),
        "threads": threads(),
        "date": time.strftime("%Y-%m-%d"),
        "repeats": arguments.repeats,
        "versions": "; ".join(sorted({row["version"] for row in peers if row["version"]})),
    }
    path, pairs = (os.path.join(arguments.out, name) for name in ("peers.csv", "paired.csv"))
    if arguments.add:
        comments, rows = kept(path, peers)
        write(path, rows + peers, comments + ADDED.format(**about))
        write(pairs, kept(pairs, found.values())[1] + list(found.values()))
    else:
        write(path, peers, HEADER.format(**about))
        write(pairs, found.values())
    tell_pairs(found)


if __name__ == "__main__":
    main()
