#!/usr/bin/env python3
"""Applications an increment by kind, of what `family.py run` kept. usage: family_counts.py FOLDER [--space SPACE]

Columns: scenes, increments, median, 99th percentile and most applications of converged increments,
scenes with the penalty, scenes that end before their last increment.
"""
import argparse
import json
from pathlib import Path

import numpy as np

COLUMNS = ("kind", "scenes", "increments", "median", "p99", "most", "penalty", "ended")


def row(kind, scenes):
    steps = [step for scene in scenes for step in scene]
    counts = [step["preconditioner_applications"] for step in steps if step["termination"] == "converged"]
    has = lambda key: sum(any(step.get(key) for step in scene) for scene in scenes)
    ended = sum(not scene or scene[-1]["termination"] != "converged" for scene in scenes)
    middle, high, most = np.median(counts), np.percentile(counts, 99), max(counts)
    return (
        kind, len(scenes), len(steps), f"{middle:.0f}", f"{high:.0f}", most, has("penalty"), ended
    )


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder")
    parser.add_argument("--space", choices=("linear", "quadratic"), default="quadratic")
    given = parser.parse_args()
    kinds = {}
    for file in sorted(Path(given.folder).glob(f"*.{given.space}.steps.json")):
        # Names are SEED-INDEX-KIND.SPACE.steps.json.
        kind = file.name.split("-", 2)[2].split(".")[0]
        kinds.setdefault(kind, []).append(json.loads(file.read_text()))
    print("| " + " | ".join(COLUMNS) + " |\n" + "|---" * len(COLUMNS) + "|")
    everything = [scene for scenes in kinds.values() for scene in scenes]
    for kind, scenes in [*sorted(kinds.items()), ("all", everything)]:
        print("| " + " | ".join(map(str, row(kind, scenes))) + " |")


if __name__ == "__main__":
    main()
