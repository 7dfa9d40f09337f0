"""Faults of a fleet: three servers behind a proxy, clients with resumed streams, and what goes wrong.

    faults.py PROGRAM --haproxy PROGRAM [--faults 60] [--clients 12] [--seed 1] [--pace 0.02]
                     [--nats 1] [--settle 30]

PROGRAM is a `signorini` with the feature `fleet`; `nats-server` has to be on PATH. Faults, by turns of
chance: a server is killed, a server is stopped beyond its lease and goes on, the proxy is killed (which
cuts every connection), NATS is restarted (of three servers of NATS one, and everything is kept thrice). Then every client has every result once, in order, with the bits
of an undisturbed server, and in the stream the epochs of each session only grow (that needs nats-py). A
backup of each server, made while it runs, has no faults and can be restored where the fleet's folder is not.
Prints the counts and the pauses after kills; exits with 1 where something was lost, doubled or differs.
"""

from __future__ import annotations

import argparse
import asyncio
import contextlib
import hashlib
import json
import os
import random
import signal
import socket
import statistics
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[2]
sys.path.insert(0, str(ROOT / "client" / "python"))

LEASE = 3
# Results that a server keeps: behind as many a session writes a checkpoint.
RETAINED = 200
SERVERS = 3
MESH = ROOT / "client" / "examples" / "meshes" / "indent_l1.msh"


def free_port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as one:
        return int(one.getsockname()[1])


def wait_for(port: int) -> None:
    end = time.monotonic() + 20
    while time.monotonic() < end:
        try:
            socket.create_connection(("127.0.0.1", port), 1).close()
        except OSError:
            time.sleep(0.02)
        else:
            return
    raise TimeoutError(f"nobody listens on {port}")


def wait_behind(s, address: str) -> None:
    """Until the proxy has found a server."""
    end = time.monotonic() + 60
    client = s.Client(address)
    while True:
        try:
            list(client.sessions())
        except s.SignoriniError:
            if time.monotonic() > end:
                raise
            time.sleep(0.2)
        else:
            break
    client.close()


class Program:
    """A process that is started again as often as it takes."""

    def __init__(self, command: list[str], port: int, log: Path) -> None:
        self.command, self.port, self.log = command, port, log
        self.start()

    def start(self) -> None:
        with self.log.open("ab") as log:
            self.process = subprocess.Popen(self.command, stdout=log, stderr=log, start_new_session=True)
        wait_for(self.port)

    def kill(self) -> None:
        self.process.kill()
        self.process.wait()

    def signal(self, number: int) -> None:
        self.process.send_signal(number)


class Fleet:
    """NATS, servers and a proxy in a folder."""

    def __init__(self, folder: Path, program: str, haproxy: str, replicas: int = 1) -> None:
        self.replicas = replicas
        ports = [(free_port(), free_port()) for _ in range(replicas)]
        self.url = ",".join(f"nats://127.0.0.1:{port}" for port, _ in ports)
        self.nats = [self.keeper(folder, number, ports) for number in range(replicas)]
        # Until they have a leader.
        time.sleep(5 if replicas > 1 else 0)
        self.program = program
        self.ports = [free_port() for _ in range(SERVERS)]
        self.servers = [self.server(folder, number) for number in range(SERVERS)]
        self.proxy = self.front(folder, haproxy)
        self.address = f"127.0.0.1:{self.proxy.port}"

    def keeper(self, folder: Path, number: int, ports: list[tuple[int, int]]) -> Program:
        port, route = ports[number]
        command = ["nats-server", "-js", "-a", "127.0.0.1", "-p", str(port), "-sd", str(folder / f"nats-{number}")]
        if len(ports) > 1:
            routes = ",".join(f"nats://127.0.0.1:{other}" for _, other in ports)
            command += ["--name", f"nats-{number}", "--cluster_name", "fleet", "--routes", routes]
            command += ["--cluster", f"nats://127.0.0.1:{route}"]
        return Program(command, port, folder / f"nats-{number}.log")

    def server(self, folder: Path, number: int) -> Program:
        settings = folder / f"server-{number}.toml"
        values = {
            "metrics_listen": "",
            "data": str(folder / f"data-{number}"),
            "fleet_nats": self.url,
            "fleet_store": str(folder / "store"),
            "fleet_name": f"server-{number}",
            "fleet_lease_seconds": LEASE,
            "fleet_replicas": self.replicas,
            "retained_results": RETAINED,
            "log_format": "text",
        }
        settings.write_text("".join(f"{key} = {json.dumps(value)}\n" for key, value in values.items()))
        listen = f"127.0.0.1:{self.ports[number]}"
        command = [self.program, "serve", "--config", str(settings), "--listen", listen]
        return Program(command, self.ports[number], folder / f"server-{number}.log")

    def front(self, folder: Path, haproxy: str) -> Program:
        text = (ROOT / "deploy" / "haproxy" / "haproxy.cfg").read_text()
        for number, port in enumerate(self.ports):
            text = text.replace(f"127.0.0.1:{7001 + number}", f"127.0.0.1:{port}")
        port = free_port()
        settings = folder / "haproxy.cfg"
        settings.write_text(text.replace("127.0.0.1:7200", f"127.0.0.1:{port}"))
        return Program([haproxy, "-db", "-f", str(settings)], port, folder / "haproxy.log")

    def held(self) -> dict[str, str]:
        command = [self.program, "fleet", "status", "--json", "--nats", self.url]
        told = subprocess.run(command, capture_output=True, check=False, text=True).stdout
        lines = map(json.loads, told.splitlines())
        return {line["session"]: line["server"] for line in lines}

    def stop(self) -> None:
        for one in [self.proxy, *self.servers, *self.nats]:
            one.signal(signal.SIGCONT)
            one.kill()


def backups(fleet: Fleet, folder: Path) -> list[str]:
    """What is wrong with a backup of a member of the fleet, made while it runs, once it stands alone."""
    wrong = []

    def run(*words: str | Path) -> None:
        done = subprocess.run([fleet.program, *words], capture_output=True, check=False, text=True)
        if done.returncode:
            wrong.append(f"{words[:2]}: {done.returncode} {done.stdout}{done.stderr}")

    copies = [folder / f"copy-{number}" for number in range(SERVERS)]
    for number, copy in enumerate(copies):
        run("backup", folder / f"data-{number}", copy)
    (folder / "store").rename(folder / "away")
    for copy in copies:
        again = copy.with_name(f"again-{copy.name}")
        run("fsck", copy)
        run("restore", copy, again)
        run("fsck", again)
    (folder / "away").rename(folder / "store")
    return wrong


def bits(increment) -> bytes:
    """Digest of what a result says, without times and what sessions share."""
    report = type(increment.report.message)()
    report.CopyFrom(increment.report.message)
    for name in ("seconds", "memory_bytes", "reused", "factorisations", "eigenvalue_applications"):
        report.ClearField(name)
    report.ClearField("compliance_columns")
    said = report.SerializeToString(deterministic=True) + increment.fields["pressure"].tobytes()
    return hashlib.sha256(said).digest()


def scene(s):
    return s.Scene(
        mesh=s.Mesh.read(MESH),
        materials={"body": s.LinearElastic(shear_modulus=1.0, poisson_ratio=0.5)},
        supports=[
            s.Support(name="base", on="z0", displacement={"x": 0.0, "y": 0.0, "z": 0.0}),
            s.Support(name="symmetry-x", on="x0", displacement={"x": 0.0}),
            s.Support(name="symmetry-y", on="y0", displacement={"y": 0.0}),
        ],
        obstacles=[s.Obstacle(name="ball", on="z1", shape=s.Sphere(centre=(0, 0, 1), radius=1.0))],
        solver=s.Solver(tolerance=1e-8),
        output={"fields": ["pressure"]},
    )


def depth(number: int) -> float:
    return 0.03 + 0.0005 * (number * 7 % 11)


class Client(threading.Thread):
    """Moves the ball until it is told to end; keeps what it is answered."""

    def __init__(self, s, address: str, name: str, pace: float) -> None:
        super().__init__(daemon=True)
        self.s, self.address, self.name_of, self.pace = s, address, name, pace
        self.results: list[tuple[float, bytes]] = []
        self.events: list[int] = []
        self.end = threading.Event()
        self.error: Exception | None = None

    def run(self) -> None:
        try:
            self.drive()
        except Exception as error:
            self.error = error

    def drive(self) -> None:
        client = self.s.Client(self.address)
        with client.session(scene(self.s), name=self.name_of, patience=120) as session:
            waiting = []
            number = 0
            while not self.end.is_set() or waiting:
                while len(waiting) < 4 and not self.end.is_set():
                    number += 1
                    waiting.append(session.move(ball=(0, 0, -depth(number))))
                for increment in waiting.pop(0):
                    self.events.append(increment.event)
                    self.results.append((time.monotonic(), bits(increment)))
                time.sleep(self.pace)
        client.close()


def fault(fleet: Fleet, kind: str, chance: random.Random, kills: list, clients: list[Client]) -> None:
    server = chance.choice(fleet.servers)
    if kind == "kill":
        name = f"server-{fleet.servers.index(server)}"
        mine = {session for session, holder in fleet.held().items() if holder == name}
        server.kill()
        moment = time.monotonic()
        time.sleep(chance.uniform(0.2, 2.0))
        server.start()
        time.sleep(LEASE + 1)
        kills.extend((moment, client) for client in clients if f"sessions/{client.name_of}" in mine)
    elif kind == "stop":
        server.signal(signal.SIGSTOP)
        time.sleep(LEASE + chance.uniform(0.2, 1.0))
        server.signal(signal.SIGCONT)
        time.sleep(0.5)
    elif kind == "cut":
        fleet.proxy.kill()
        fleet.proxy.start()
        time.sleep(chance.uniform(0.1, 0.5))
    else:
        keeper = chance.choice(fleet.nats)
        keeper.kill()
        time.sleep(chance.uniform(1, 4) if fleet.replicas > 1 else 0)
        keeper.start()
        time.sleep(chance.uniform(0.2, 1.0))


def settle(clients: list[Client], patience: float) -> None:
    """Until every client has a result after the fault, so that the next one meets sessions that work."""
    seen = [len(one.results) for one in clients]
    end = time.monotonic() + patience
    while time.monotonic() < end:
        if all(len(one.results) > count or one.error for one, count in zip(clients, seen, strict=True)):
            break
        time.sleep(0.1)


async def epochs(url: str) -> dict[str, list[tuple[int, str]]]:
    """Epochs and writers of each session's records, in order."""
    import nats

    connection = await nats.connect(url.split(","))
    stream = connection.jetstream()
    found: dict[str, list[tuple[int, str]]] = {}
    info = await stream.stream_info("SIGNORINI-SESSIONS")
    end = time.monotonic() + 30
    while not info.state.messages and time.monotonic() < end:
        # A server of NATS that has just started answers before it has read what it holds.
        await asyncio.sleep(0.5)
        info = await stream.stream_info("SIGNORINI-SESSIONS")
    assert info.state.messages, "the stream holds no record of any session"
    for number in range(info.state.first_seq, info.state.last_seq + 1):
        try:
            message = await stream.get_msg("SIGNORINI-SESSIONS", number)
        except nats.js.errors.NotFoundError:
            continue
        found.setdefault(message.subject, []).append(envelope(message.data))
    await connection.close()
    return found


def envelope(data: bytes) -> tuple[int, str]:
    """Epoch and writer of a record: fields 3 and 4."""
    at, epoch, writer = 0, 0, ""

    def varint() -> int:
        nonlocal at
        value = shift = 0
        while True:
            byte = data[at]
            at += 1
            value |= (byte & 127) << shift
            shift += 7
            if byte < 128:
                return value

    while at < len(data):
        key = varint()
        if key & 7 == 0:
            value = varint()
            epoch = value if key >> 3 == 3 else epoch
        else:
            size = varint()
            writer = data[at : at + size].decode() if key >> 3 == 4 else writer
            at += size
    return epoch, writer


def calm(s, program: str, folder: Path, count: int) -> list[bytes]:
    """The bits of a server that nobody disturbs, whose checkpoints, which bits follow, are as many."""
    settings, port = folder / "calm.toml", free_port()
    settings.write_text(f'metrics_listen = ""\nretained_results = {RETAINED}\n')
    command = [program, "serve", "--config", str(settings), "--listen", f"127.0.0.1:{port}"]
    server = Program(command, port, folder / "calm.log")
    client = s.Client(f"127.0.0.1:{port}")
    with client.session(scene(s)) as session:
        found = [bits(session.move(ball=(0, 0, -depth(number))).result()) for number in range(1, count + 1)]
    client.close()
    server.kill()
    return found


def main() -> int:
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("program")
    arguments.add_argument("--haproxy", default="haproxy")
    arguments.add_argument("--faults", type=int, default=60)
    arguments.add_argument("--clients", type=int, default=12)
    arguments.add_argument("--seed", type=int, default=1)
    arguments.add_argument("--nats", type=int, default=1, help="servers of NATS")
    arguments.add_argument("--settle", type=float, default=0, help="seconds that a fault waits for every client, at most")
    arguments.add_argument("--pace", type=float, default=0.02, help="seconds between two results of a client")
    given = arguments.parse_args()
    os.environ["SIGNORINI_PROGRAM"] = given.program
    import signorini as s

    chance = random.Random(given.seed)
    with contextlib.ExitStack() as stack:
        folder = stack.enter_context(tempfile.TemporaryDirectory(prefix="signorini-fleet-"))
        fleet = Fleet(Path(folder), given.program, given.haproxy, given.nats)
        stack.callback(fleet.stop)
        time.sleep(1.5)
        gone = [one.log.read_text() for one in fleet.servers if one.process.poll() is not None]
        assert not gone, gone
        wait_behind(s, fleet.address)
        clients = [Client(s, fleet.address, f"client-{number}", given.pace) for number in range(given.clients)]
        for client in clients:
            client.start()
        # Who has no session yet has nothing that goes on elsewhere.
        end = time.monotonic() + 120
        while not all(one.results or one.error for one in clients) and time.monotonic() < end:
            time.sleep(0.2)
        assert all(one.results for one in clients), [f"{one.name_of}: {one.error!r}" for one in clients]
        kills: list[tuple[float, Client]] = []
        counts = dict.fromkeys(("kill", "stop", "cut", "nats"), 0)
        for number in range(given.faults):
            kind = list(counts)[number % len(counts)]
            counts[kind] += 1
            fault(fleet, kind, chance, kills, clients)
            settle(clients, given.settle)
            dead = [client for client in clients if client.error]
            print(f"{number + 1:4} {kind:5} results {sum(len(one.results) for one in clients)}", flush=True)
            if dead:
                break
        time.sleep(LEASE + 2)
        grown = True
        try:
            for records in asyncio.run(epochs(fleet.url)).values():
                order = [epoch for epoch, _ in records]
                writers = {epoch: {writer for one, writer in records if one == epoch} for epoch in order}
                grown &= order == sorted(order) and all(len(names) == 1 for names in writers.values())
        except ImportError:
            print("epochs not looked at: no nats-py here")
        for client in clients:
            client.end.set()
        for client in clients:
            client.join(120)
        spoilt = backups(fleet, Path(folder))
        failed = [f"{one.name_of}: {one.error!r}" if one.error else f"{one.name_of}: hangs" for one in clients if one.error or one.is_alive()]
        gaps = [one.name_of for one in clients if one.events != list(range(1, len(one.events) + 1))]
        longest = max(len(one.results) for one in clients)
        pauses = []
        for moment, client in kills:
            # What comes at once was on its way.
            after = [when - moment for when, _ in client.results if when > moment + 0.05]
            pauses.extend(after[:1])
        expected = calm(s, given.program, Path(folder), longest)
        differ = [one.name_of for one in clients if [bit for _, bit in one.results] != expected[: len(one.results)]]
    print(f"faults {counts}, results {sum(len(one.results) for one in clients)}, longest {longest}")
    print(f"failed {failed}; lost or doubled {gaps}; other bits {differ}; epochs grow {grown}")
    print(f"backups of {SERVERS} members: {spoilt or 'sound, restored'}")
    if pauses:
        median = statistics.median(pauses)
        print(f"pause after a kill: median {median:.2f} s, longest {max(pauses):.2f} s, of {len(pauses)}")
    return int(bool(failed or gaps or differ or spoilt or not grown))


if __name__ == "__main__":
    sys.exit(main())
