"""Counts in how many increments each fallback of a load path acts, over scene files.

    python3 rescues.py BINARY SCENE.. > rescues.csv

Runs `BINARY solve SCENE --json --quiet` and reads `attempts` of every result line; a fallback acts
in an increment where an attempt is followed by it. Scenes that are refused do not count.
"""

import json
import subprocess
import sys
from collections import Counter

NAMES = {
    "smaller_part": "smaller part",
    "volume_penalty": "volume penalty",
    "snap_through": "snap-through",
    "proximal_rest": "proximal rest",
}


def increments(binary, scene):
    found = subprocess.run(
        [binary, "solve", scene, "--json", "--quiet"], capture_output=True, text=True
    )
    lines = (json.loads(line) for line in found.stdout.splitlines() if line.startswith("{"))
    return [line for line in lines if line.get("event") == "step"]


def main():
    binary, *scenes = sys.argv[1:]
    acts, total, solved = Counter(), 0, 0
    for scene in scenes:
        lines = increments(binary, scene)
        total += len(lines)
        solved += bool(lines)
        for line in lines:
            acts.update({attempt["followed_by"] for attempt in line["attempts"]})
    print("fallback,acts in")
    for word, name in NAMES.items():
        print(f"{name},{acts[word]} of {total} increments in {solved} scenes")


if __name__ == "__main__":
    main()
