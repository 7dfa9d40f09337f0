"""What all scripts of this folder share: arguments, a server of its own, a log that a later run goes on with, rows.

A server is a process of the program under test on a Unix socket; who may call it is in a token file, one name for
each client, so that a client here is what it is on a real server. Stubs are generated from `proto/` into a temporary
folder. Times are those of this process's clock.
"""
import argparse
import atexit
import hashlib
import json
import os
import random
import shutil
import signal
import socket
import statistics
import struct
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

import grpc
import grpc_tools
import numpy as np
from grpc_tools import protoc

PROTO = Path(__file__).resolve().parents[3] / "proto"
MEGABYTE = 1_000_000
given = None
rows = []
temporary = tempfile.TemporaryDirectory(prefix="signorini-service-")
FOLDER = Path(temporary.name)


def stubs():
    """Generates the stubs and makes them importable; a process that this one starts finds them there."""
    if found := os.environ.get("SIGNORINI_STUBS"):
        sys.path.insert(0, found)
        return
    out = FOLDER / "stubs"
    out.mkdir()
    os.environ["SIGNORINI_STUBS"] = str(out)
    own = Path(grpc_tools.__file__).parent / "_proto"
    files = sorted(str(path.relative_to(PROTO)) for path in (PROTO / "signorini/v1").glob("*.proto"))
    arguments = ["protoc", f"-I{PROTO}", f"-I{own}", f"--python_out={out}", f"--grpc_python_out={out}"]
    if protoc.main([*arguments, *files, "google/rpc/status.proto"]) != 0:
        sys.exit("protoc failed")
    sys.path.insert(0, str(out))


stubs()
from signorini.v1 import array_pb2, mesh_service_pb2 as mesh_pb, mesh_service_pb2_grpc as mesh_grpc  # noqa: E402, F401
from signorini.v1 import report_pb2, scene_pb2 as scene_pb, session_service_pb2 as session_pb  # noqa: E402, F401
from signorini.v1 import session_service_pb2_grpc as session_grpc, step_pb2 as step_pb  # noqa: E402

IDENTITY = {"request_serializer": bytes, "response_deserializer": bytes}


def arguments(doc, **more):
    """Reads the command line; `more` are options of one script by name and default."""
    global given
    parser = argparse.ArgumentParser(description=doc, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--signorini", default=os.environ.get("SIGNORINI", "signorini"), help="program, or $SIGNORINI")
    parser.add_argument("--log", help="file of JSON lines: one a finished round, so that a run that was stopped goes on")
    for name, default in more.items():
        kind = {"action": "store_true"} if default is False else {"default": default, "type": type(default)}
        parser.add_argument("--" + name, **kind)
    given = parser.parse_args()
    # Ended by a signal, too, no server stays behind.
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))
    return given


def free_port():
    """A port of loopback that nobody has just now."""
    with socket.socket() as found:
        found.bind(("127.0.0.1", 0))
        return found.getsockname()[1]


def row(what, asked, measured, met):
    """One line of the table; `met` None where nothing is asked."""
    verdict = {True: "met", False: "MISSED", None: "-"}[None if met is None else bool(met)]
    rows.append(verdict)
    print(f"{Path(sys.argv[0]).stem} | {what} | {asked} | {measured} | {verdict}", flush=True)


def finish():
    """Exit code 1 where a figure is missed."""
    sys.exit("MISSED" in rows)


def logged(kind):
    """Rounds of that kind that an earlier run has finished."""
    if not given.log or not Path(given.log).exists():
        return []
    lines = [json.loads(line) for line in Path(given.log).read_text().splitlines() if line.endswith("}")]
    return [line for line in lines if line["kind"] == kind]


def log(kind, **values):
    """Keeps a finished round."""
    if given.log:
        with open(given.log, "a") as file:
            file.write(json.dumps({"kind": kind, "at": time.time(), **values}) + "\n")


def percentile(values, part):
    """That part of the values is no larger; infinite for none."""
    ordered = sorted(values)
    return ordered[min(int(part * len(ordered)), len(ordered) - 1)] if ordered else float("inf")


def milliseconds(values):
    """A few words on times in seconds."""
    at = [1e3 * percentile(values, part) for part in (0.5, 0.99, 1.0)]
    return f"p50 {at[0]:.1f}, p99 {at[1]:.1f}, max {at[2]:.1f} ms of {len(values)}"


def control_group(megabytes):
    """What a command is put behind to run in a control group of so much memory; none where nobody may make one."""
    scope = ["systemd-run", "--scope", "--quiet", "-p", f"MemoryMax={megabytes}M", "-p", "MemorySwapMax=0"]
    if shutil.which(scope[0]) and subprocess.run([*scope, "true"], capture_output=True).returncode == 0:
        return scope
    top = Path("/sys/fs/cgroup")
    # Version 1 where memory has a tree of its own.
    own = (top / "memory", "memory.limit_in_bytes")
    root, limit = own if own[0].is_dir() else (top, "memory.max")
    folder = root / f"signorini-{os.getpid()}-{len(rows)}"
    try:
        folder.mkdir()
        atexit.register(leave, folder)
        (folder / limit).write_text(str(megabytes * MEGABYTE))
    except OSError:
        return None
    return ["sh", "-c", f'echo $$ > {folder}/cgroup.procs && exec "$@"', "sh"]


def leave(folder):
    """Removes a control group whose processes are being ended."""
    for _ in range(100):
        try:
            return folder.rmdir()
        except OSError:
            time.sleep(0.05)


def status_of(pid, key):
    """Bytes in a line of a process's status."""
    try:
        lines = Path(f"/proc/{pid}/status").read_text().splitlines()
    except OSError:
        return 0
    return next((1024 * int(line.split()[1]) for line in lines if line.startswith(key + ":")), 0)


class Server:
    """A server process with settings, tokens for `clients` and, if asked, a data folder: its own, or that of a path."""

    def __init__(self, clients=(), data=False, prefix=(), name="server", folder=None, **settings):
        self.folder = Path(folder or FOLDER / name)
        self.folder.mkdir(exist_ok=True)
        self.address = f"unix:{self.folder}/socket"
        self.prefix, self.process = list(prefix), None
        self.tokens = {client: self.token(client) for client in clients}
        if clients:
            settings["tokens"] = str(self.folder / "tokens.toml")
        if data:
            settings["data"] = str(self.folder / "data" if data is True else data)
        settings = {"metrics_listen": "", "log_format": "text", **settings}
        text = "".join(f"{key} = {json.dumps(value)}\n" for key, value in settings.items())
        (self.folder / "settings.toml").write_text(text)
        self.start()
        if not folder:
            atexit.register(self.kill)

    def token(self, client):
        """A new token of a client that may solve."""
        command = [given.signorini, "token", "add", client, "--role", "solve", "--tokens", self.folder / "tokens.toml"]
        words = subprocess.run(command, check=True, capture_output=True, text=True).stdout.split()
        return next(word for word in words if word.startswith("signorini_"))

    def start(self):
        """Starts, also again; returns when it answers."""
        command = [given.signorini, "serve", "--listen", self.address, "--config", self.folder / "settings.toml"]
        with open(self.folder / "log", "a") as file:
            self.process = subprocess.Popen([*self.prefix, *command], stderr=file, stdout=file, process_group=0)
        end = time.monotonic() + 30
        while not self.answers():
            if self.process.poll() is not None or time.monotonic() > end:
                sys.exit(f"the server does not start: {self.said()[-600:]}")
            time.sleep(0.002)

    def answers(self):
        """Whether health does."""
        with channel(self.address) as one:
            try:
                return bool(health(one)(b"", timeout=2))
            except grpc.RpcError:
                return False

    def said(self):
        return (self.folder / "log").read_text()

    def memory(self, key="VmRSS"):
        """Resident memory in bytes, or another line of its status; 0 of a process that is gone."""
        return status_of(self.process.pid, key)

    def processor(self):
        """Seconds of processor time that it has had."""
        fields = Path(f"/proc/{self.process.pid}/stat").read_text().rpartition(")")[2].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")

    def lives(self):
        return self.process.poll() is None

    def kill(self):
        self.process.kill()
        self.process.wait()

    def terminate(self):
        """Whether it ends well, in half a minute."""
        self.process.send_signal(signal.SIGTERM)
        return self.process.wait(40) == 0


def channel(address):
    """A connection of its own."""
    options = [("grpc.default_authority", "localhost"), ("grpc.use_local_subchannel_pool", 1)]
    options += [("grpc.max_receive_message_length", 8 << 20), ("grpc.initial_reconnect_backoff_ms", 100)]
    options += [("grpc.min_reconnect_backoff_ms", 5000), ("grpc.max_reconnect_backoff_ms", 500)]
    return grpc.insecure_channel(address, options=options)


def health(one):
    return one.unary_unary("/grpc.health.v1.Health/Check", **IDENTITY)


class Rejected(Exception):
    """An update was."""


class Client:
    """One name on one connection."""

    def __init__(self, address, token=None):
        self.channel = channel(address)
        self.metadata = [("authorization", f"Bearer {token}")] if token else []
        self.meshes = mesh_grpc.MeshServiceStub(self.channel)
        self.sessions = session_grpc.SessionServiceStub(self.channel)

    def upload(self, block):
        return self.meshes.UploadMesh(iter(block.messages()), metadata=self.metadata).mesh.name

    def create(self, scene, **more):
        request = session_pb.CreateSessionRequest(scene=scene, **more)
        return self.sessions.CreateSession(request, metadata=self.metadata, timeout=60).session.name

    def delete(self, name):
        self.sessions.DeleteSession(session_pb.DeleteSessionRequest(name=name), metadata=self.metadata)

    def describe(self, name):
        return self.sessions.GetSession(session_pb.GetSessionRequest(name=name), metadata=self.metadata).session

    def solve(self, name, **more):
        return Stream(self, session_pb.SolveOpen(session=name, **more))

    def raw(self, method, body, **more):
        """A call whose message is given in bytes."""
        call = self.channel.unary_unary(method, **IDENTITY)
        return call(body, metadata=self.metadata, **more)

    def close(self):
        self.channel.close()


def attached(client, name, **more):
    """A stream on a session whose last one the server perhaps still holds."""
    while True:
        stream = client.solve(name, **more)
        try:
            next(stream.call)
            return stream
        except grpc.RpcError as error:
            if error.code() is not grpc.StatusCode.FAILED_PRECONDITION and error.code() is not grpc.StatusCode.ABORTED:
                raise
            time.sleep(0.01)


class Stream:
    """One open `Solve` stream."""

    def __init__(self, client, opening):
        self.waiting, self.ready, self.closed = [session_pb.SolveRequest(open=opening)], threading.Condition(), False
        self.call = client.sessions.Solve(self.requests(), metadata=client.metadata)

    def requests(self):
        while True:
            with self.ready:
                self.ready.wait_for(lambda: self.waiting or self.closed)
                if not self.waiting:
                    return
                message = self.waiting.pop(0)
            yield message

    def send(self, **message):
        with self.ready:
            self.waiting.append(session_pb.SolveRequest(**message))
            self.ready.notify()

    def step(self, sequence, depth, increments=1):
        update = session_pb.LoadStepUpdate(sequence=sequence, step=press(depth, increments))
        self.send(load_step=update)

    def close(self):
        """No update follows."""
        with self.ready:
            self.closed = True
            self.ready.notify()

    def results(self):
        """Results with the bytes of their fields."""
        finished, data = None, b""
        for answer in self.call:
            kind = answer.WhichOneof("message")
            if kind == "update_rejected":
                raise Rejected(answer.update_rejected.status.message)
            if kind == "step_finished":
                finished, data = answer.step_finished, b""
                if not finished.fields:
                    yield finished, data
            elif kind == "field":
                data += answer.field.data
                if answer.field.last and answer.field.field == finished.fields[-1]:
                    yield finished, data


def press(depth, increments=1):
    target = step_pb.ObstacleTarget(name="ball", translation=[0.0, 0.0, -depth])
    return step_pb.LoadStep(increments=increments, obstacles=[target])


class Block:
    """A unit cube of n^3 boxes, six tetrahedra each, held at its bottom under a ball that touches its top."""

    def __init__(self, n):
        ticks = np.arange(n + 1)
        z, y, x = np.meshgrid(ticks, ticks, ticks, indexing="ij")
        self.coordinates = (np.stack([x, y, z], -1).reshape(-1, 3) / n).astype("<f8")
        k, j, i = (a.ravel() for a in np.meshgrid(ticks[:-1], ticks[:-1], ticks[:-1], indexing="ij"))
        cells, bottom, top = [], [], []
        for number, path in enumerate(((0, 1, 2), (1, 2, 0), (2, 0, 1), (0, 2, 1), (2, 1, 0), (1, 0, 2))):
            at, cell, levels = [i, j, k], [], []
            for axis in (None, *path):
                if axis is not None:
                    at[axis] = at[axis] + 1
                cell.append(at[0] + (n + 1) * (at[1] + (n + 1) * at[2]))
                levels.append(at[2] - k)
            for level, side, edge in ((0, bottom, k == 0), (1, top, k == n - 1)):
                chosen = [c for c, l in zip(cell, levels) if l[0] == level]
                if len(chosen) == 3:
                    side.append(np.stack(chosen, 1)[edge])
            # Odd permutations of the axes turn a cell inside out.
            order = (0, 1, 3, 2) if number >= 3 else (0, 1, 2, 3)
            cells.append(np.stack([cell[c] for c in order], 1))
        self.cells = np.concatenate(cells).astype("<i4")
        self.facets = np.concatenate(bottom + top).astype("<i4")
        count = sum(len(one) for one in bottom)
        of = lambda a, b: np.arange(a, b, dtype="<i4")  # noqa: E731
        self.groups = [("body", 3, of(0, len(self.cells))), ("bottom", 2, of(0, count)), ("top", 2, of(count, len(self.facets)))]

    def digest(self):
        """SHA-256 of the canonical bytes that mesh_service.proto defines."""
        digest = hashlib.sha256(b"signorini-mesh-v1\n")
        counts = len(self.coordinates), len(self.cells), len(self.facets), len(self.groups)
        digest.update(struct.pack("<B4Q", 4, *counts))
        for array in (self.coordinates, self.cells, self.facets):
            digest.update(array.tobytes())
        for name, dimension, members in self.groups:
            digest.update(struct.pack("<Q", len(name)) + name.encode() + struct.pack("<BQ", dimension, len(members)))
            digest.update(members.tobytes())
        return digest.hexdigest()

    def messages(self):
        """The messages of an upload."""
        kinds = {2: mesh_pb.GROUP_KIND_FACETS, 3: mesh_pb.GROUP_KIND_CELLS}
        groups = [mesh_pb.MeshGroup(name=n, kind=kinds[d], member_count=len(m)) for n, d, m in self.groups]
        counts = dict(zip(("vertex_count", "cell_count", "facet_count"), map(len, (self.coordinates, self.cells, self.facets))))
        header = mesh_pb.MeshHeader(digest=self.digest(), cell_kind=mesh_pb.CELL_KIND_TETRAHEDRON, groups=groups, **counts)
        yield mesh_pb.UploadMeshRequest(header=header)
        arrays = [(1, 0, self.coordinates), (2, 0, self.cells), (3, 0, self.facets)]
        for array, index, values in arrays + [(4, i, members) for i, (_, _, members) in enumerate(self.groups)]:
            data, size = values.tobytes(), values.itemsize
            for start in range(0, len(data), 1 << 20):
                chunk = mesh_pb.MeshChunk(array=array, group_index=index, offset_elements=start // size, data=data[start : start + (1 << 20)])
                yield mesh_pb.UploadMeshRequest(chunk=chunk)

    def scene(self, rubber=False, tolerance=1e-8):
        """Linear elastic and incompressible, or a rubber of the same stiffness."""
        laws = {"linear_elastic": scene_pb.LinearElastic(shear_modulus=1.0, poisson_ratio=0.5)}
        if rubber:
            laws = {"neo_hookean": scene_pb.NeoHookean(shear_modulus=1.0)}
        ball = scene_pb.Shape(sphere=scene_pb.Sphere(centre=[0.5, 0.5, 11.0], radius=10.0))
        held = step_pb.Components(x=0.0, y=0.0, z=0.0)
        return scene_pb.Scene(
            name="block",
            mesh=f"meshes/{self.digest()}",
            materials=[scene_pb.Material(group="body", **laws)],
            supports=[scene_pb.Support(name="base", on=["bottom"], displacement=held)],
            obstacles=[scene_pb.Obstacle(name="ball", on=["top"], shape=ball)],
            solver=scene_pb.SolverOptions(tolerance=tolerance),
        )
