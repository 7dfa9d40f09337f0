"""Faults of what a server keeps: files and records that are not as they were written, results that a replay finds
otherwise, sessions of a fleet whose leases nobody renews.

A record of the journal is a message and the first 8 bytes of its SHA-256. It is found by a number that it holds; where
the seal is made anew the server believes it.
"""
import hashlib
import shutil
import struct
import subprocess
import time

import common
from common import FOLDER, Block, attached, free_port, session_pb
from trial import LeftOut, ask, fault, until_the_last

SEAL = 8
# Longest record that is looked for, and the bytes that it may begin with: keys of its first fields.
LONGEST, KEYS = 2000, b"\x08\x0a\x10\x12"


def records(data, number):
    """Where records that hold a double begin and end, their seals left out, and where the double is."""
    marker, at = struct.pack("<d", number), -1
    while (at := data.find(marker, at + 1)) >= 0:
        for start in range(at - 1, max(at - LONGEST, 0), -1):
            if data[start] not in KEYS:
                continue
            digest = hashlib.sha256(data[start : at + 8])
            for end in range(at + 8, min(at + LONGEST, len(data) - SEAL)):
                if digest.digest()[:SEAL] == data[end : end + SEAL]:
                    yield start, end, at
                digest.update(data[end : end + 1])


def spoil(path, number, believed):
    """Changes the last bit of a double in all records that hold it; how many there were."""
    data, count = bytearray(path.read_bytes()), 0
    for start, end, at in list(records(bytes(data), number)):
        data[at] ^= 1
        if believed:
            data[end : end + SEAL] = hashlib.sha256(data[start:end]).digest()[:SEAL]
        count += 1
    path.write_bytes(data)
    return count


def flip(path):
    """Changes a bit in the middle of a file."""
    data = bytearray(path.read_bytes())
    data[len(data) // 2] ^= 1
    path.write_bytes(data)


def looked_at(site, name):
    """Calls a session until it is back or refused."""
    client = site.client()
    request = session_pb.GetSessionRequest(name=name)
    while ask(client, "GetSession", request) is None:
        if client.describe(name).state != session_pb.SESSION_STATE_PREPARING:
            return
        time.sleep(0.05)


@fault("a mesh file is damaged", "SignoriniDamaged", "mesh")
def mesh(site):
    server = site.server(data=True)
    _, name, _ = site.pressed()
    site.begin()
    server.terminate()
    flip(next((server.folder / "data" / "meshes").iterdir()))
    server.start()
    looked_at(site, name)
    site.over.wait()


@fault("a record of a session is damaged", "SignoriniDamaged", "session")
def session(site):
    server = site.server(data=True)
    _, name, results = site.pressed()
    site.begin()
    server.terminate()
    if not spoil(server.folder / "data" / "journal.redb", results[1].report.strain_energy, False):
        raise AssertionError("the record is not found")
    server.start()
    looked_at(site, name)
    site.over.wait()


def imported(site):
    """A state that was exported and imported again; its name."""
    client, name, _ = site.pressed()
    answers = client.sessions.ExportState(session_pb.ExportStateRequest(name=name))
    data = b"".join(answer.data for answer in answers)
    digest = hashlib.sha256(data).hexdigest()
    slices = iter([session_pb.ImportStateRequest(digest=digest, offset=0, data=data)])
    return client, client.sessions.ImportState(slices).state


@fault("an imported state is damaged", "SignoriniDamaged", "state")
def state(site):
    server = site.server(data=True)
    client, kept = imported(site)
    site.begin()
    flip(server.folder / "data" / kept)
    ask(client, "CreateSession", session_pb.CreateSessionRequest(from_state=kept))
    site.over.wait()


@fault("the file of an imported state is lost", "SignoriniDamaged", "state")
def lost_state(site):
    server = site.server(data=True)
    _, kept = imported(site)
    site.begin()
    server.terminate()
    (server.folder / "data" / kept).unlink()
    server.start()
    site.over.wait()


@fault("a replay finds another result", "SignoriniReplayDifferences")
def replay(site):
    server = site.server(data=True)
    _, name, results = site.pressed()
    site.begin()
    server.terminate()
    if not spoil(server.folder / "data" / "journal.redb", results[1].report.strain_energy, True):
        raise AssertionError("the record is not found")
    server.start()
    looked_at(site, name)
    site.over.wait()


@fault("NATS of a fleet is gone", "SignoriniFleetSilent")
def silent(site):
    told = subprocess.run([common.given.signorini, "worker"], capture_output=True, text=True)
    if "--queue URL is missing" not in told.stderr or not shutil.which("nats-server"):
        raise LeftOut("a fleet needs nats-server and a program with the feature `fleet`")
    port, store = free_port(), FOLDER / f"nats-{site.number}"
    command = ["nats-server", "-js", "-a", "127.0.0.1", "-p", str(port), "-sd", store]
    with open(FOLDER / f"nats-{site.number}.log", "w") as log:
        nats = subprocess.Popen(command, stdout=log, stderr=log)
    try:
        time.sleep(1.0)
        fleet = {"fleet_nats": f"nats://127.0.0.1:{port}", "fleet_store": str(FOLDER / f"shared-{site.number}")}
        site.server(data=True, fleet_lease_seconds=2, **fleet)
        client, name = site.session(Block(1))
        stream = attached(client, name)
        stream.step(1, 0.01)
        list(until_the_last(stream))
        site.begin()
        nats.terminate()
        site.over.wait()
    finally:
        nats.kill()
        nats.wait()
