"""Bad clients, each as it was seen to hold up a server: functions that go on until they are told to end.

Each gets the address, its token and the event that ends it, and runs in a process of its own at the lowest priority,
so that what others feel of it is what it does to the server.
"""
import itertools
import os
import threading
import time
from concurrent.futures import ThreadPoolExecutor

import grpc

import raw
from common import IDENTITY, Block, Client, Rejected, mesh_pb, scene_pb, session_pb


def number(message, field):
    return message.DESCRIPTOR.fields_by_name[field].number


def varint(value):
    """As the wire has it."""
    out = bytearray()
    while value >= 128:
        out.append(value & 127 | 128)
        value >>= 7
    return bytes(out) + bytes([value])


def message(field, body):
    """A sub-message of that number."""
    return varint(field << 3 | 2) + varint(len(body)) + body


class Ended:
    """A flag between processes. An event of `multiprocessing` hangs in `set` once a process has ended that waited for it."""

    def __init__(self, processes):
        self.flag = processes.RawValue("b", 0)

    def set(self):
        self.flag.value = 1

    def is_set(self):
        return bool(self.flag.value)

    def wait(self, seconds=float("inf")):
        until = time.monotonic() + seconds
        while not self.is_set() and time.monotonic() < until:
            time.sleep(0.005)
        return self.is_set()


def writers(address, token, ended):
    """Two that ask for every field and never read."""
    client = Client(address, token)
    block = Block(8)
    client.upload(block)
    fields = [f for f in scene_pb.FieldName.values() if f]
    held = []
    while not ended.wait(1):
        try:
            if len(held) < 2:
                stream = client.solve(client.create(block.scene()), fields=fields, max_unread_bytes=1 << 30)
                stream.step(1, 0.02, 100_000)
                held.append(stream)
        except grpc.RpcError:
            pass


def bombs(address, token, ended):
    """Forty requests at once, 2.7 MiB of empty sub-messages each, of one request identifier."""
    scene = message(number(scene_pb.Scene, "obstacles"), b"") * 1_400_000
    request = session_pb.CreateSessionRequest
    body = message(number(request, "scene"), scene) + message(number(request, "request_id"), b"bomb")

    def one(client):
        while not ended.is_set():
            try:
                client.raw("/signorini.v1.SessionService/CreateSession", body, timeout=60)
            except grpc.RpcError:
                ended.wait(0.2)

    crowd([Client(address, token) for _ in range(40)], one)


def uploads(address, token, ended):
    """Four headers of meshes that take most of the budget, then eight bytes every five seconds."""

    def messages():
        header = mesh_pb.MeshHeader(cell_kind=mesh_pb.CELL_KIND_TETRAHEDRON, vertex_count=900_000, cell_count=2_500_000)
        yield mesh_pb.UploadMeshRequest(header=header)
        for offset in itertools.count():
            chunk = mesh_pb.MeshChunk(array=mesh_pb.MESH_ARRAY_COORDINATES, offset_elements=offset, data=bytes(8))
            yield mesh_pb.UploadMeshRequest(chunk=chunk)
            if ended.wait(5):
                return

    def one(client):
        while not ended.is_set():
            try:
                client.meshes.UploadMesh(messages(), metadata=client.metadata)
            except grpc.RpcError:
                ended.wait(0.5)

    crowd([Client(address, token) for _ in range(4)], one)


def plans(address, token, ended):
    """Sixty-four plans at once of a block of 83 thousand cells."""
    block = Block(24)
    first = Client(address, token)
    patient(first.upload, ended)(block)
    request = session_pb.CreateSessionRequest(scene=block.scene(), validate_only=True)

    def one(client):
        while not ended.is_set():
            try:
                client.sessions.CreateSession(request, metadata=client.metadata, timeout=60)
            except grpc.RpcError as error:
                if error.code() is grpc.StatusCode.NOT_FOUND:
                    patient(client.upload, ended)(block)
                ended.wait(0.1)

    crowd([Client(address, token) for _ in range(64)], one)


def stuck(address, token, ended):
    """Three scenes that do not converge: pressed through at a tolerance beyond the digits, over and over."""
    block = Block(12)
    patient(Client(address, token).upload, ended)(block)

    def one(client):
        while not ended.is_set():
            try:
                name = client.create(block.scene(rubber=True, tolerance=1e-14))
                stream = client.solve(name)
                stream.step(1, 0.7, 1000)
                for _ in stream.results():
                    if ended.is_set():
                        return
            except (grpc.RpcError, Rejected):
                ended.wait(0.5)

    crowd([Client(address, token) for _ in range(3)], one)


def connections(address, token, ended):
    """Twelve connections of one client, each with a session that always has work."""
    block = Block(2)
    patient(Client(address, token).upload, ended)(block)

    def one(client):
        while not ended.is_set():
            try:
                stream = client.solve(client.create(block.scene()))
                for sequence in range(1, 9):
                    stream.step(sequence, 0.01 + 0.001 * (sequence % 9))
                for result, _ in stream.results():
                    stream.step(result.sequence + 8, 0.01 + 0.001 * (result.sequence % 9))
                    if ended.is_set():
                        return
            except (grpc.RpcError, Rejected):
                ended.wait(0.5)

    crowd([Client(address, token) for _ in range(12)], one)


def watchers(address, token, ended):
    """Three hundred thousand watches of health, which need no token, on 74 connections."""
    held = [raw.Connection(address, "/grpc.health.v1.Health/Watch", 4096) for _ in range(74)]
    for _ in range(4096 // 64):
        for one in held:
            if not ended.is_set():
                one.call(64)
    ended.wait()
    tell("watches of health", held)


def refused(address, token, ended):
    """Calls without a token on four connections, as fast as they are refused."""

    def one(connection):
        while not ended.is_set() and not connection.gone:
            connection.call(16)

    held = [raw.Connection(address, "/signorini.v1.SessionService/GetSession", 256) for _ in range(4)]
    crowd(held, one)
    tell("calls without a token", held)


def garbage(address, token, ended):
    """Uploads of a gigabyte in all: messages of noise, and meshes whose arrays are noise."""
    noise = os.urandom(1 << 20)
    header = mesh_pb.MeshHeader(cell_kind=mesh_pb.CELL_KIND_TETRAHEDRON, vertex_count=300_000, cell_count=1_500_000)
    sent = itertools.count()

    def bare():
        for _ in range(16):
            next(sent)
            yield noise

    def meshes():
        yield mesh_pb.UploadMeshRequest(header=header)
        for array, size in ((mesh_pb.MESH_ARRAY_COORDINATES, 7_200_000), (mesh_pb.MESH_ARRAY_CELLS, 24_000_000)):
            for start in range(0, size, 1 << 20):
                next(sent)
                offset = start // (8 if array == mesh_pb.MESH_ARRAY_COORDINATES else 4)
                chunk = mesh_pb.MeshChunk(array=array, offset_elements=offset, data=noise[: size - start])
                yield mesh_pb.UploadMeshRequest(chunk=chunk)

    def one(client):
        call = client.channel.stream_unary("/signorini.v1.MeshService/UploadMesh", **IDENTITY)
        while not ended.is_set() and next(sent) < 1024:
            for upload in (lambda: call(bare(), metadata=client.metadata), lambda: client.meshes.UploadMesh(meshes(), metadata=client.metadata)):
                try:
                    upload()
                except grpc.RpcError:
                    pass

    crowd([Client(address, token) for _ in range(4)], one)
    print(f"attackers: {next(sent)} MiB of noise were sent", flush=True)


def tell(what, held):
    """How many of the calls by hand were begun, and how many have ended."""
    begun, over = (sum(getattr(one, key) for one in held) for key in ("begun", "ended"))
    print(f"attackers: {begun} {what}, {over} of them ended, {sum(one.gone for one in held)} of {len(held)} connections gone", flush=True)
    for one in held:
        one.close()


def patient(call, ended):
    """Tries a call until it is taken."""

    def tried(*arguments):
        while not ended.is_set():
            try:
                return call(*arguments)
            except grpc.RpcError:
                ended.wait(1)

    return tried


def crowd(clients, work):
    """The same work by all clients at once, until each returns."""
    threads = [threading.Thread(target=work, args=(client,), daemon=True) for client in clients]
    for one in threads:
        one.start()
    for one in threads:
        one.join()


ALL = {one.__name__: one for one in (writers, bombs, uploads, plans, stuck, connections, watchers, refused, garbage)}


def run(name, address, token, here, ended):
    """One of them in this process; it ends with it, whatever hangs."""
    here.release()
    os.nice(19)
    watch = threading.Thread(target=lambda: (ended.wait(), time.sleep(2), os._exit(0)), daemon=True)
    watch.start()
    ALL[name](address, token, ended)
