#!/usr/bin/env python3
"""Random families of contact scenes against Signorini. usage:
    family.py make  --seed S --count N --out DIR          scene and mesh files
    family.py peer  --seed S --count N --out DIR          and this solver's numbers, SCENE.SPACE.json
    family.py keep  --out DIR --digits FILE SCENE ...     copies scenes and keeps their numbers in both spaces
    family.py run   --seed S --count N --out DIR --binary PATH [--space SPACE] [--limit SECONDS]

`run` solves every scene by `PATH solve SCENE --json` and compares each increment: strain energy and obstacle forces
to 1e-5 of the energy and of the largest force. Verdicts: agree; failed (this solver has a stable equilibrium,
Signorini none); both-failed; peer-failed; unstable (the tangent has a negative eigenvalue on the kernel of the
constraints here, and Signorini stops); false-minimum (the same equilibrium, unstable here, a minimum there); disagree; disagree-unstable. It writes SPACE.csv and prints a table.
"""
import argparse
import csv
import json
import os
import shutil
import subprocess
import time
from collections import Counter
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("MKL_NUM_THREADS", "1")

import numpy as np

import family_scenes
import saddle_contact
from saddle_scene import Problem

TOLERANCE = 1e-5
COLUMNS = (
    "index", "kind", "dim", "bulk", "squeeze", "material", "increments", "verdict", "energy_error", "force_error",
    "step_failed", "cause", "peer_seconds", "seconds",
)


def make(given, index):
    """Writes one scene; gives its path and draft."""
    draft, text = family_scenes.scene(given.seed, index)
    stem = Path(given.out) / f"{given.seed}-{index:04d}-{draft.kind}"
    mesh, scene = stem.with_suffix(".msh"), stem.with_suffix(".toml")
    if not scene.exists():
        draft.box.write(mesh)
        scene.write_text(text.replace("MESH", mesh.name))
    return scene, draft, text


def peer(scene, space):
    """This solver's increments, from the file beside the scene where there is one."""
    kept = scene.with_suffix(f".{space}.json")
    if kept.exists():
        return json.loads(kept.read_text())
    began = time.perf_counter()
    try:
        with np.errstate(all="ignore"):
            steps = list(saddle_contact.solve(Problem(scene, space)))
    except Exception as fault:  # A scene that this solver cannot take is a verdict, not an end.
        steps = [{"step": 1, "increment": 1, "converged": False, "cause": f"{type(fault).__name__}: {fault}"}]
    found = {"seconds": round(time.perf_counter() - began, 2), "steps": steps}
    kept.write_text(json.dumps(found))
    return found


def signorini(scene, given):
    """Increments of the binary and its seconds; an empty list where it says nothing."""
    command = [given.binary, "solve", str(scene), "--json", *(given.options or "").split()]
    began = time.perf_counter()
    try:
        output = subprocess.run(command, capture_output=True, text=True, timeout=given.limit).stdout
    except subprocess.TimeoutExpired as late:
        output = (late.stdout or b"").decode()
    events = [json.loads(line) for line in output.splitlines() if line.startswith("{") and line.endswith("}")]
    return [e for e in events if e.get("event") == "step"], round(time.perf_counter() - began, 2)


def errors(own, other):
    """Relative differences of strain energy and of the obstacle forces."""
    scale = max(np.abs(force).max() for force in own["obstacles"].values())
    floor = 1e-30
    energy = abs(other["strain_energy"] - own["strain_energy"]) / max(own["strain_energy"], floor)
    force = max(
        np.abs(np.array(other["obstacles"][name]["force"]) - value).max() for name, value in own["obstacles"].items()
    )
    return energy, force / max(scale, floor)


def judge(own, other):
    """The verdict of a scene with the largest errors, the first failed increment and its cause."""
    worst = [0.0, 0.0]
    for number, step in enumerate(own):
        theirs = other[number] if number < len(other) else None
        failed = theirs is None or theirs["termination"] != "converged"
        cause = "no result" if theirs is None else str(theirs.get("cause") or "")
        if not step["converged"]:
            return ("both-failed" if failed else "peer-failed"), worst, number + 1, f"{cause} / {step['cause']}"
        if failed:
            return ("unstable" if is_unstable(step) else "failed"), worst, number + 1, cause
        worst = [max(pair) for pair in zip(worst, errors(step, theirs))]
        if max(worst) > TOLERANCE:
            return ("disagree-unstable" if is_unstable(step) else "disagree"), worst, number + 1, ""
        if step["unstable_motions"] and theirs["stability"] == "minimum":
            return "false-minimum", worst, number + 1, ""
    return "agree", worst, "", ""


def is_unstable(step):
    """Whether this solver's path has left the stable branch."""
    return step.get("unstable_on_the_way", step["unstable_motions"]) > 0


def row(given, index, binary=True):
    scene, draft, text = make(given, index)
    own = peer(scene, given.space)
    found = {
        "index": index, "kind": draft.kind, "dim": draft.dim, "bulk": draft.bulk, "squeeze": draft.squeeze,
        "material": text.split('model = "')[1].split('"')[0],
        "increments": int(text.split("increments = ")[1].split()[0]), "peer_seconds": own["seconds"],
    }
    if not binary:
        last = own["steps"][-1]
        return found | {"verdict": "unstable" if last["converged"] and is_unstable(last) else str(last["converged"])}
    other, seconds = signorini(scene, given)
    verdict, worst, failed, cause = judge(own["steps"], other)
    return found | {
        "verdict": verdict, "energy_error": f"{worst[0]:.1e}", "force_error": f"{worst[1]:.1e}",
        "step_failed": failed, "cause": cause, "seconds": seconds,
    }


def digits(step):
    """What is kept of an increment."""
    forces = {name: [float(f"{x:.12g}") for x in force] for name, force in step["obstacles"].items()}
    return {"strain_energy": float(f"{step['strain_energy']:.12g}"), "obstacles": forces}


def keep(given):
    """Copies scenes with their meshes and writes their digits; of a space without a stable equilibrium none."""
    kept = {}
    for scene in map(Path, given.scenes):
        for suffix in (".toml", ".msh"):
            shutil.copy(scene.with_suffix(suffix), Path(given.out) / scene.with_suffix(suffix).name)
        found = {}
        for space in ("quadratic", "linear"):
            steps = list(saddle_contact.solve(Problem(scene, space)))
            if all(step["converged"] and not is_unstable(step) for step in steps):
                found[space] = [digits(step) for step in steps]
        kept[scene.stem] = found
        print(scene.stem, {space: len(steps) for space, steps in found.items()}, flush=True)
    Path(given.digits).write_text(json.dumps(kept, indent=1, sort_keys=True) + "\n")


def summary(rows):
    """Verdicts by kind of scene."""
    verdicts = sorted({r["verdict"] for r in rows})
    print("kind".ljust(16) + "".join(v.rjust(18) for v in verdicts))
    for kind in sorted({r["kind"] for r in rows}) + ["all"]:
        counts = Counter(r["verdict"] for r in rows if kind in ("all", r["kind"]))
        print(kind.ljust(16) + "".join(str(counts[v]).rjust(18) for v in verdicts))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=("make", "peer", "run", "keep"))
    parser.add_argument("scenes", nargs="*", help="scene files to keep")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--count", type=int, default=100)
    parser.add_argument("--out", default="family")
    parser.add_argument("--digits")
    parser.add_argument("--binary")
    parser.add_argument("--space", choices=("linear", "quadratic"), default="quadratic")
    parser.add_argument("--limit", type=float, default=120.0, help="seconds of one scene")
    parser.add_argument("--options", help="further words for the binary, like --set solver.contact_space=linear")
    given = parser.parse_intermixed_args()
    Path(given.out).mkdir(parents=True, exist_ok=True)
    if given.what == "keep":
        keep(given)
        return
    rows = []
    for index in range(given.first, given.first + given.count):
        if given.what == "make":
            make(given, index)
            continue
        rows.append(row(given, index, given.what == "run"))
        print(json.dumps(rows[-1]), flush=True)
    if rows:
        summary(rows)
        with open(Path(given.out) / f"{given.what}-{given.space}.csv", "w", newline="") as file:
            writer = csv.DictWriter(file, COLUMNS)
            writer.writeheader()
            writer.writerows(rows)


if __name__ == "__main__":
    main()
