#!/usr/bin/env python3
"""Studies through a queue under faults, and what they cost.

    cargo build --release -p signorini-client --features fleet
    tests/benches/fleet/studies.py --program target/release/signorini            # 10 000 cases
    tests/benches/fleet/studies.py --program target/release/signorini --cases 1000 --pending 20000

Needs nats-server with JetStream on PATH. Three parts, each a line of figures:

clean     all cases on 4 workers: wall time a case and worker, minus the solver's seconds; where the workers share
          cores that contains their waiting for each other, so processor time a case is told too
faults    the same with 10 poison cases (5 that the server refuses, 5 whose workers are killed each time they
          begin one, 3 kills each), 5 more kills of workers (20 in all), 3 of servers, one of NATS, one of the study
pending   memory of the study and of a worker with few and with many pending cases

Ends with 1 when a case is missing or doubled, a dead letter is not named, or another case has failed.
"""

from __future__ import annotations

import argparse
import contextlib
import csv
import os
import random
import re
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]
SCENE = ROOT / "client" / "examples" / "hertz-sphere.toml"
MESH = ROOT / "client" / "examples" / "meshes" / "indent_l1.msh"
TRIES = 3
REFUSED, KILLERS = 5, 5


def free_port() -> int:
    """A port that nobody listens on now."""
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        return int(one.getsockname()[1])


def peak(process: subprocess.Popen[str]) -> float:
    """Peak resident memory, MiB."""
    text = Path(f"/proc/{process.pid}/status").read_text()
    found = re.search(r"VmHWM:\s+(\d+) kB", text)
    return int(found.group(1)) / 1024 if found else 0.0


def resident(process: subprocess.Popen[str]) -> float:
    """Resident memory now, MiB."""
    text = Path(f"/proc/{process.pid}/status").read_text()
    found = re.search(r"VmRSS:\s+(\d+) kB", text)
    return int(found.group(1)) / 1024 if found else 0.0


def processor(process: subprocess.Popen[str]) -> float:
    """Processor time so far, seconds."""
    fields = Path(f"/proc/{process.pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


class Place:
    """NATS, servers and workers in a folder."""

    def __init__(self, program: str, folder: Path) -> None:
        self.program, self.folder = program, folder
        self.port = free_port()
        self.url = f"nats://127.0.0.1:{self.port}"
        self.running: list[subprocess.Popen[str]] = []

    def spawn(self, command: list[str], **more: object) -> subprocess.Popen[str]:
        """A process that ends with this one."""
        process = subprocess.Popen(command, text=True, **more)  # type: ignore[call-overload]
        self.running.append(process)
        return process

    def nats(self) -> subprocess.Popen[str]:
        """Starts NATS, or starts it again."""
        store, log = str(self.folder / "store"), str(self.folder / "nats.log")
        command = ["nats-server", "-js", "-sd", store, "-a", "127.0.0.1", "-p", str(self.port), "-l", log]
        process = self.spawn(command)
        for _ in range(200):
            with contextlib.suppress(OSError), socket.create_connection(("127.0.0.1", self.port), 1):
                return process
            time.sleep(0.05)
        raise SystemExit("nats-server does not start")

    def server(self, name: str) -> subprocess.Popen[str]:
        """A server on a socket of its own."""
        path = f"unix:{self.folder / name}"
        command = [self.program, "serve", "--listen", path, "--metrics-listen", "", "--log-level", "error"]
        process = self.spawn(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
        assert process.stdout is not None
        process.stdout.readline()
        return process

    def worker(self, *more: str, **pipes: object) -> subprocess.Popen[str]:
        """A worker of the queue."""
        command = [self.program, "worker", "--queue", self.url, "--threads", "1", *more]
        return self.spawn(command, **(pipes or {"stderr": subprocess.DEVNULL}))

    def study(self, file: Path, out: Path, *more: str) -> subprocess.Popen[str]:
        """A study through the queue."""
        command = [self.program, "study", str(file), "--out", str(out), "--queue", self.url, *more]
        return self.spawn(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)

    def end(self) -> None:
        """Ends what still runs."""
        for process in self.running:
            if process.poll() is None:
                process.kill()
            process.wait()


def write_study(folder: Path, cases: int, bad: set[int]) -> Path:
    """A table of depths and ratios of Poisson; those of `bad` are none."""
    with (folder / "cases.csv").open("w", newline="") as file:
        rows = csv.writer(file)
        rows.writerow(["step.0.obstacle.ball.translation.2", "material.body.poisson_ratio"])
        for case in range(cases):
            rows.writerow([f"{-0.02 - 0.03 * case / cases:.6f}", 0.6 if case in bad else 0.5])
    file = folder / "study.toml"
    file.write_text(
        f'scene = "{SCENE}"\nset = ["mesh={MESH}", "solver.tolerance=1e-8"]\n[list]\nfile = "cases.csv"\n'
        '[[result]]\nname = "force"\nof = "obstacles.ball.force.z"\n'
    )
    return file


def table(out: Path) -> list[dict[str, str]]:
    """Rows of a table."""
    with out.open(newline="") as file:
        return list(csv.DictReader(file))


def logged(out: Path) -> int:
    """Rows of a log."""
    log = Path(f"{out}.log")
    return log.read_text().count('{"row":') if log.exists() else 0


def clean(place: Place, nats: subprocess.Popen[str], cases: int, workers: int) -> None:
    """All cases without a fault."""
    file, out = write_study(place.folder, cases, set()), place.folder / "clean.csv"
    team = [place.worker() for _ in range(workers)]
    time.sleep(1)
    if any(one.poll() is not None for one in team):
        raise SystemExit("the workers do not start: was the program built with --features fleet?")
    before = [processor(one) for one in [nats, *team]]
    begun, others = time.monotonic(), os.times()
    code = place.study(file, out).wait()
    wall = time.monotonic() - begun
    spent = [processor(one) - used for one, used in zip([nats, *team], before, strict=True)]
    # The study is the one child that was waited for meanwhile.
    study = os.times().children_user + os.times().children_system - others.children_user - others.children_system
    rows = table(out)
    solver = sum(float(row["seconds"]) for row in rows) / cases
    each = wall * workers / cases
    print(
        f"clean: {cases} cases, {workers} workers, {wall:.1f} s, code {code}; a case and worker {1e3 * each:.2f} ms, "
        f"solver {1e3 * solver:.2f} ms, beside it {1e3 * (each - solver):.2f} ms",
        flush=True,
    )
    shares = {"NATS": spent[0], "workers": sum(spent[1:]), "study": study}
    told = ", ".join(f"{name} {1e3 * seconds / cases:.2f} ms" for name, seconds in shares.items())
    print(f"processor time a case: {told}", flush=True)
    assert code == 0 and len(rows) == cases, (code, len(rows))
    for one in team:
        one.kill()
        one.wait()


class Team:
    """Workers that are started again when they are killed; two of them on servers of their own."""

    def __init__(self, place: Place, workers: int, killers: set[int]) -> None:
        self.place, self.killers, self.kills = place, killers, 0
        self.lock, self.over = threading.Lock(), False
        self.members: dict[int, subprocess.Popen[str]] = {}
        for seat in range(workers):
            threading.Thread(target=self.keep, args=(seat,), daemon=True).start()

    def keep(self, seat: int) -> None:
        """Starts a worker again and again, and kills it when it begins a case that kills."""
        more = ["--server", f"unix:{self.place.folder / f'socket{seat}'}"] if seat < 2 else []
        while not self.over:
            worker = self.place.worker("--verbose", *more, stderr=subprocess.PIPE)
            self.members[seat] = worker
            assert worker.stderr is not None
            for line in worker.stderr:
                begun = re.match(r"begins: case (\d+)-", line)
                if begun and int(begun.group(1)) in self.killers:
                    self.kill(worker)
            worker.wait()
            time.sleep(0.1)

    def kill(self, worker: subprocess.Popen[str]) -> None:
        """As the system does when memory is short."""
        with self.lock:
            self.kills += 1
            worker.kill()


def faults(place: Place, nats: subprocess.Popen[str], cases: int, workers: int) -> None:
    """Kills of workers, servers, NATS and the study; what is left is counted."""
    dice = random.Random(20)
    poison = dice.sample(range(cases), REFUSED + KILLERS)
    bad, killers = set(poison[:REFUSED]), set(poison[REFUSED:])
    file, out = write_study(place.folder, cases, bad), place.folder / "faults.csv"
    servers = [place.server("socket0"), place.server("socket1")]
    team = Team(place, workers, killers)
    begun = time.monotonic()
    study = place.study(file, out, "--tries", str(TRIES))
    deeds = ["worker"] * 5 + ["server"] * 3 + ["nats", "study"]
    dice.shuffle(deeds)
    for number, deed in enumerate(deeds, 1):
        while logged(out) < cases * number // (len(deeds) + 2) and study.poll() is None:
            time.sleep(0.01)
        if deed == "worker":
            team.kill(team.members[dice.randrange(workers)])
        elif deed == "server":
            which = dice.randrange(2)
            servers[which].kill()
            servers[which].wait()
            (place.folder / f"socket{which}").unlink(missing_ok=True)
            servers[which] = place.server(f"socket{which}")
        elif deed == "nats":
            nats.kill()
            nats.wait()
            time.sleep(0.5)
            nats = place.nats()
        else:
            study.kill()
            study.wait()
            study = place.study(file, out, "--tries", str(TRIES), "--resume")
    code = study.wait()
    wall = time.monotonic() - begun
    team.over = True
    rows = table(out)
    told = {kind: sorted(int(row["case"]) for row in rows if row["termination"] == kind) for kind in ("refused", "failed")}
    dead = [row for row in rows if row["termination"] == "failed"]
    print(
        f"faults: {cases} cases, {workers} workers, {wall:.1f} s, code {code}; {team.kills} workers killed, 3 servers, "
        f"NATS and the study once; {len(rows)} rows, {len({row['case'] for row in rows})} cases, {logged(out)} logged; "
        f"refused {told['refused']}, dead letters {told['failed']}",
        flush=True,
    )
    for row in dead:
        print(f"  {row['id']}: {row['cause']}: {row['message']}")
    assert code == 3, code
    assert [int(row["case"]) for row in rows] == list(range(cases))
    assert logged(out) == cases
    assert told["refused"] == sorted(bad), (told["refused"], sorted(bad))
    assert told["failed"] == sorted(killers), (told["failed"], sorted(killers))
    assert all(row["cause"] == "worker_lost" for row in dead)
    converged = [row for row in rows if row["termination"] == "converged"]
    assert len(converged) == cases - REFUSED - KILLERS and all(row["force"] for row in converged)


def pending(place: Place, cases: int) -> None:
    """Memory of the study and of a worker with so many cases in the queue."""
    file, out = place.folder / "many.toml", place.folder / f"many{cases}.csv"
    file.write_text(
        f'scene = "{SCENE}"\nset = ["mesh={MESH}", "solver.tolerance=1e-8"]\n[sobol]\npoints = {cases}\n'
        '[[sobol.range]]\nkey = "step.0.obstacle.ball.translation.2"\nfrom = -0.05\nto = -0.02\n'
        '[[sobol.range]]\nkey = "material.body.shear_modulus"\nfrom = 0.5\nto = 2.0\n'
    )
    begun = time.monotonic()
    study = place.study(file, out)
    last, still = -1.0, 0
    # Published when its share of the processor stands still.
    while still < 3:
        time.sleep(1)
        used = sum(map(int, Path(f"/proc/{study.pid}/stat").read_text().split()[13:15]))
        still, last = (still + 1 if used - last <= 2 else 0), used
    published = time.monotonic() - begun - still
    worker = place.worker()
    time.sleep(10)
    print(
        f"pending: {cases} cases, published in {published:.1f} s; study {resident(study):.1f} MiB "
        f"(peak {peak(study):.1f}), worker {resident(worker):.1f} MiB (peak {peak(worker):.1f}), "
        f"{logged(out)} rows so far",
        flush=True,
    )
    worker.kill()
    study.send_signal(signal.SIGINT)
    assert study.wait() == 130


def main() -> None:
    """Runs the parts."""
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--program", default=str(ROOT / "target" / "release" / "signorini"))
    arguments.add_argument("--cases", type=int, default=10_000)
    arguments.add_argument("--workers", type=int, default=4)
    arguments.add_argument("--pending", type=int, default=200_000)
    arguments.add_argument("--parts", nargs="+", default=["clean", "faults", "pending"])
    given = arguments.parse_args()
    if shutil.which("nats-server") is None:
        sys.exit("nats-server is not on PATH")
    with tempfile.TemporaryDirectory(prefix="studies-") as folder:
        place = Place(given.program, Path(folder))
        try:
            nats = place.nats()
            if "clean" in given.parts:
                clean(place, nats, given.cases, given.workers)
            if "pending" in given.parts:
                for cases in (max(given.pending // 100, 2000), given.pending):
                    pending(place, cases)
            if "faults" in given.parts:
                faults(place, nats, given.cases, given.workers)
        finally:
            place.end()


if __name__ == "__main__":
    main()
