#!/usr/bin/env python3
"""Scenes of bodies in contact with each other by an independent solver. usage: pair_contact.py SCENE.toml [--parts N]
[--points N]. Needs: pip install numpy scipy, and pypardiso for speed.

Plane strain and bodies of revolution, Taylor-Hood P2-P1, linear elasticity or rubber of Mooney and Rivlin, friction or
none, tools beside (without friction); a direct semismooth Newton method on gaps by volume (`pair_gap`). One JSON line
an increment: energy, forces and moments of the contacts on the body named first, largest pressures, active multipliers,
forces of tools, displacements of probes.
"""
import argparse
import json
import os
import time

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("MKL_NUM_THREADS", "1")

import numpy as np

from pair_friction import RoughSolver
from pair_newton import PairSolver, push_apart, rest
from pair_scene import POINTS, PairProblem
from saddle_contact import strain_energy
from saddle_newton import NotConverged

# Least parts of a step of rubber.
RUBBER_PARTS = 4


def solve(problem, parts=None, limit=np.inf):
    """One record an increment; ends where one does not converge, or after `limit` seconds of the processor."""
    is_rough = any("friction" in table or "tresca" in table for table in problem.contacts)
    solver = RoughSolver(problem) if is_rough else PairSolver(problem)
    state, drive = rest(solver), problem.start()
    solver.deadline = time.process_time() + limit
    follow = solver.increment if is_rough else solver.follow
    for step, (increments, end) in enumerate(problem.steps(), 1):
        start = drive
        for increment in range(1, increments + 1):
            began = time.perf_counter()
            target = start.between(end, increment / increments)
            state = solver.begun(state) if drive.load else state
            least = parts or (-(-RUBBER_PARTS // increments) if problem.is_rubber else 1)
            found = {"step": step, "increment": increment}
            try:
                if not drive.load and problem.is_rubber and not is_rough:
                    state = push_apart(solver, state, drive, least)
                state = follow(state, drive, target, least)
            except (NotConverged, TimeoutError) as fault:
                yield found | {"converged": False, "cause": str(fault)}
                return
            drive = target
            seconds = round(time.perf_counter() - began, 3)
            yield found | record(solver, state, drive) | {"converged": True, "seconds": seconds}


def record(solver, state, drive):
    problem, pairs = solver.problem, solver.surface
    body = solver.body.respond(state.u, state.p)
    contacts = {}
    own = zip(problem.contacts, pairs.pairs, pairs.forces(state.u, state.multipliers), pairs.own(state.multipliers))
    rough = solver.friction(state) if isinstance(solver, RoughSolver) else [(0.0, 0.0, None)] * len(pairs.pairs)
    for (table, pair, forces, multipliers), (*dragged, dissipated) in zip(own, rough):
        forces = [force + drag for force, drag in zip(forces, dragged)]
        contacts[table["name"]] = {
            "force": forces[table["carrier"]][:2].tolist(), "moment": float(forces[table["carrier"]][2]),
            "sum": float(np.abs(forces[0] + forces[1]).max()),
            "pressing": pair.pressing(state.u, multipliers), "peak_pressure": pair.peak(multipliers),
            "active": int((multipliers > 0.0).sum()), "dissipated": dissipated,
            "least_covered": pair.least_covered(state.u, multipliers),
        }
    return {
        "strain_energy": strain_energy(problem, body, state),
        "contacts": contacts,
        "obstacles": tools(solver, state, drive),
        "probes": {probe["name"]: probed(problem, state, probe["point"]) for probe in problem.scene.get("probe", [])},
        "least_within": problem.body.least_within(state.u) if problem.is_rubber else None,
        "iterations": solver.iterations,
    }


def tools(solver, state, drive):
    """Forces of the obstacles beside."""
    problem, surface = solver.problem, solver.surface.tools
    forces = surface.forces(state.u, problem.placed(drive), state.multipliers[: surface.multipliers])
    return {name: force.tolist() for name, force in zip(problem.obstacle_names, forces)}


def probed(problem, state, place):
    """The displacement of the node there."""
    away = np.linalg.norm(problem.mesh.nodes - np.array(place)[:2], axis=1)
    return state.u.reshape(-1, 2)[away.argmin()].tolist()


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scene")
    parser.add_argument("--parts", type=int)
    parser.add_argument("--points", type=int, default=POINTS)
    given = parser.parse_args()
    for line in solve(PairProblem(given.scene, given.points), given.parts):
        print(json.dumps(line), flush=True)


if __name__ == "__main__":
    main()
