#!/usr/bin/env python3
"""Random families of contact scenes against Signorini. usage:
    family.py make  --seed S --count N --out DIR          scene and mesh files
    family.py peer  --seed S --count N --out DIR          and this solver's numbers, SCENE.SPACE.json
    family.py keep  --out DIR --digits FILE SCENE ...     copies scenes and keeps their numbers in both spaces
    family.py run   --seed S --count N --out DIR --binary PATH [--space SPACE] [--limit SECONDS]

`--kinds more` draws from the second table of kinds (`family_kinds`): rings about an axis, two materials, up to three
tools, lips, rough lids; `--only bricks`: blocks of long cells. There `run` also solves each scene with planes held by
`normal = 0` in place of components, which must give the same counts and results (column `twin`), and rough tools other
than one lid, which this solver does not take, where they stop, in four times the increments: confirmed (it stops in
the same place), cured (it goes through).

`run` solves every scene by `PATH solve SCENE --json` and compares each increment: strain energy and obstacle forces
to --near (1e-5) of the energy and of the largest force, and keeps the counts of each, SCENE.SPACE.steps.json.
Verdicts: agree; failed (this solver has a stable equilibrium, Signorini none); both-failed; peer-failed; unstable (the
tangent has a negative eigenvalue on the kernel of the constraints here, and Signorini stops); turned (cells are inside
out here, and it stops); penalised (it adds its penalty on changes of volume); false-minimum (the same equilibrium,
unstable here, a minimum there); disagree; disagree-unstable. It writes SPACE.csv and prints a table.
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

import family_kinds
import family_scenes
import saddle_contact
import saddle_friction
from saddle_scene import Problem

COLUMNS = (
    "index", "kind", "dim", "bulk", "contrast", "squeeze", "material", "increments", "verdict", "energy_error",
    "force_error", "step_failed", "cause", "most_applications", "twin", "peer_seconds", "seconds",
)
# What is kept of each increment of the binary.
KEPT = (
    "step", "increment", "time", "termination", "cause", "penalty", "preconditioner_applications",
    "cut_backs", "stability",
)
# Difference between a scene and its twin.
SAME = 1e-9
# Difference up to which a sharper tolerance is tried.
SHARPER = 1e-3


def make(given, index):
    """Writes one scene; gives its path and draft."""
    if given.kinds == "first":
        draft, text = family_scenes.scene(given.seed, index)
    else:
        draft, text = family_kinds.scene(given.seed, index, given.only)
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
            steps = rough_steps(scene) if "friction" in scene.read_text() else smooth_steps(scene, space)
    except Exception as fault:  # A scene that this solver cannot take is a verdict, not an end.
        steps = [{"step": 1, "increment": 1, "converged": False, "cause": f"{type(fault).__name__}: {fault}"}]
    found = {"seconds": round(time.perf_counter() - began, 2), "steps": steps}
    kept.write_text(json.dumps(found))
    return found


def smooth_steps(scene, space):
    return list(saddle_contact.solve(Problem(scene, space)))


def rough_steps(scene):
    """Those of a rough lid as the others are written; ends with the increment that does not converge."""
    rough, steps = saddle_friction.Rough(scene), []
    try:
        for step in rough.solve():
            force = {rough.problem.obstacle_names[0]: step.pop("force")}
            steps.append(step | {"converged": True, "unstable_motions": 0, "obstacles": force})
    except saddle_friction.NotConverged as fault:
        steps.append({"step": 0, "increment": 0, "converged": False, "cause": str(fault)})
    return steps


def signorini(scene, given, *more):
    """Increments of the binary and its seconds; an empty list where it says nothing."""
    command = [given.binary, "solve", str(scene), "--json", *(given.options or "").split(), *more]
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


def judge(own, other, near):
    """The verdict of a scene with the largest errors, the first failed increment and its cause."""
    worst = [0.0, 0.0]
    for number, step in enumerate(own):
        theirs = other[number] if number < len(other) else None
        failed = theirs is None or theirs["termination"] != "converged"
        cause = "no result" if theirs is None else str(theirs.get("cause") or "")
        if not step["converged"]:
            return ("both-failed" if failed else "peer-failed"), worst, number + 1, f"{cause} / {step['cause']}"
        if failed:
            return failure(step), worst, number + 1, cause
        worst = [max(pair) for pair in zip(worst, errors(step, theirs))]
        if max(worst) > near:
            if theirs["penalty"] > 0.0:
                return "penalised", worst, number + 1, f"penalty {theirs['penalty']:g}"
            return ("disagree-unstable" if is_unstable(step) else "disagree"), worst, number + 1, ""
        if step["unstable_motions"] and theirs["stability"] == "minimum":
            return "false-minimum", worst, number + 1, ""
    return "agree", worst, "", ""


def failure(step):
    """Why Signorini may well end where this solver goes on; a kept file may not tell of turned cells."""
    is_turned = (step.get("least_within") or 1.0) <= 0.0
    return "unstable" if is_unstable(step) else "turned" if is_turned else "failed"


def is_unstable(step):
    """Whether this solver's path has left the stable branch."""
    return step.get("unstable_on_the_way", step["unstable_motions"]) > 0


def row(given, index, binary=True):
    scene, draft, text = make(given, index)
    own = peer(scene, given.space) if is_solved_here(draft) else None
    found = {
        "index": index, "kind": draft.kind, "dim": draft.dim, "bulk": draft.bulk, "squeeze": draft.squeeze,
        "contrast": getattr(draft, "contrast", 1.0),
        "material": text.split('model = "')[1].split('"')[0],
        "increments": int(text.split("increments = ")[1].split()[0]), "peer_seconds": own["seconds"] if own else None,
    }
    if not binary:
        last = own["steps"][-1] if own else {"converged": None}
        return found | {"verdict": "unstable" if last["converged"] and is_unstable(last) else str(last["converged"])}
    other, seconds = signorini(scene, given)
    counts = [{key: step[key] for key in KEPT} for step in other]
    scene.with_suffix(f".{given.space}.steps.json").write_text(json.dumps(counts))
    verdict, worst, failed, cause = judge(own["steps"], other, given.near) if own else judge_alone(given, scene, other)
    if verdict == "disagree" and max(worst) < SHARPER:
        # What a tolerance of 1e-8 leaves where a motion is all but free.
        sharp, _ = signorini(scene, given, "--set", "solver.tolerance=1e-11")
        verdict, worst, failed, cause = judge(own["steps"], sharp, given.near)
        cause = f"{cause} sharp"
    return found | {
        "verdict": verdict, "energy_error": f"{worst[0]:.1e}", "force_error": f"{worst[1]:.1e}",
        "step_failed": failed, "cause": cause, "seconds": seconds,
        "most_applications": max((step["preconditioner_applications"] for step in counts), default=0),
        "twin": twin(given, scene, text, other) if given.kinds == "more" else "",
    }


def is_solved_here(draft):
    """All but rough tools other than one lid in the linear space."""
    return not getattr(draft, "friction", {}) or draft.linear_space


def judge_alone(given, scene, other):
    """Where only the binary solves a scene: `agree`, or what four times the increments say of its end."""
    if other and other[-1]["termination"] == "converged":
        return "agree", [0.0, 0.0], "", ""
    fine = scene.with_name(f"{scene.stem}-fine.toml")
    lines = scene.read_text().splitlines()
    count = lambda line: f"increments = {4 * int(line.split()[-1])}" if line.startswith("increments") else line
    fine.write_text("\n".join(map(count, lines)) + "\n")
    again, _ = signorini(fine, given)
    if not other or not again:
        return "silent", [0.0, 0.0], len(other), ""
    width = 1.0 / int(scene.read_text().split("increments = ")[1].split()[0])
    near = abs(again[-1]["time"] - other[-1]["time"]) <= width + 1e-9
    verdict = "cured" if again[-1]["termination"] == "converged" else "confirmed" if near else "elsewhere"
    return verdict, [0.0, 0.0], len(other), f"{other[-1]['cause']} / {again[-1]['cause']} at {again[-1]['time']:.4f}"


def twin(given, scene, text, other):
    """Whether planes held by their normal give the same: empty where no plane is."""
    lines = text.replace("MESH", scene.with_suffix(".msh").name).splitlines()
    one = lambda line: line.startswith("displacement") and line.count("=") == 2
    if not any(map(one, lines)):
        return ""
    path = scene.with_name(f"{scene.stem}-normal.toml")
    path.write_text("\n".join("normal = 0.0" if one(line) else line for line in lines) + "\n")
    same, _ = signorini(path, given)
    if len(same) != len(other):
        return f"{len(same)} increments for {len(other)}"
    for a, b in zip(other, same):
        if a["preconditioner_applications"] != b["preconditioner_applications"]:
            return f"{b['preconditioner_applications']} for {a['preconditioner_applications']} in {a['increment']}"
        mine = {"strain_energy": a["strain_energy"], "obstacles": {n: o["force"] for n, o in a["obstacles"].items()}}
        if max(errors(mine, b)) > SAME:
            return f"{max(errors(mine, b)):.1e} apart in {a['increment']}"
    return "same"


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
    parser.add_argument("--kinds", choices=("first", "more"), default="first", help="table of kinds")
    parser.add_argument("--only", help="kind of the second table, `bricks` too, which is drawn only by name")
    parser.add_argument("--near", type=float, default=1e-5, help="largest relative difference that agrees")
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
