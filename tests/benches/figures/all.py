#!/usr/bin/env python3
"""All figures in order, one table at the end. usage: all.py --signorini PROGRAM --cases DIR [--other PROGRAM] [--seconds 1800] [--quick] [--only NAME,..]

Each subject gets --seconds at most; what it has found until then is kept. `paired` runs with --other only.
"""
import argparse
import json
import os
import signal
import subprocess
import sys
import tempfile
from pathlib import Path

SUBJECTS = ("trust", "digits", "confined", "strips", "sphere", "hertz", "curved", "oring", "exact", "certificate", "poses", "friction", "tools", "wavy", "theory", "extremes", "paired")


def stop(process):
    """Ends a script and the program that it runs."""
    for way in (signal.SIGINT, signal.SIGKILL):
        try:
            os.killpg(process.pid, way)
            process.wait(10)
            return
        except subprocess.TimeoutExpired:
            pass


def measure(name, given, rows):
    """Runs a subject; a line of its own where it fails or is late."""
    command = [sys.executable, str(Path(__file__).parent / f"{name}.py"), "--signorini", given.signorini, "--rows", rows]
    command += ["--cases", given.cases] if given.cases else []
    command += ["--quick"] if given.quick else []
    command += ["--other", given.other] if name == "paired" else []
    process = subprocess.Popen(command, start_new_session=True)
    try:
        code = process.wait(given.seconds)
        fault = "" if code in (0, 1) else f"exit code {code}"
    except subprocess.TimeoutExpired:
        fault = f"more than {given.seconds:g} s"
        stop(process)
    if fault:
        with open(rows, "a") as file:
            file.write(json.dumps({"subject": name, "what": "whole subject", "asked": "ends", "measured": fault, "verdict": "MISSED"}) + "\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--signorini", default=os.environ.get("SIGNORINI", "signorini"))
    parser.add_argument("--cases", default=os.environ.get("SIGNORINI_CASES"))
    parser.add_argument("--other")
    parser.add_argument("--seconds", type=float, default=1800.0)
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--only", default=",".join(SUBJECTS))
    given = parser.parse_args()
    with tempfile.NamedTemporaryFile("r", suffix=".jsonl") as file:
        for name in given.only.split(","):
            if name != "paired" or given.other:
                measure(name, given, file.name)
        rows = [json.loads(line) for line in file]
    print("\n| subject | what | asked | measured | |\n|---|---|---|---|---|")
    for row in rows:
        print("| " + " | ".join(str(row[key]).replace("|", "/") for key in ("subject", "what", "asked", "measured", "verdict")) + " |")
    missed = sum(row["verdict"] == "MISSED" for row in rows)
    print(f"\n{len(rows)} figures, {missed} missed")
    sys.exit(missed > 0)


main()
