#!/usr/bin/env python3
"""Random scenes of friction: tool, coefficient up to 1.5, path. usage:
    friction_family.py --seed S --first A --count N --out DIR --binary PATH [--limit SECONDS] [--options "--set ..."]

Boxes of linear or rubber cells, held below, beside or nowhere but by the floor, under a half-space, a sphere or a
cylinder that presses, drags, turns, comes back and lifts off. A scene is `converged`, or stops with a cause; then its
steps are cut four times as fine, and it is `confirmed` where that stops in the same place (within a coarse increment)
too, `cured` where that goes through. It prints a line a scene and what all took: applications an increment, steps of
Newton's method a program, shares of cut-backs. The balance checked: dissipation is nowhere negative.
"""
import argparse
import json
import subprocess
import time
from pathlib import Path

import numpy as np

from family_mesh import Box

MATERIALS = (
    'model = "linear-elastic"\nshear_modulus = 1.0\npoisson_ratio = 0.5',
    'model = "linear-elastic"\nshear_modulus = 1.0\npoisson_ratio = 0.49',
    'model = "linear-elastic"\nshear_modulus = 1.0\npoisson_ratio = 0.3',
    'model = "neo-hookean"\nshear_modulus = 1.0',
    'model = "neo-hookean"\nshear_modulus = 1.0\nbulk_modulus = 1000.0',
    'model = "mooney-rivlin"\nc10 = 0.4\nc01 = 0.1\nbulk_modulus = 50.0',
)


def number(random, low, high):
    return round(float(random.uniform(low, high)), 4)


def vector(values):
    return "[" + ", ".join(f"{x:.6g}" for x in values) + "]"


def body(random, dim):
    most = 10 if dim == 2 else 4
    counts = [int(random.integers(3, most + 1)) for _ in range(dim)]
    sizes = [number(random, 0.8, 2.0), *([number(random, 0.8, 1.5)] if dim == 3 else []), 1.0]
    return Box(sizes, counts, float(random.choice([0.0, 0.15])), False, random)


def tool(random, box):
    """Shape and the depth it can be pressed by."""
    dim, top = box.dim, float(box.sizes[-1])
    middle = [number(random, 0.3, 0.7) * float(size) for size in box.sizes[:-1]]
    kind = random.choice(["half-space", "half-space", "sphere", "cylinder"] if dim == 3 else ["half-space", "cylinder"])
    if kind == "half-space":
        angle = float(random.choice([0.0, 0.0, number(random, -0.1, 0.1)]))
        normal = [np.sin(angle), *([0.0] if dim == 3 else []), -np.cos(angle)]
        point = [*(0.5 * box.sizes[:-1]), top + abs(np.tan(angle)) * 0.5 * float(box.sizes[0])]
        shape = f'kind = "half-space", point = {vector(padded(point))}, normal = {vector(padded(normal))}'
        return shape, number(random, 0.02, 0.1)
    radius = number(random, 0.4, 1.5)
    centre = vector(padded([*middle, top + radius]))
    if kind == "sphere":
        return f'kind = "sphere", centre = {centre}, radius = {radius}', number(random, 0.02, 0.1)
    axis = [0.0, 0.0, 1.0] if dim == 2 else [0.0, 1.0, 0.0]
    return f'kind = "cylinder", point = {centre}, axis = {vector(axis)}, radius = {radius}', number(random, 0.02, 0.1)


def padded(values):
    return [*values, *[0.0] * (3 - len(values))]


def steps(random, dim, depth):
    """Press, then two to four moves: (increments, translation, rotation)."""
    up = dim - 1
    at = np.zeros(3)
    at[up] = -depth
    found = [(int(random.choice([1, 2, 4])), at.copy(), np.zeros(3))]
    turn = np.zeros(3)
    for _ in range(int(random.integers(2, 5))):
        move = random.choice(["drag", "drag", "back", "turn", "press", "lift"])
        if move == "drag":
            direction = random.normal(size=dim - 1)
            at[: dim - 1] += float(random.uniform(0.01, 0.15)) * direction / np.linalg.norm(direction)
        elif move == "back":
            at[: dim - 1] *= float(random.uniform(-0.5, 0.5))
        elif move == "turn":
            turn[2 if dim == 2 else 2] += float(random.uniform(-0.15, 0.15)) * (0.3 if dim == 2 else 1.0)
        elif move == "press":
            at[up] = -depth * float(random.uniform(0.4, 1.3))
        else:
            at[up] = float(random.choice([-0.2 * depth, 0.05]))
        found.append((int(random.choice([1, 2, 4, 8])), at.copy(), turn.copy()))
    return found


def scene(seed, index):
    """The mesh of a number in the family of a seed, and its TOML text by increments' factor."""
    random = np.random.default_rng([seed, index])
    dim = 2 if random.random() < 0.5 else 3
    box = body(random, dim)
    up = "xyz"[dim - 1]
    shape, depth = tool(random, box)
    friction = number(random, 0.0, 1.5)
    held = random.choice(["bonded", "bonded", "bonded", "side", "floor"])
    parts = [f"[material.body]\n{random.choice(MATERIALS)}\n"]
    components = ", ".join(f"{a} = 0.0" for a in "xyz"[:dim])
    on = {"bonded": f"{up}0", "side": "x0", "floor": "x0"}[held]
    parts.append(f'[[support]]\nname = "held"\non = "{on}"\ndisplacement = {{ {components} }}\n')
    if held == "floor":
        normal = padded([*[0.0] * (dim - 1), 1.0])
        shape_of_floor = f'kind = "half-space", point = [0.0, 0.0, 0.0], normal = {vector(normal)}'
        rough = number(random, 0.0, 1.0)
        parts.append(f'[[obstacle]]\nname = "floor"\non = "{up}0"\nshape = {{ {shape_of_floor} }}\nfriction = {rough}\n')
    parts.append(f'[[obstacle]]\nname = "tool"\non = "{up}1"\nshape = {{ {shape} }}\nfriction = {friction}\n')
    moves = steps(random, dim, depth)

    def text(mesh, factor):
        rows = [
            f"[[step]]\nincrements = {n * factor}\n"
            f"obstacle.tool = {{ translation = {vector(t)}, rotation = {vector(r)} }}\n"
            for n, t, r in moves
        ]
        return "\n".join([f'mesh = "{mesh}"\n', *parts, *rows])

    return box, text, moves


def solve(given, file):
    command = [given.binary, "solve", str(file), "--json", *given.options.split()]
    began = time.perf_counter()
    try:
        output = subprocess.run(command, capture_output=True, text=True, timeout=given.limit).stdout
    except subprocess.TimeoutExpired as late:
        output = (late.stdout or b"").decode()
    lines = [json.loads(line) for line in output.splitlines() if line.startswith("{") and line.endswith("}")]
    return [e for e in lines if e.get("event") == "step"], time.perf_counter() - began


def reached(increments, moves, factor):
    """Time to which a run has come, and a coarse increment of the step in which it stopped."""
    last = increments[-1]
    return last["time"], 1.0 / moves[last["step"] - 1][0]


def judge(given, index):
    box, text, moves = scene(given.seed, index)
    stem = Path(given.out) / f"{given.seed}-{index:04d}"
    mesh = stem.with_suffix(".msh")
    box.write(mesh)
    file = stem.with_suffix(".toml")
    file.write_text(text(mesh.name, 1))
    found, seconds = solve(given, file)
    row = {"index": index, "increments": len(found), "seconds": round(seconds, 2)}
    if not found:
        return {**row, "verdict": "silent"}, found
    last = found[-1]
    worst = min(o["dissipated_energy"] for e in found for o in e["obstacles"].values())
    row["least_dissipation"] = worst
    if last["termination"] == "converged":
        return {**row, "verdict": "converged"}, found
    fine = stem.with_name(stem.name + "-fine").with_suffix(".toml")
    fine.write_text(text(mesh.name, 4))
    again, _ = solve(given, fine)
    time_coarse, width = reached(found, moves, 1)
    verdict = "silent"
    if again:
        time_fine, _ = reached(again, moves, 4)
        same = abs(time_fine - time_coarse) <= width + 1e-9
        verdict = "cured" if again[-1]["termination"] == "converged" else "confirmed" if same else "elsewhere"
        row["fine"] = (time_fine, again[-1]["cause"])
    return {**row, "verdict": verdict, "time": time_coarse, "cause": last["cause"]}, found


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--count", type=int, default=200)
    parser.add_argument("--out", required=True)
    parser.add_argument("--binary", required=True)
    parser.add_argument("--options", default="")
    parser.add_argument("--limit", type=float, default=60.0)
    given = parser.parse_args()
    Path(given.out).mkdir(parents=True, exist_ok=True)
    verdicts, all_found = {}, []
    for index in range(given.first, given.first + given.count):
        row, found = judge(given, index)
        verdicts[row["verdict"]] = verdicts.get(row["verdict"], 0) + 1
        all_found += found
        row["applications"] = sum(e["preconditioner_applications"] for e in found)
        print(json.dumps(row), flush=True)
    total(verdicts, all_found)


def total(verdicts, found):
    applications = [e["preconditioner_applications"] for e in found]
    programs = sum(e["sqp_iterations"] for e in found)
    newton = sum(e["newton_steps"] for e in found)
    by_parts = sum(e["cut_backs"] > 0 for e in found)
    print(verdicts)
    print(f"{len(found)} increments, {np.mean(applications):.0f} applications each (median {np.median(applications):.0f}, ")
    print(f"most {max(applications)}), {newton / max(programs, 1):.2f} steps of Newton a program, ")
    print(f"{by_parts} increments by cut-backs, {sum(e['seconds']['total'] for e in found):.1f} s")


if __name__ == "__main__":
    main()
