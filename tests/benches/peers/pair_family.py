#!/usr/bin/env python3
"""Random pairs of soft bodies against Signorini. usage: pair_family.py --seed S --count N --out DIR --binary PATH
[--first K] [--only KIND] [--rough] [--check] [--near 1e-6] [--limit SECONDS]

Writes scene and mesh files, solves each with `pair_contact` and by `PATH solve SCENE --json`, and compares every
increment: forces and moments of contacts over what presses, strain energy, what friction has dissipated over that,
largest pressures, displacements of probes over the largest of them. Verdicts: agree; tolerance (agrees at 1e-14, or
ends at 1e-11 and agrees at 1e-8: moduli far apart); undecided (states agree, and pressures and tractions that exert
nothing on what is free may be added to those of either); both (they differ, and Signorini's states leave less than
--near in the equations here: several equilibria, or rounding of moduli far apart); disagree; failed (this code has an
equilibrium, Signorini none); verified (this code has none within its time, Signorini's states leave less than --near in
its equations: `pair_check`, which needs meshio); peer-failed; both-failed; ended (Signorini, with --check). `covered`:
the least share of a pressing function that has a partner. Prints one line a scene that does not agree and a table by
kinds; writes family.csv and the records of both, SCENE.peer.json and SCENE.own.json.
"""
import argparse
import csv
import json
import os
import shutil
import subprocess
import time
from collections import Counter, defaultdict
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("MKL_NUM_THREADS", "1")

import numpy as np

import pair_check
import pair_contact
import pair_draw
from pair_bodies import write
from pair_scene import PairProblem

# What states at a tolerance of 1e-8 may leave.
LOOSE = 1e-4
# Difference up to which a sharper tolerance is tried.
SHARPER = 1e-3
WHAT = ("force", "moment", "energy", "pressure", "probe", "dissipated")
# What displacements and pressures of the bodies tell.
STATE = ("energy", "probe", "dissipated")

# Least scales, for bodies that do not meet: the softest one has a shear modulus of 1e-6 at least. That of energies is
# times the stiffest modulus: rounding of its part.
FLOORS = {"force": 1e-9, "moment": 1.0, "energy": 1e-9, "pressure": 1e-9, "probe": 1e-4, "dissipated": 1.0}


def make(given, index):
    """Writes one scene; gives its path and draft."""
    draft, text = pair_draw.scene(given.seed, index, given.only, given.rough)
    scene = Path(given.out) / f"{given.seed}-{index:04d}-{draft.kind}.toml"
    write(scene.with_suffix(".msh"), draft.bodies, draft.curved)
    scene.write_text(text.replace("MESH", scene.with_suffix(".msh").name))
    return scene, draft


def peer(scene, given):
    """This code's increments."""
    try:
        with np.errstate(all="ignore"):
            found = list(pair_contact.solve(PairProblem(scene), limit=given.limit))
    except Exception as fault:  # A scene that this solver cannot take is a verdict, not an end.
        cause = f"{type(fault).__name__}: {fault}"
        found = [{"step": 1, "increment": 1, "converged": False, "cause": cause}]
    scene.with_suffix(".peer.json").write_text("\n".join(map(json.dumps, found)))
    return found


def signorini(scene, given, *more):
    """Increments of the binary."""
    folder = scene.with_suffix(".out")
    shutil.rmtree(folder, ignore_errors=True)
    command = [given.binary, "solve", str(scene), "--json", "--out", str(folder), *more]
    try:
        run = subprocess.run(command, capture_output=True, text=True, timeout=given.limit)
        scene.with_suffix(".err").write_text(run.stderr)
        output = run.stdout
    except subprocess.TimeoutExpired as late:
        output = (late.stdout or b"").decode()
    scene.with_suffix(".own.json").write_text(output)
    events = [json.loads(line) for line in output.splitlines() if line.startswith("{") and line.endswith("}")]
    return [event for event in events if event.get("event") == "step"]


def differences(mine, theirs, scales, axes):
    """Relative differences by WHAT, forces along `axes`; the largest values so far are the scales."""
    found = dict.fromkeys(WHAT, 0.0)
    for name, own in mine["contacts"].items():
        other = theirs["contacts"][name]
        scales["force"] = max(scales["force"], own["pressing"])
        scales["pressure"] = max(scales["pressure"], own["peak_pressure"])
        apart = np.abs(np.array(other["force"][:2]) - own["force"])[axes].max()
        found["force"] = max(found["force"], apart)
        if len(axes) > 1:
            found["moment"] = max(found["moment"], abs(other["moment"][2] - own["moment"]))
        found["pressure"] = max(found["pressure"], abs(other["peak_pressure"] - own["peak_pressure"]))
        lost = (other.get("friction") or {}).get("dissipated_energy", 0.0)
        found["dissipated"] = max(found["dissipated"], abs(lost - (own["dissipated"] or 0.0)))
    scales["energy"] = max(scales["energy"], abs(mine["strain_energy"]))
    found["energy"] = abs(theirs["strain_energy"] - mine["strain_energy"])
    for name, own in mine["probes"].items():
        scales["probe"] = max(scales["probe"], np.abs(own).max())
        apart = np.abs(np.array(theirs["probes"][name]["displacement"][:2]) - own).max()
        found["probe"] = max(found["probe"], apart)
    for name, own in mine["obstacles"].items():
        apart = np.abs(np.array(theirs["obstacles"][name]["force"]) - own).max()
        found["force"] = max(found["force"], apart)
        scales["force"] = max(scales["force"], np.abs(own).max())
    # Bodies are about one wide.
    scales["dissipated"], scales["moment"] = scales["energy"], scales["force"]
    return {what: value / scales[what] for what, value in found.items()}


def judge(mine, theirs, given, draft, what=WHAT):
    """The verdict of a scene by `what`, the largest differences, and where it is decided."""
    if not mine:
        failed = not theirs or any(step["termination"] != "converged" for step in theirs)
        cause = str(theirs[-1].get("cause")) if theirs else "no result"
        return ("ended" if failed else "skipped"), dict.fromkeys(WHAT, 0.0), cause if failed else ""
    worst, scales, near = dict.fromkeys(WHAT, 0.0), FLOORS | {}, given.near
    scales["energy"] *= max(draft.shears.values())
    for number, own in enumerate(mine):
        other = theirs[number] if number < len(theirs) else None
        failed = other is None or other["termination"] != "converged"
        where = f"{own['step']}.{own['increment']}"
        if not own["converged"]:
            return "both-failed" if failed else "peer-failed", worst, f"{where} {own['cause']}"
        if failed:
            return "failed", worst, f"{where} {other and other.get('cause')}"
        apart = differences(own, other, scales, [1] if draft.revolved else [0, 1])
        worst = {name: max(worst[name], apart[name]) for name in WHAT}
        if max(worst[name] for name in what) > near:
            return "disagree", worst, f"{where} {own_path(theirs[: number + 1])}"
    return "agree", worst, ""


def compare(scene, mine, given, draft):
    """The verdict, with Signorini's states put into the equations here where theirs and ours differ."""
    verdict, *rest = by_tolerance(scene, mine, given, draft)
    if verdict == "disagree" and max(checked(scene).values(), default=np.inf) <= given.near:
        verdict = "both"
    return verdict, *rest


def by_tolerance(scene, mine, given, draft):
    """The verdict, with another tolerance where that may be the cause."""
    theirs = signorini(scene, given)
    first = judge(mine, theirs, given, draft)
    if first[0] in ("peer-failed", "skipped"):
        left = checked(scene)
        largest = max(left.values(), default=np.inf)
        if largest <= given.near:
            return "verified", first[1], f"{largest:.1e}"
        first = first[0], first[1], f"{first[2]} {left}"
        if largest > SHARPER:
            return first
        other = "1e-14"
    elif first[0] == "disagree" and (same := undecided(scene, mine, theirs, (given, draft))):
        return same
    elif first[0] == "disagree" and max(first[1].values()) < SHARPER:
        other = "1e-14"
    elif first[0] in ("failed", "ended"):
        other = "1e-8"
    else:
        return first
    again = judge(mine, signorini(scene, given, "--set", f"solver.tolerance={other}"), given, draft)
    is_checked = again[0] in ("skipped", "peer-failed")
    limit = LOOSE if first[0] == "ended" else given.near
    is_right = again[0] == "agree" or (is_checked and max(checked(scene).values(), default=1.0) <= limit)
    return ("tolerance", again[1], f"{first[2]} at {other}") if is_right else first


def checked(scene):
    """The most that the equations leave of the binary's states."""
    worst = left_by(scene)
    worst.pop(pair_check.UNDECIDED, None)
    return worst


def undecided(scene, mine, theirs, drawn):
    """That verdict, where states agree that do not say how much each multiplier bears."""
    same = judge(mine, theirs, *drawn, STATE)
    is_open = same[0] == "agree" and left_by(scene).get(pair_check.UNDECIDED, 0.0) > 0.0
    return ("undecided", *same[1:]) if is_open else None


def left_by(scene):
    with np.errstate(all="ignore"):
        found = list(pair_check.rests(PairProblem(scene), pair_check.states(scene.with_suffix(".out"))))
    worst = {}
    for what, value in (entry for left in found for entry in left.items()):
        worst[what] = max(worst.get(what, 0.0), float(value))
    return worst


def covered(mine):
    """The least share with a partner of functions that press."""
    return [contact["least_covered"] for step in mine if step["converged"] for contact in step["contacts"].values()]


def own_path(theirs):
    """Whether Signorini has cut increments: with friction that is another path."""
    cuts = sum(step.get("cut_backs", 0) for step in theirs)
    return f"cut-backs {cuts}" if cuts else ""


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--count", type=int, default=100)
    parser.add_argument("--out", required=True)
    parser.add_argument("--binary", required=True)
    parser.add_argument("--only", choices=[*pair_draw.KINDS, *pair_draw.APART])
    parser.add_argument("--rough", action="store_true", help="Coulomb's or Tresca's friction in every contact")
    parser.add_argument("--check", action="store_true", help="put its states into the equations, solve nothing")
    parser.add_argument("--near", type=float, default=1e-6)
    parser.add_argument("--limit", type=float, default=60.0)
    given = parser.parse_args()
    Path(given.out).mkdir(parents=True, exist_ok=True)
    rows = []
    for index in range(given.first, given.first + given.count):
        scene, draft = make(given, index)
        began = time.perf_counter()
        mine = [] if given.check else peer(scene, given)
        seconds = round(time.perf_counter() - began, 2)
        verdict, worst, where = compare(scene, mine, given, draft)
        row = {"scene": scene.stem, "kind": draft.kind, "rubber": draft.rubber, "curved": draft.curved}
        row |= {"verdict": verdict, "where": where}
        row["covered"] = round(min([1.0, *covered(mine)]), 4)
        rows.append(row | {what: f"{value:.1e}" for what, value in worst.items()} | {"seconds": seconds})
        shutil.rmtree(scene.with_suffix(".out"), ignore_errors=True)
        # After every scene: a run may be ended before its last one.
        keep(given, rows)
        if verdict not in ("agree", "verified", "undecided"):
            print(*rows[-1].values(), flush=True)
    report(rows)


def keep(given, rows):
    with open(Path(given.out) / "family.csv", "w", newline="") as file:
        writer = csv.DictWriter(file, rows[0])
        writer.writeheader()
        writer.writerows(rows)


def report(rows):
    counts, worst = defaultdict(Counter), defaultdict(float)
    for row in rows:
        counts[row["kind"]][row["verdict"]] += 1
        if row["verdict"] == "agree":
            worst[row["kind"]] = max(worst[row["kind"]], *(float(row[what]) for what in WHAT))
    for kind, verdicts in counts.items():
        print(f"{kind:10} largest {worst[kind]:.1e}  " + ", ".join(f"{v} {n}" for v, n in verdicts.items()))


if __name__ == "__main__":
    main()
