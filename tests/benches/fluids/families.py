#!/usr/bin/env python3
"""Random grooves, lips and rings under a fluid: none may end without `tight`, `leaks` or a cause, and more
pressure never seals better.

Each case is solved three times: to blow-off; to nine tenths of the lower end of its bracket, which must be tight, and
down again, which must stay so; to eleven tenths of the upper end, which must leak or have no equilibrium. A case without a leak up to its
limit is solved once more, down to nothing.

usage: families.py [COUNT [SEED]]      SIGNORINI names the program. Needs `pip install gmsh`.
"""
import json
import math
import os
import random
import subprocess
import sys
import tempfile
from pathlib import Path

import gmsh

PROGRAM = os.environ.get("SIGNORINI", "signorini")
HEAD = """mesh = "mesh.msh"
kind = "{kind}"
[material.rubber]
model = "{law}"
{constants}
bulk_modulus = {bulk}
"""
PLATE = """[[obstacle]]
name = "{name}"
on = "skin"
friction = {friction}
shape = {{ kind = "half-space", point = [{x}, {y}, 0.0], normal = [{nx}, {ny}, 0.0] }}
"""
FLUID = """[[fluid]]
name = "water"
on = "skin"
from = "wet"
dry = "dry"
"""


def mesh(path, outline, groups, size):
    """A second-order mesh of a closed outline of (x, y, size factor) points joined by straight lines."""
    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    plane = gmsh.model.geo
    ends = [plane.addPoint(x, y, 0, size * factor) for x, y, factor in outline]
    lines = [plane.addLine(a, b) for a, b in zip(ends, ends[1:] + ends[:1])]
    surface = plane.addPlaneSurface([plane.addCurveLoop(lines)])
    plane.synchronize()
    gmsh.model.addPhysicalGroup(2, [surface], name="rubber")
    for name, members in groups.items():
        gmsh.model.addPhysicalGroup(1, [lines[k] for k in members], name=name)
    gmsh.model.mesh.generate(2)
    gmsh.write(str(path))
    gmsh.finalize()


def head(rng, kind, modulus):
    laws = [("neo-hookean", f"shear_modulus = {modulus}"),
            ("mooney-rivlin", f"c10 = {0.4 * modulus}\nc01 = {0.1 * modulus}")]
    law, constants = rng.choice(laws)
    return HEAD.format(kind=kind, law=law, constants=constants, bulk=modulus * rng.choice([50, 500, 2000]))


def section(rng, folder, inner, power):
    """A closed section |x/a|^power + |y/b|^power = 1 that the fluid meets from the left."""
    width, height, count = rng.uniform(0.8, 1.4), 1.0, 48
    angles = [2 * math.pi * (k + 0.5) / count for k in range(count)]
    bent = lambda v: math.copysign(abs(v) ** (2 / power), v)
    outline = [(inner + width * (1 + bent(math.cos(a))), height * bent(math.sin(a)), 1) for a in angles]
    left = [k for k in range(count) if math.cos(2 * math.pi * (k + 1) / count) < -0.6]
    right = [k for k in range(count) if math.cos(2 * math.pi * (k + 1) / count) > 0.6]
    mesh(folder / "mesh.msh", outline, {"wet": left, "dry": right, "skin": range(count)}, 0.2)
    return inner + 2 * width, height


def between_plates(rng, folder, walled):
    kind = rng.choice(["plane-strain", "axisymmetric"] if walled else ["axisymmetric"])
    inner = rng.uniform(3, 10) if kind == "axisymmetric" else 0.0
    right, height = section(rng, folder, inner, rng.uniform(2, 4))
    modulus, friction = rng.uniform(0.5, 5), rng.choice([0.1, 0.3])
    text = head(rng, kind, modulus)
    text += PLATE.format(name="floor", friction=friction, x=0, y=-height, nx=0, ny=1)
    text += PLATE.format(name="lid", friction=friction, x=0, y=height, nx=0, ny=-1)
    if walled:
        text += PLATE.format(name="wall", friction=friction, x=right + rng.uniform(0, 0.1), y=0, nx=-1, ny=0)
    squeeze = f"[[step]]\nincrements = 3\nobstacle.lid = {{ translation = [0.0, {-rng.uniform(0.1, 0.4)}, 0.0] }}\n"
    return text + FLUID + squeeze, modulus * rng.uniform(0.5, 1.5)


def groove(rng, folder):
    return between_plates(rng, folder, walled=True)


def ring(rng, folder):
    return between_plates(rng, folder, walled=False)


def lip(rng, folder):
    """A bar that leans on a shaft, x = 0 to the left of it, held at its root; the fluid comes from below."""
    kind = rng.choice(["plane-strain", "axisymmetric"])
    inner = rng.uniform(5, 15) if kind == "axisymmetric" else 0.0
    long, thick, lean = rng.uniform(2, 4), rng.uniform(0.6, 1.2), rng.uniform(0.4, 0.9)
    along, across = (-math.sin(lean), math.cos(lean)), (math.cos(lean), math.sin(lean))
    at = lambda s, t: (s * along[0] + t * across[0], s * along[1] + t * across[1])
    tip = [at(long + thick / 2 * math.sin(a), thick / 2 - thick / 2 * math.cos(a)) for a in
           (math.pi * k / 8 for k in range(9))]
    outline = [(*at(0, 0), 1.5), *((x, y, 0.4) for x, y in tip), (*at(0, thick), 1.5)]
    shift = inner - min(x for x, _, _ in outline)
    outline = [(x + shift, y, factor) for x, y, factor in outline]
    groups = {"wet": [0], "dry": [9], "skin": range(10), "root": [10]}
    mesh(folder / "mesh.msh", outline, groups, 0.25)
    modulus, friction = rng.uniform(0.5, 5), rng.choice([0.0, 0.2])
    text = head(rng, kind, modulus) + '[[support]]\non = "root"\ndisplacement = { x = 0.0, y = 0.0 }\n'
    text += PLATE.format(name="shaft", friction=friction, x=inner, y=0, nx=1, ny=0)
    travel = rng.uniform(0.1, 0.4) * thick
    squeeze = f"[[step]]\nincrements = 3\nobstacle.shaft = {{ translation = [{travel}, 0.0, 0.0] }}\n"
    return text + FLUID + squeeze, modulus


def solve(folder, text):
    """Results of all increments and the exit code."""
    (folder / "scene.toml").write_text('name = "family"\n' + text)
    run = subprocess.run([PROGRAM, "solve", "scene.toml", "--json"], cwd=folder, capture_output=True, text=True)
    lines = [json.loads(line) for line in run.stdout.splitlines()]
    steps = [line for line in lines if line["event"] == "step"]
    assert steps, run.stderr
    return steps, run.returncode


def to(pressure, increments=1):
    return f"[[step]]\nincrements = {increments}\nfluid.water = {{ pressure = {pressure} }}\n"


def outcome(steps, code):
    """What a run says of its fluid, or the cause that it gives."""
    last = steps[-1]
    told = last["fluids"]["water"]["tightness"]
    if code == 0 or told == "leaks":
        return told
    assert code == 3 and last["cause"], (code, last["termination"])
    return last["cause"]


def check(folder, made):
    """Solves one case; its outcome, and what is wrong."""
    text, most = made
    steps, code = solve(folder, text + f'[[step]]\nincrements = 2\nfluid.water = {{ pressure = "to blow-off", up_to = {most} }}\n')
    first, wrong = outcome(steps, code), []
    seconds = sum(step["seconds"]["total"] for step in steps)
    rounds = max(step["fluids"]["water"]["rounds"] for step in steps)
    wet = [step["fluids"]["water"]["wet_area"] for step in steps[3:] if step["termination"] == "converged"]
    if any(b < 0.9 * a for a, b in zip(wet, wet[1:])):
        wrong.append(f"the wet set shrinks: {wet}")
    last = steps[-1]["fluids"]["water"]
    if first == "leaks":
        low, high = last["blow_off_low"], last["blow_off_high"]
        below, code = solve(folder, text + to(0.9 * low) + to(0.0))
        if outcome(below, code) != "tight":
            wrong.append(f"below {low}: {outcome(below, code)}")
        above, code = solve(folder, text + to(1.1 * high))
        # What is pushed out has no equilibrium there.
        if outcome(above, code) not in ("leaks", "no_equilibrium"):
            wrong.append(f"above {high}: {outcome(above, code)}")
        return f"leaks {low:.4g} {high:.4g}", seconds, rounds, wrong
    if first == "tight":
        back, code = solve(folder, text + to(most, 2) + to(0.0))
        if outcome(back, code) != "tight":
            wrong.append(f"down again: {outcome(back, code)}")
    return first, seconds, rounds, wrong


def main():
    count, seed = (int(sys.argv[k]) if len(sys.argv) > k else default for k, default in ((1, 200), (2, 1)))
    tally, failed = {}, 0
    for case in range(count):
        rng = random.Random(1000 * seed + case)
        family = (groove, lip, ring)[case % 3]
        with tempfile.TemporaryDirectory() as name:
            told, seconds, rounds, wrong = check(Path(name), family(rng, Path(name)))
        kind = f"{family.__name__}: {told.split()[0]}"
        tally[kind] = tally.get(kind, 0) + 1
        failed += bool(wrong)
        print(f"{case:4} {family.__name__:7} {told:30} {seconds:7.2f} s {rounds:3} rounds {'; '.join(wrong)}", flush=True)
    for kind, number in sorted(tally.items()):
        print(f"{kind:40} {number}")
    print(f"{failed} of {count} contradict themselves")
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
