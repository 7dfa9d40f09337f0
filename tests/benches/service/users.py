"""Two users of the machine beside each other, on every way to a server: IPv4, IPv6, IPv4 from a socket of IPv6 (as
gRPC's C core opens them), and the Unix socket. Only as root, with `setpriv`.

Asked on each way: one that has work waiting on twelve connections leaves the other, with two, a share of 40 % at least;
limits of connections, calls and sessions hold for a user however many connections it takes, and for each user alone.

    python users.py --seconds 10 --first 1001 --second 1002
"""
import json
import os
import socket
import subprocess
import sys
import threading
import time
from pathlib import Path

import grpc

import common
from common import Block, Client, Rejected, Server, health, row, session_pb

CONNECTIONS, CALLS, SESSIONS = 8, 5, 3
LIMITS = {
    "maximum_client_connections": CONNECTIONS,
    "maximum_client_calls_per_second": CALLS,
    "maximum_client_sessions": SESSIONS,
}
WAYS = {
    "IPv4": ("127.0.0.1:{}", "ipv4:127.0.0.1:{}"),
    "IPv6": ("[::1]:{}", "ipv6:[::1]:{}"),
    "IPv4 in IPv6": ("127.0.0.1:{}", "ipv6:[::ffff:127.0.0.1]:{}"),
    "Unix socket": ("unix:{}", "unix:{}"),
}


class Reached(Server):
    """A server that every user of the machine reaches by one way."""

    def __init__(self, way, name, **settings):
        self.listen, self.target = WAYS[way]
        super().__init__(name=name, **settings)
        self.folder.chmod(0o755)

    def start(self):
        place = self.folder / "socket"
        if "unix" not in self.listen:
            family = socket.AF_INET6 if self.listen.startswith("[") else socket.AF_INET
            with socket.create_server(("::1" if family == socket.AF_INET6 else "127.0.0.1", 0), family=family) as one:
                place = one.getsockname()[1]
        # What listens first and what clients reach.
        self.address = self.listen.format(place)
        super().start()
        self.address = self.target.format(place)
        if "unix" in self.listen:
            place.chmod(0o666)


def as_user(number, *words):
    """Starts a part of this script as that user."""
    user = ["setpriv", "--reuid", str(number), "--regid", str(number), "--clear-groups"]
    command = [*user, sys.executable, __file__, "--signorini", common.given.signorini, "--part", json.dumps(words)]
    return subprocess.Popen(command, stdout=subprocess.PIPE, text=True)


def said(process):
    """What a part has found out."""
    out, _ = process.communicate(timeout=120)
    if process.returncode != 0:
        raise RuntimeError(f"a part ended with {process.returncode}")
    return json.loads(out.splitlines()[-1])


def busy(address, connections, seconds):
    """Updates that sessions which always have work get done in a time, which begins when all have some."""
    block, counted, ended = Block(3), [0] * connections, threading.Event()
    Client(address).upload(block)
    ready = threading.Barrier(connections + 1)

    def drive(number):
        client = Client(address)
        stream = client.solve(client.create(block.scene()))
        for sequence in range(1, 9):
            stream.step(sequence, 0.01 + 0.001 * (sequence % 9))
        for result, _ in stream.results():
            stream.step(result.sequence + 8, 0.01 + 0.001 * (result.sequence % 9))
            if result.sequence == 1:
                ready.wait()
            counted[number] += 1
            if ended.is_set():
                stream.call.cancel()
                return

    for number in range(connections):
        threading.Thread(target=drive, args=(number,), daemon=True).start()
    ready.wait()
    # Both users are at work before either counts.
    time.sleep(2)
    before, begun = sum(counted), time.monotonic()
    time.sleep(seconds)
    rate = (sum(counted) - before) / (time.monotonic() - begun)
    # The other one counts a little longer.
    time.sleep(2)
    ended.set()
    return rate


def connections(address, count, seconds):
    """How many of so many connections answer at one time, and are held for that time."""
    held = [common.channel(address) for _ in range(count)]
    answered = 0
    for one in held:
        try:
            health(one)(b"", timeout=3)
            answered += 1
        except grpc.RpcError:
            pass
    print(answered, flush=True)
    time.sleep(seconds)
    return answered


def calls(address, count):
    """How many of so many calls are served, each on a connection of its own, and in which time."""
    begun, served = time.monotonic(), 0
    for _ in range(count):
        client = Client(address)
        try:
            client.sessions.ListSessions(session_pb.ListSessionsRequest(), timeout=5)
            served += 1
        except grpc.RpcError as error:
            if "CALL_RATE" not in str(error.trailing_metadata()):
                raise
        client.close()
    return served, time.monotonic() - begun


def sessions(address, count):
    """How many sessions of so many there may be, each made on a connection of its own; no faster than calls may come."""
    block, made = Block(1), 0
    first = Client(address)
    first.upload(block)
    for _ in range(count):
        time.sleep(2 / CALLS)
        client = Client(address)
        try:
            client.create(block.scene())
            made += 1
        except grpc.RpcError as error:
            if "SESSION_LIMIT" not in str(error.trailing_metadata()):
                raise
        client.close()
    return made


def part(words):
    """A part of this script, as the user that it is run as."""
    name, *values = words
    parts = {"busy": busy, "connections": connections, "calls": calls, "sessions": sessions}
    print(json.dumps(parts[name](*values)), flush=True)
    # Threads of streams may still wait.
    os._exit(0)


def shares(way, given):
    """The part of the second user beside the first with six times as many connections."""
    server = Reached(way, f"shares-{len(common.rows)}", solver_slots=1, short_slots=0)
    users = [as_user(given.first, "busy", server.address, 12, given.seconds), as_user(given.second, "busy", server.address, 2, given.seconds)]
    first, second = map(said, users)
    part = second / (first + second)
    row(f"{way}: share of 2 connections beside 12 of another user", "40 to 60 %", f"{100 * part:.0f} % of {first + second:.0f}/s", 0.4 <= part <= 0.6)
    server.kill()


def limits(way, given):
    """Connections, calls and sessions of each user."""
    server = Reached(way, f"limits-{len(common.rows)}", **LIMITS)
    first = as_user(given.first, "connections", server.address, 40, 3.0)
    # When they are open, another user's are none of theirs.
    held = int(first.stdout.readline())
    other = said(as_user(given.second, "connections", server.address, 4, 0.0))
    first.wait()
    row(f"{way}: connections of one user, of 40", f"{CONNECTIONS}", held, held == CONNECTIONS)
    row(f"{way}: connections of another beside", "4", other, other == 4)
    time.sleep(1)
    both = [as_user(user, "calls", server.address, 60) for user in (given.first, given.second)]
    for user, (served, seconds) in zip((given.first, given.second), map(said, both)):
        # Twice as many at once, and as many in each second.
        most = 2 * CALLS + CALLS * seconds + 1
        row(f"{way}: calls of user {user} served, of 60 on new connections in {seconds:.1f} s", f"<= {most:.0f}", served, served <= most)
    time.sleep(3)
    for user in (given.first, given.second):
        made = said(as_user(user, "sessions", server.address, SESSIONS + 3))
        row(f"{way}: sessions of user {user}, of {SESSIONS + 3}", SESSIONS, made, made == SESSIONS)
    server.kill()


def main():
    given = common.arguments(__doc__, seconds=10.0, first=1001, second=1002, part="")
    if given.part:
        return part(json.loads(given.part))
    if os.geteuid() != 0:
        sys.exit("only root may be two users")
    # They read the stubs.
    common.FOLDER.chmod(0o755)
    for way in WAYS:
        shares(way, given)
        limits(way, given)
    common.finish()


if __name__ == "__main__":
    main()
