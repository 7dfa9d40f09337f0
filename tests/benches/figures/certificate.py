#!/usr/bin/env python3
"""Whether `stability` tells the truth: columns of 0.9 to 8 times their Euler load, clamped and bent, in 1 and 10 increments,
a shallow arch pushed through, random rubber scenes, against dense eigenvalues at the program's own displacements; and a
balloon against its closed form.

Displacements and pressures come from the VTU files; multipliers from the balance of forces. The least eigenvalue is that
of the tangent on the kernel of volume and pressed contact rows, over the largest stiffness of a node. Increments with a
volume penalty, which these matrices lack, are named and not judged; columns kept straight go without it. Needs: numpy scipy.
"""
import math

import numpy as np
import scipy.linalg as la
import scipy.spatial

import common
import family_scenes
import meshes
import vtu
from common import FOLDER, NEO, row, scene, solve, support
from saddle_newton import Solver
from saddle_scene import Problem

# Multipliers below this share of the largest do not hold; eigenvalues (over the largest stiffness) below that have no sign.
HOLDS, SIGN = 1e-6, 1e-8
# Largest unknowns for dense matrices.
MOST = 2000
FACTORS = (0.9, 1.2, 2.0, 3.0, 5.0, 8.0)


def drives(problem):
    drive = problem.start()
    for increments, end in problem.steps():
        start = drive
        for i in range(increments):
            drive = start.between(end, (i + 1) / increments)
            yield drive


def state(problem, path):
    """Displacements and pressures of a VTU file in the order of the nodes of `problem`."""
    read = vtu.read(path)
    mesh = problem.mesh
    at = scipy.spatial.cKDTree(read["Points"][:, : mesh.dim]).query(mesh.nodes)[1]
    u = read["displacement"][at, : mesh.dim].ravel()
    return u, read["pressure"][at[: len(mesh.points)]]


def least(solver, drive, u, p):
    """Least eigenvalue over the largest stiffness of a node, and the rest of the balance of forces over the largest force."""
    problem, free = solver.problem, solver.free
    obstacles, body = problem.placed(drive), solver.body.respond(u, p)
    rest = (body.forces - drive.load * problem.load)[free]
    scale, k = np.abs(body.forces).max(), body.stiffness.toarray()
    largest, held = k.diagonal().max(), body.divergence[:, free].toarray()
    if body.compressibility.diagonal().any():
        held, k = np.zeros((0, held.shape[1])), k + (body.divergence.T @ la.solve(body.compressibility.toarray(), body.divergence.toarray()))
    if obstacles:
        _, coupling, _ = solver.surface.contact(u, obstacles, np.zeros(solver.surface.multipliers))
        c = coupling[:, free].toarray()
        multipliers = la.lstsq(c.T, -rest)[0]
        multipliers[multipliers < HOLDS * np.abs(multipliers).max()] = 0.0
        rest = rest + c.T @ multipliers
        k = k + solver.surface.contact(u, obstacles, multipliers)[2].toarray()
        held = np.vstack([held, c[multipliers > 0]])
    kernel = la.null_space(held) if len(held) else np.eye(int(free.sum()))
    values = la.eigvalsh(kernel.T @ k[np.ix_(free, free)] @ kernel, subset_by_index=[0, 0])
    return values[0] / largest, np.abs(rest).max() / max(scale, 1e-300)


def verdicts(file, run, out):
    """(what is said, least eigenvalue, snapped) of each converged increment."""
    problem = Problem(file)
    solver = Solver(problem)
    found = []
    for step, path, drive in zip(run.steps, sorted(out.glob(f"{file.stem}_[0-9]*.vtu")), drives(problem)):
        if step["termination"] != "converged":
            break
        value, rest = least(solver, drive, *state(problem, path))
        if rest > 1e-4:
            print(f"  {file.stem} {step['increment']}: forces do not balance, {rest:.0e} (volume penalty {step['penalty']:g}): not judged", flush=True)
            continue
        found.append((step["stability"], value, step["snapped"] is not None))
    return found


def is_wrong(said, value):
    return (said == "minimum" and value < -SIGN) or (said == "saddle" and value > SIGN)


def judge(label, file, *sets):
    """A row; gives the number of wrong ones and of those judged."""
    out = FOLDER / f"out-{file.stem}"
    run = solve(file, *sets, out=out)
    found = verdicts(file, run, out)
    wrong = [f for f in found if is_wrong(*f[:2])]
    said = [f[0] for f in found]
    counts = ", ".join(f"{said.count(word)} {word}" for word in ("minimum", "saddle", "not_determined") if word in said)
    if label:
        worst = ", ".join(f"{f[0]} with {f[1]:.1e}" for f in wrong[:2])
        row(label, "never wrong", f"{run.end}; {counts}; least {min((f[1] for f in found), default=math.nan):.1e}; {sum(f[2] for f in found)} snapped {worst}", not wrong)
    return len(wrong), len(found), run


def columns():
    share = 1 / (8.0**2 / (4 * math.pi**2 * 4 / 12) + 1.2) / 4  # Euler's load of a clamped beam with shear.
    for bow in (0.0, 0.02):
        mesh = meshes.column(f"column{bow}", [3, 24], [1.0, 8.0], bow)
        for factor in FACTORS[:: 2 if common.given.quick else 1]:
            for increments in (1, 10):
                for fall in ("continue", "descend"):
                    for check in ("exact",) if common.given.quick else ("exact", "follow"):
                        step = {"increments": increments, "support": {"y1": {"displacement": {"y": -8.0 * share * factor}}}}
                        file = scene(f"column-{bow}-{factor}-{increments}-{fall}-{check}", mesh=mesh, material={"body": NEO}, support=[support("y0", x=0.0, y=0.0), support("y1", x=0.0, y=0.0)],
                                     step=[step], solver={"on_instability": fall, "stability": check} | ({"penalty": 0.0} if fall == "continue" else {}))
                        judge(f"column, bow {bow}, {factor} x Euler, {increments} increments, {fall}, {check}", file)


def arch():
    mesh = meshes.column("arch", [2, 32], [0.3, 8.0], 1.0)
    roller = {"name": "roller", "on": "x1", "shape": {"kind": "cylinder", "point": [2.3, 4.0, 0.0], "axis": [0.0, 0.0, 1.0], "radius": 1.0}}
    for increments in (1, 5, 20):
        for check in ("exact", "follow"):
            file = scene(f"arch-{increments}-{check}", mesh=mesh, material={"body": NEO}, support=[support(["y0", "y1"], "ends", x=0.0, y=0.0)], obstacle=[roller],
                         step=[{"increments": increments, "obstacle": {"roller": {"translation": [-1.5, 0.0, 0.0]}}}], solver={"stability": check})
            judge(f"shallow arch, {increments} increments, {check}", file)


def limit_pressure():
    """Largest pressure of a neo-Hookean sphere of radii 1 and 2 over its shear modulus: int 2 (l - l^-5) / (l^3 - 1) dl."""
    best = 0.0
    for a in np.linspace(1.05, 4.0, 200):
        l = np.linspace((1 + (a**3 - 1) / 8) ** (1 / 3), a, 2001)
        best = max(best, np.trapezoid(2 * (l - l**-5) / (l**3 - 1), l))
    return best


def balloon():
    most = limit_pressure()
    mesh = meshes.shell("shell", 16)
    for share in (0.5, 0.9, 0.98, 1.03, 1.3):
        for fall in ("stop", "descend"):
            file = scene(f"balloon-{share}-{fall}", mesh=mesh, kind="axisymmetric", material={"body": NEO}, support=[support("y0", y=0.0)],
                         pressure=[{"on": "x0", "value": share * most}], step=[{"increments": 10}], solver={"on_instability": fall})
            run = solve(file)
            said = [s["stability"] for s in run.steps if s["termination"] == "converged"]
            reached = run.last["time"] * share
            met = (run.converged and set(said) == {"minimum"}) if share < 1 else (not run.converged and abs(reached - 1) < 0.02)
            row(f"balloon, {share} x its largest pressure ({most:.4f}), {fall}", "minimum" if share < 1 else "ends at 1 within 0.02, never certified beyond",
                f"{run.end}; {set(said)}; {reached:.3f} of it", met)


def random_scenes(count, seed):
    """Scenes of the random family with rubber and few unknowns."""
    index, judged, increments, wrong, ends = 0, 0, 0, [], []
    while judged < count:
        draft, text = family_scenes.scene(seed, index)
        index += 1
        nodes = math.prod(2 * n + 1 for n in draft.box.counts)
        if "linear-elastic" in text or draft.dim * nodes > MOST:
            continue
        file = FOLDER / f"random-{index - 1}.toml"
        draft.box.write(file.with_suffix(".msh"))
        file.write_text(text.replace("MESH", file.stem + ".msh"))
        bad, seen, run = judge("", file)
        judged, increments = judged + 1, increments + seen
        wrong += [file.stem] * bool(bad)
        ends += [f"{file.stem}: {run.end}"] * (not run.converged)
    row(f"{judged} random scenes of rubber, seed {seed}, {increments} increments", "never wrong", f"wrong {wrong}; {len(ends)} not converged {ends[:5]}", not wrong)


def main():
    common.arguments(__doc__, count=200, seed=1)
    columns(), arch(), balloon()
    random_scenes(15 if common.given.quick else common.given.count, common.given.seed)
    common.finish()


main()
