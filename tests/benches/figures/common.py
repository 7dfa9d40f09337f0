"""What all scripts of this folder share: arguments, runs of the program, scene files, rows of the table.

A row has the figure asked, the figure measured and whether it is met. Seconds are those that the program tells of a
fresh process (`seconds.total`: mesh reading and output apart), memory is the peak of the process in MB.
"""
import argparse
import json
import os
import signal
import statistics
import subprocess
import sys
import tempfile
import threading
import time
from dataclasses import dataclass
from pathlib import Path

HERE = Path(__file__).resolve().parent
PEERS = HERE.parent / "peers"
sys.path.insert(0, str(PEERS))

NEO = {"model": "neo-hookean", "shear_modulus": 1.0}
MOONEY = {"model": "mooney-rivlin", "c10": 0.4, "c01": 0.1}
ALL = {"x": 0.0, "y": 0.0, "z": 0.0}
given = None
rows = []
folder = tempfile.TemporaryDirectory(prefix="figures-")
FOLDER = Path(folder.name)


def arguments(doc, **more):
    """Reads the command line; `more` are options of one script by name and default."""
    global given
    parser = argparse.ArgumentParser(description=doc, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--signorini", default=os.environ.get("SIGNORINI", "signorini"), help="program, or $SIGNORINI")
    parser.add_argument("--cases", default=os.environ.get("SIGNORINI_CASES"), help="folder of the benchmark cases, or $SIGNORINI_CASES")
    parser.add_argument("--quick", action="store_true", help="a part of the matrix only")
    parser.add_argument("--limit", type=float, default=300.0, help="seconds of one run")
    parser.add_argument("--rows", help="file to which rows are appended as JSON lines")
    for name, default in more.items():
        parser.add_argument("--" + name, default=default, type=type(default) if default is not None else str)
    given = parser.parse_args()
    return given


def case(name):
    """A file of the folder of cases."""
    if not given.cases:
        sys.exit("give the folder of the benchmark cases by --cases or SIGNORINI_CASES")
    return Path(given.cases) / name


def case_mesh(name):
    return case("..") / "meshes" / f"{name}.msh"


@dataclass
class Run:
    """Increments and summary as the program told them, exit code, seconds of wall time, peak memory in MB."""

    steps: list
    summary: dict
    code: int
    wall: float
    memory: float
    errors: str

    @property
    def last(self):
        return self.steps[-1] if self.steps else {"termination": "none", "cause": self.errors.strip()[-120:], "time": 0.0}

    @property
    def converged(self):
        return self.code == 0 and all(s["termination"] == "converged" for s in self.steps)

    @property
    def seconds(self):
        return sum(s["seconds"]["total"] for s in self.steps)

    @property
    def applications(self):
        return [s["preconditioner_applications"] for s in self.steps]

    @property
    def end(self):
        """A few words: how it ended."""
        if self.converged:
            return "converged"
        if self.last["termination"] in ("converged", "none"):
            return f"exit code {self.code} after {self.last['time']:.3f}: {self.errors.strip()[-120:]}"
        return f"{self.last['termination']} ({self.last.get('cause')}) at {self.last['time']:.3f}"


def solve(scene, *sets, out=None, binary=None):
    """Runs a scene file with changes KEY=VALUE."""
    command = [binary or given.signorini, "solve", str(scene), "--json", *(x for s in sets for x in ("--set", s))]
    command += ["--out", str(out)] if out else []
    start = time.perf_counter()
    with tempfile.TemporaryFile("w+") as told, tempfile.TemporaryFile("w+") as errors:
        process = subprocess.Popen(command, stdout=told, stderr=errors)
        timer = threading.Timer(given.limit, process.send_signal, [signal.SIGKILL])
        timer.start()
        _, status, usage = os.wait4(process.pid, 0)
        timer.cancel()
        process.returncode = os.waitstatus_to_exitcode(status)
        wall = time.perf_counter() - start
        told.seek(0), errors.seek(0)
        events = [json.loads(line) for line in told.read().splitlines() if line.startswith("{") and line.endswith("}")]
        fault = errors.read() if process.returncode != -9 else f"more than {given.limit:g} s"
    steps = [e for e in events if e["event"] == "step"]
    summary = next((e for e in events if e["event"] == "summary"), {})
    return Run(steps, summary, process.returncode, wall, usage.ru_maxrss / 1e3, fault)


def inline(value):
    """A value as TOML."""
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key} = {inline(x)}" for key, x in value.items()) + " }"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(map(inline, value)) + "]"
    return json.dumps(str(value) if isinstance(value, Path) else value)


def scene(name, **keys):
    """Writes a scene of these keys; gives its file."""
    path = FOLDER / f"{name}.toml"
    path.write_text("".join(f"{key} = {inline(value)}\n" for key, value in keys.items()))
    return path


def support(on, name=None, **axes):
    return {"name": name or (on if isinstance(on, str) else on[0]), "on": on, "displacement": axes}


def plane(name, on, point, normal):
    return {"name": name, "on": on, "shape": {"kind": "half-space", "point": point, "normal": normal}}


def row(what, asked, measured, met):
    """One line of the table; `met` None where nothing is asked."""
    verdict = {True: "met", False: "MISSED", None: "-"}[None if met is None else bool(met)]
    subject = Path(sys.argv[0]).stem
    rows.append({"subject": subject, "what": what, "asked": asked, "measured": measured, "verdict": verdict})
    print(f"{subject} | {what} | {asked} | {measured} | {verdict}", flush=True)
    if given.rows:
        with open(given.rows, "a") as file:
            file.write(json.dumps(rows[-1]) + "\n")


def finish():
    """Exit code 1 where a figure is missed."""
    sys.exit(any(r["verdict"] == "MISSED" for r in rows))


def by_turns(*runs, repeats=3):
    """Each of the functions `repeats` times by turns; gives the list of results of each."""
    rounds = [[run() for run in runs] for _ in range(repeats)]
    return [list(results) for results in zip(*rounds)]


def median(values):
    return statistics.median(values)


def close(a, b):
    """Relative difference."""
    return abs(a - b) / max(abs(a), abs(b), 1e-300)


def worst(values):
    """The largest, 0 of none."""
    return max(values, default=0.0)
