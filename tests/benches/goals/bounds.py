#!/usr/bin/env python3
"""Bounds of forces, reactions and displacements against finer meshes, on random scenes.

Bodies in the plane, about an axis and in space, linear and of rubber, pulled or pressed by smooth and edged tools. Each
scene is solved on a coarse mesh and on refinements of it, all edges halved; the finest one, extrapolated where the
values settle, tells the true errors of those before it. With `--adapted` the mesh is refined for the goal to a
fiftieth of the first bound in the place of that, and the last mesh tells those of the meshes before it. With `--rough`
tools have friction and move sideways, too, in one increment; scenes without a tool are left out. With `--wet` a fluid
comes from the left side to the tool; scenes that are not bonded to their base, or leak, are left out.

usage: bounds.py [COUNT [SEED]] [--adapted | --rough | --wet] [--save FILE]
SIGNORINI names the program, PATIENCE the seconds of one solution. Needs `pip install gmsh`.
"""
import argparse
import json
import math
import os
import random
import statistics
import subprocess
import tempfile
from pathlib import Path

import gmsh

PROGRAM = os.environ.get("SIGNORINI", "signorini")
# How often edges are halved for the reference, by dimension.
LEVELS = {2: 3, 3: 2}
# A value counts as settled where its last change is at most this part of the one before.
SETTLES = 0.7
# First bound over the one that adapted meshes end with, and their most unknowns.
PART, MOST_UNKNOWNS = 50, 60000
# Adapted meshes count whose error is above this many times that of the last one.
ABOVE = 4.0
# Values whose error is below this part of them are exact on every mesh.
EXACT = 1e-7
# Seconds of one solution, beyond which the scene is left: more where other work shares the machine.
PATIENCE = float(os.environ.get("PATIENCE", 20.0))


def plane_mesh(path, outline, size):
    """A closed outline of (x, y, group) points, each with the group of the line that follows it."""
    geo = gmsh.model.geo
    ends = [geo.addPoint(x, y, 0, size) for x, y, _ in outline]
    lines = [geo.addLine(a, b) for a, b in zip(ends, ends[1:] + ends[:1])]
    surface = geo.addPlaneSurface([geo.addCurveLoop(lines)])
    geo.synchronize()
    gmsh.model.addPhysicalGroup(2, [surface], name="body")
    for name in sorted({group for *_, group in outline}):
        own = [line for line, (*_, group) in zip(lines, outline) if group == name]
        gmsh.model.addPhysicalGroup(1, own, name=name)
    gmsh.model.mesh.generate(2)
    gmsh.write(str(path))


def space_mesh(path, sizes, size):
    """A box from the origin."""
    occ = gmsh.model.occ
    occ.addBox(0, 0, 0, *sizes)
    occ.synchronize()
    gmsh.model.addPhysicalGroup(3, [1], name="body")
    for name, tag in {"left": 1, "right": 2, "front": 3, "back": 4, "base": 5, "top": 6}.items():
        gmsh.model.addPhysicalGroup(2, [tag], name=name)
    gmsh.option.setNumber("Mesh.MeshSizeMin", size)
    gmsh.option.setNumber("Mesh.MeshSizeMax", size)
    gmsh.model.mesh.generate(3)
    gmsh.write(str(path))


def meshed(make, *given):
    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.option.setNumber("Mesh.MshFileVersion", 2.2)
    make(*given)
    gmsh.finalize()


def body(rng, folder, kind):
    """A box, a panel, or a step of two heights: its width and height, and its inner radius."""
    width, height = rng.uniform(1.0, 2.0), rng.uniform(0.5, 1.2)
    inner = rng.choice([0.0, rng.uniform(1.0, 3.0)]) if kind == "axisymmetric" else 0.0
    if kind == "space":
        sizes = [width, rng.uniform(1.0, 1.5), height]
        meshed(space_mesh, folder / "mesh.msh", sizes, rng.uniform(0.5, 0.6))
        return width, height, inner, sizes[1]
    lean = rng.choice([0.0, rng.uniform(-0.2, 0.2)]) if inner > 0.0 or kind == "plane-strain" else 0.0
    right = inner + width
    outline = [(inner, 0.0, "base"), (right, 0.0, "right"), (right + lean, height, "top"), (inner + lean, height, "left")]
    meshed(plane_mesh, folder / "mesh.msh", outline, rng.uniform(0.12, 0.25))
    return width, height, inner, lean


def material(rng):
    """A law with its name, and whether it is rubber."""
    if rng.random() < 0.5:
        ratio = rng.choice([0.3, 0.4, 0.45, 0.49, 0.499, 0.5])
        return f'model = "linear-elastic"\nshear_modulus = 1.0\npoisson_ratio = {ratio}\n', f"linear {ratio}", False
    bulk = rng.choice([None, 10.0, 100.0, 2000.0])
    name, text = rng.choice([("neo-hookean", "shear_modulus = 1.0\n"), ("mooney-rivlin", "c10 = 0.4\nc01 = 0.1\n")])
    text = f'model = "{name}"\n{text}' + (f"bulk_modulus = {bulk}\n" if bulk else "")
    return text, f"{name} {bulk or 'inf'}", True


def tool(rng, kind, height, across):
    """The name of a tool that touches the top, and its shape by the width and the inner radius of the body."""
    lift = lambda x, above: f"[{x}, {across / 2}, {height + above}]" if kind == "space" else f"[{x}, {height + above}, 0.0]"
    down = "[0.0, 0.0, -1.0]" if kind == "space" else "[0.0, -1.0, 0.0]"
    name = rng.choice(["ball", "ball", "punch", "rounded", "plate"])
    radius = rng.uniform(0.5, 2.0)
    at = lambda width, inner: (0.0 if kind == "axisymmetric" and inner == 0.0 else inner + width * rng.uniform(0.4, 0.6))

    def shape(width, inner):
        x = at(width, inner)
        if name == "plate":
            return f'kind = "half-space", point = {lift(x, 0)}, normal = {down}'
        if name == "ball" and kind == "axisymmetric" and inner > 0.0:
            return f'kind = "torus", centre = {lift(0, radius)}, axis = [0.0, 1.0, 0.0], radius = {x}, tube_radius = {radius}'
        if name == "ball":
            return f'kind = "sphere", centre = {lift(x, radius)}, radius = {radius}'
        half, rounding = width * rng.uniform(0.15, 0.25), 0.0 if name == "punch" else 0.08
        if kind == "axisymmetric":
            ends = f"from = [0.0, {height}, 0.0], to = [0.0, {height + 1}, 0.0]"
            return f'kind = "capped-cylinder", {ends}, radius = {inner + 2 * half}, rounding = {rounding}'
        sizes = f"[{half}, {half}, 0.5]" if kind == "space" else f"[{half}, 0.5, 1.0]"
        return f'kind = "box", centre = {lift(x, 0.5)}, half_sizes = {sizes}, rounding = {rounding}'

    return name, shape


def scene(rng, folder):
    """Text, goal and name of a random scene."""
    kind = rng.choice(["plane-strain", "axisymmetric", "space"])
    width, height, inner, across = body(rng, folder, kind)
    law, law_name, is_rubber = material(rng)
    text = 'mesh = "mesh.msh"\n' + (f'kind = "{kind}"\n' if kind != "space" else "") + f"[material.body]\n{law}"
    held = {"space": "x = 0.0, y = 0.0, z = 0.0"}.get(kind, "x = 0.0, y = 0.0")
    up = "z" if kind == "space" else "y"
    is_bonded = rng.random() < 0.7
    bed = f"displacement = {{ {held} }}" if is_bonded else f"displacement = {{ {up} = 0.0 }}"
    name, shape = tool(rng, kind, height, across)
    is_pulled = rng.random() < 0.25
    if kind == "axisymmetric" and inner == 0.0:
        text += '[[support]]\nname = "axis"\non = "left"\ndisplacement = { x = 0.0 }\n'
    elif not is_bonded:
        others = ["left", "front"] if kind == "space" else ["left"]
        for group in others if kind != "axisymmetric" else []:
            text += f'[[support]]\nname = "{group}"\non = "{group}"\nnormal = 0.0\n'
    text += f'[[support]]\nname = "base"\non = "base"\n{bed}\n'
    increments = rng.choice([2, 3]) if is_rubber else 1
    if is_pulled:
        size = rng.uniform(0.1, 0.3) if is_rubber else 0.01
        load = [0.0, size, 0.0] if kind == "axisymmetric" else [size, 0.3 * size, 0.0]
        text += f'[[traction]]\non = "top"\nvalue = {load}\n[[step]]\nincrements = {increments}\n'
        middle = inner + width / 2
        point = f"[{middle}, {across / 2}, {height}]" if kind == "space" else f"[{middle + across}, {height}, 0.0]"
        text += f'[[probe]]\nname = "top"\npoint = {point}\n'
        side = "y" if kind == "axisymmetric" else "x"
        goal = rng.choice([f"displacement.top.{side}", f"reaction.base.{side}"] if is_bonded else [f"displacement.top.{side}"])
        return text, goal, f"{kind} {law_name} pulled {'bonded' if is_bonded else 'sliding'}"
    text += f'[[obstacle]]\nname = "tool"\non = "top"\nshape = {{ {shape(width, inner)} }}\n'
    depth = height * (rng.uniform(0.05, 0.2) if is_rubber else rng.uniform(0.01, 0.05))
    along = f"[0.0, 0.0, {-depth}]" if kind == "space" else f"[0.0, {-depth}, 0.0]"
    text += f"[[step]]\nincrements = {increments}\nobstacle.tool = {{ translation = {along} }}\n"
    goal = rng.choice([f"force.tool.{up}"] * 3 + [f"reaction.base.{up}"])
    return text, goal, f"{kind} {law_name} {name} {'bonded' if is_bonded else 'sliding'}"


def rough(rng, text):
    """The scene with friction and a way to the side."""
    if "[[obstacle]]" not in text:
        raise RuntimeError("no tool")
    text = text.replace('name = "tool"\n', f'name = "tool"\nfriction = {rng.uniform(0.1, 0.6)}\n')
    text = text.replace("increments = 2", "increments = 1").replace("increments = 3", "increments = 1")
    if 'kind = "axisymmetric"' in text:
        return text
    return text.replace("translation = [0.0", f"translation = [{rng.uniform(0.005, 0.03)}")


def wet(rng, text):
    """The scene with a fluid at the left side of the body."""
    if "[[obstacle]]" not in text or "kind" not in text.split("[material")[0]:
        raise RuntimeError("no tool, or in space")
    if 'on = "left"' in text:
        raise RuntimeError("the left side is held")
    pressure = rng.uniform(0.01, 0.1)
    return text.replace("[[step]]", f'''[[fluid]]
name = "water"
on = ["left", "top"]
from = "left"
dry = "right"
pressure = {pressure}
[[step]]''', 1)


def write(folder, text):
    (folder / "scene.toml").write_text('name = "bound"\n' + text)


def run(folder, text):
    """Lines of a solution and the last increment, or why there is none."""
    write(folder, text)
    done = subprocess.run([PROGRAM, "solve", "scene.toml", "--json"], cwd=folder, capture_output=True, text=True,
                          timeout=PATIENCE)
    lines = [json.loads(line) for line in done.stdout.splitlines()]
    steps = [line for line in lines if line["event"] == "step"]
    if not steps or steps[-1]["termination"] != "converged":
        raise RuntimeError(steps[-1]["termination"] if steps else done.stderr[-300:])
    if any(fluid["tightness"] != "tight" for fluid in steps[-1].get("fluids", {}).values()):
        raise RuntimeError("the fluid leaks")
    return lines, steps[-1]


def bounded(folder, text, goal):
    """The same with the bound of the goal."""
    lines, step = run(folder, text + f'[accuracy]\nbound = ["{goal}"]\n')
    if goal not in step.get("goals", {}):
        raise RuntimeError(step.get("goals_refused", "no goal"))
    return lines, step, step["goals"][goal]["bound"]


def value(step, goal):
    what, name, axis = goal.split(".")
    group, kind = {"force": ("obstacles", "force"), "reaction": ("supports", "force"),
                   "displacement": ("probes", "displacement")}[what]
    return step[group][name][kind]["xyz".index(axis)]


def settled(values):
    """The last value, extrapolated where the values settle."""
    before, change = values[-2] - values[-3], values[-1] - values[-2]
    ratio = change / before if before else 1.0
    return values[-1] + change * ratio / (1 - ratio) if 0.0 < ratio < SETTLES else values[-1]


def uniform(folder, text, goal):
    """Value, estimate and bound of each mesh but the last two, and the reference."""
    levels = LEVELS[2 if "kind" in text.split("[material")[0] else 3]
    values, bounds = [], []
    for level in range(levels + 1):
        write(folder, text)
        if level:
            made = ["refine", "scene.toml", "-o", f"fine{level}.msh", "--levels", str(level)]
            subprocess.run([PROGRAM, *made], cwd=folder, check=True, capture_output=True)
        own = text.replace("mesh.msh", f"fine{level}.msh") if level else text
        if level < levels - 1:
            _, step, bound = bounded(folder, own, goal)
            bounds.append(bound)
        else:
            _, step = run(folder, own)
        values.append(value(step, goal))
    meshes = zip(values, bounds)
    return [(found, own["estimate"], own["total"] - own["geometry"]) for found, own in meshes], settled(values)


def adapted(folder, text, goal):
    """Value, estimate and bound of each mesh but the first and the last ones, and the reference."""
    _, step, bound = bounded(folder, text, goal)
    if not value(step, goal):
        raise RuntimeError("the goal is zero")
    aim = max(bound["total"] / abs(value(step, goal)) / PART, 1e-5)
    lines, _ = run(folder, text + f"[accuracy]\n{goal} = {aim}\nmax_unknowns = {MOST_UNKNOWNS}\n")
    rounds = [line["goals"][goal] for line in lines if line["event"] == "round"]
    last = rounds[-1]
    inside = [one for one in rounds[1:-1] if one["bound"] > ABOVE * last["bound"]]
    return [(one["value"], one["estimate"], one["bound"] - one["geometry"]) for one in inside], last["value"]


def main():
    asked = argparse.ArgumentParser()
    asked.add_argument("count", nargs="?", type=int, default=60)
    asked.add_argument("seed", nargs="?", type=int, default=1)
    kinds = asked.add_mutually_exclusive_group()
    kinds.add_argument("--adapted", action="store_true")
    kinds.add_argument("--rough", action="store_true")
    kinds.add_argument("--wet", action="store_true")
    asked.add_argument("--save")
    asked = asked.parse_args()
    ratios, estimates, failed = [], [], 0
    for number in range(asked.count):
        rng = random.Random(f"{asked.seed}-{number}")
        with tempfile.TemporaryDirectory() as folder:
            folder = Path(folder)
            text, goal, name = scene(rng, folder)
            try:
                text = rough(rng, text) if asked.rough else wet(rng, text) if asked.wet else text
                meshes, reference = (adapted if asked.adapted else uniform)(folder, text, goal)
            except (RuntimeError, subprocess.SubprocessError) as error:
                failed += 1
                print(f"{number:4} {name:44} {goal:22} no solution: {str(error)[:120]}", flush=True)
                continue
        for found, estimate, bound in meshes:
            error = reference - found
            if abs(error) < EXACT * abs(reference):
                continue
            ratios.append(bound / abs(error))
            estimates.append(estimate / error)
            print(f"{number:4} {name:44} {goal:22} error {error / reference:9.2e} bound {ratios[-1]:8.2f} "
                  f"estimate {estimates[-1]:8.2f}", flush=True)
    share = sum(ratio >= 1.0 for ratio in ratios) / len(ratios)
    near = sum(0.7 <= estimate <= 1.4 for estimate in estimates) / len(estimates)
    print(f"{len(ratios)} meshes, {failed} scenes without solution: bound above the error {share:.3f}, "
          f"median ratio {statistics.median(ratios):.2f}; estimate within 0.7 to 1.4: {near:.3f}, "
          f"median {statistics.median(estimates):.2f}")
    if asked.save:
        Path(asked.save).write_text(json.dumps({"bound": ratios, "estimate": estimates}))


if __name__ == "__main__":
    main()
