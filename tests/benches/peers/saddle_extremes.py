#!/usr/bin/env python3
"""The independent solver on rows of `signorini bench --study extremes`. usage: saddle_extremes.py FOLDER [ROW ..] >> peers.csv
Needs: pip install numpy scipy pypardiso

FOLDER is the folder `extremes` that the bench leaves beside its page: scene and mesh of every row. The rows are those whose
known value is that of a peer, but those of ngsolve_extremes.py. Each value is what the row compares, at the end of its last
step; where no equilibrium is found, or an unstable one, a comment says so.
"""
import argparse
import pathlib
import sys
import time
import tomllib

import saddle_stability
from saddle_contact import solve
from saddle_newton import NotConverged
from saddle_scene import Problem

ROWS = pathlib.Path(__file__).parents[3] / "client/bench/src/extremes/rows"
NAME = "P2-P1, direct Newton"


def value(line, pointer):
    """What a pointer of a result line of Signorini means in a line of this solver."""
    parts = pointer.strip("/").split("/")
    if parts == ["strain_energy"]:
        return line["strain_energy"]
    kind, name, _, axis = parts
    if kind == "supports":
        return line["supports"][name][int(axis)]
    # In the order of the scene, as both programs name them.
    return line["obstacles"][name][int(axis)]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("rows", nargs="*")
    given = parser.parse_args()
    files = [tomllib.loads(path.read_text()) for path in sorted(ROWS.glob("*.toml"))]
    trials = [trial for file in files for trial in file["trial"]]
    for trial in trials:
        row = trial["id"]
        is_ours = trial.get("expected") == "peer" and "NGSolve" not in trial["known"]
        if not is_ours or (given.rows and row not in given.rows):
            continue
        began = time.perf_counter()
        last, worst = None, 0
        try:
            for last in solve(Problem(given.folder / f"{row}.toml", None, {}), None, False):
                worst = max(worst, last.get("unstable_on_the_way") or 0)
        except NotConverged as error:
            last = None
            print(f"# {row}: {NAME} finds no equilibrium: {error}", flush=True)
        if last is not None and last.get("converged", False):
            seconds = time.perf_counter() - began
            print(f"{row},\"{NAME}\",{value(last, trial['value']):.12g},{seconds:.3f},", flush=True)
            if worst:
                print(f"# {row}: {NAME} counts {worst} unstable motions on the way", flush=True)
        elif last is not None:
            where = f"in increment {last['increment']} of step {last['step']}, {last['cause']}"
            print(f"# {row}: {NAME} ends early, {where}", flush=True)
        print(row, file=sys.stderr, flush=True)


if __name__ == "__main__":
    main()
