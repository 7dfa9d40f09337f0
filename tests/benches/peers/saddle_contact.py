#!/usr/bin/env python3
"""Signorini's scenes by an independent solver. usage: saddle_contact.py SCENE.toml [--space linear|quadratic]
[--parts N] [--eigenvalue] [--set-mesh FILE]. Needs: pip install numpy scipy, and pypardiso for speed.

Taylor-Hood P2-P1, linear elasticity or rubber of Mooney and Rivlin, frictionless obstacles; a direct semismooth Newton
method. One JSON line an increment: energy, forces, active multipliers, unstable motions, least J.
"""
import argparse
import json
import os
import time

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("MKL_NUM_THREADS", "1")

import numpy as np

import saddle_stability
from saddle_newton import NotConverged, Solver
from saddle_scene import Problem

# Least parts of a step of rubber, and of one with a curved obstacle.
RUBBER_PARTS, CURVED_PARTS = 10, 4


def least_parts(problem, increments):
    if problem.is_rubber:
        return -(-RUBBER_PARTS // increments)
    curved = any(o.kind != "half-space" for o in problem.obstacles)
    return -(-CURVED_PARTS // increments) if curved else 1


class Watch:
    """Unstable motions at the last part, and the most of all parts so far."""

    def __init__(self, solver):
        self.solver, self.last, self.most = solver, 0, 0

    def __call__(self, state, drive):
        self.last = saddle_stability.unstable_motions(self.solver, state, drive)
        self.most = max(self.most, self.last)


def solve(problem, parts=None, eigenvalue=False):
    """One record an increment; ends with the increment that does not converge."""
    if any("friction" in obstacle for obstacle in problem.scene.get("obstacle", [])):
        raise ValueError("friction is not solved here, but by saddle_friction")
    solver = Solver(problem)
    state, drive = solver.rest(), problem.start()
    watch = Watch(solver)
    for step, (increments, end) in enumerate(problem.steps(), 1):
        start = drive
        for increment in range(1, increments + 1):
            began = time.perf_counter()
            target = start.between(end, increment / increments)
            try:
                state = solver.follow(state, drive, target, parts or least_parts(problem, increments), watch)
            except NotConverged as fault:
                yield {"step": step, "increment": increment, "converged": False, "cause": str(fault)}
                return
            drive = target
            yield record(solver, state, drive, {
                "step": step, "increment": increment, "converged": True, "unstable_motions": watch.last,
                "unstable_on_the_way": watch.most,
                "lowest": saddle_stability.lowest(solver, state, drive) if eigenvalue else None,
                "seconds": round(time.perf_counter() - began, 3),
            })


def record(solver, state, drive, found):
    problem = solver.problem
    obstacles = problem.placed(drive)
    body = solver.body.respond(state.u, state.p)
    forces = solver.surface.forces(state.u, obstacles, state.multipliers)
    _, coupling, _ = solver.surface.contact(state.u, obstacles, state.multipliers)
    reaction = body.forces - drive.load * problem.load + coupling.T @ state.multipliers
    supports = {}
    for dof, (number, _) in zip(problem.held.tolist(), problem.owner):
        name = problem.supports[number]["name"]
        supports.setdefault(name, [0.0] * 3)[dof % problem.mesh.dim] += reaction[dof]
    return found | {
        "strain_energy": strain_energy(problem, body, state),
        "obstacles": {name: force.tolist() for name, force in zip(problem.obstacle_names, forces)},
        "supports": supports,
        "active": int(state.active.sum()),
        "multipliers": solver.surface.multipliers,
        "largest_pressure": float(np.abs(state.p).max(initial=0.0)),
        "largest_multiplier": float(state.multipliers.max(initial=0.0)),
        "min_jacobian": body.least_jacobian if np.isfinite(body.least_jacobian) else None,
        "least_within": problem.body.least_within(state.u) if problem.is_rubber else None,
        "iterations": solver.iterations,
    }


def strain_energy(problem, body, state):
    """int W + p^2 / (2 K), from int W - p j - p^2 / (2 K) and the defects -int phi (j + p / K)."""
    return float(body.energy - state.p @ body.defects) if problem.body.mixed else float(body.energy)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scene")
    parser.add_argument("--space", choices=("linear", "quadratic"))
    parser.add_argument("--parts", type=int)
    parser.add_argument("--eigenvalue", action="store_true")
    parser.add_argument("--mesh")
    parser.add_argument("--degree", type=int)
    given = parser.parse_args()
    changes = {"mesh": given.mesh, "degree": given.degree}
    for line in solve(Problem(given.scene, given.space, changes), given.parts, given.eigenvalue):
        print(json.dumps(line), flush=True)


if __name__ == "__main__":
    main()
