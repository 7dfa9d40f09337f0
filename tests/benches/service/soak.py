#!/usr/bin/env python3
"""A server for hours under all that clients do: does its memory stay where it was?

usage: soak.py --signorini PROGRAM [--log FILE] [--minutes 20] [--leak]

Six clients make sessions of elastic and of rubber blocks, press, cancel, cut streams and come back, delete sessions or leave
them to expire. Resident memory is read each second; the growth is the median of the last tenth over that of the second
tenth. With --leak the sessions that a client is through with stay, never expire and keep their results: what the check has to find.
With --log the server outlives this script when it is stopped: the same command goes on with it and counts the minutes
that are there already. 8 hours: --minutes 480 --log soak.log
"""
import os
import random
import signal
import statistics
import threading
import time

import grpc

import common
from common import MEGABYTE, Block, Client, Rejected, Server, row, session_pb

CLIENTS = 6
TRUE_ENDS = {1, 3}  # converged, cancelled


class Kept:
    """A server that another run of this script has left."""

    def __init__(self, pid, address):
        self.pid, self.address = pid, address

    def memory(self):
        return common.status_of(self.pid, "VmRSS")

    def lives(self):
        return self.memory() > 0

    def kill(self):
        os.kill(self.pid, signal.SIGKILL)


def server():
    """That of the log while it lives, else a new one."""
    for line in reversed(common.logged("server")):
        kept = Kept(line["pid"], line["address"])
        if kept.lives():
            return kept
    folder = common.given.log and f"{os.path.abspath(common.given.log)}.server"
    # Few results are kept, so that a session is full soon.
    made = Server(folder=folder, memory_budget_bytes=2000 * MEGABYTE, retained_results=80, maximum_sessions=5000)
    common.log("server", pid=made.process.pid, address=made.address)
    return made


class Worker(threading.Thread):
    """A client that does one thing after the other."""

    def __init__(self, address, number, end):
        super().__init__(daemon=True)
        self.address, self.end, self.random = address, end, random.Random(time.time_ns() + number)
        self.done, self.faults = {"solved": 0, "cancelled": 0, "cut": 0, "left": 0}, []

    def run(self):
        while time.monotonic() < self.end:
            client = Client(self.address)
            try:
                self.life(client)
            except (grpc.RpcError, Rejected) as error:
                self.faults.append(str(error)[:300])
                time.sleep(0.2)
            client.close()

    def life(self, client):
        """One session: some steps, then it is deleted or left."""
        rubber, leak = self.random.random() < 0.4, common.given.leak
        block = Block(self.random.choice((2, 3, 4)))
        client.upload(block)
        ttl = {"seconds": 86400} if leak else {"seconds": 5}
        request = session_pb.CreateSessionRequest(scene=block.scene(rubber=rubber), on_disconnect=1, ttl=ttl)
        name = client.sessions.CreateSession(request).session.name
        stream, sequence = client.solve(name), 0
        for _ in range(self.random.randrange(3, 12)):
            sequence += 1
            update = sequence, self.random.uniform(0.005, 0.06), self.random.randrange(1, 4)
            stream.step(*update)
            kind = self.random.random()
            if kind < 0.15:
                stream = self.cut(client, name, stream)
                # The server may not have got it; if it has, it answers it once more.
                stream.step(*update)
            elif kind < 0.3:
                self.cancel(client, name)
            self.read(stream, sequence)
        stream.call.cancel()
        if leak or self.random.random() < 0.3:
            self.done["left"] += 1
        else:
            client.delete(name)

    def read(self, stream, sequence):
        """Until the update is answered."""
        for result, _ in stream.results():
            if result.sequence == sequence and result.last:
                break
        if result.report.termination not in TRUE_ENDS:
            self.faults.append(f"ended by {result.report.termination}")
        self.done["solved"] += 1

    def cancel(self, client, name):
        time.sleep(self.random.uniform(0, 0.03))
        client.sessions.CancelStep(session_pb.CancelStepRequest(name=name))
        self.done["cancelled"] += 1

    def cut(self, client, name, stream):
        """Ends the stream in the middle and opens another, which gets all results once more."""
        time.sleep(self.random.uniform(0, 0.03))
        stream.call.cancel()
        self.done["cut"] += 1
        return common.attached(client, name, last_seen_event=0)


def watch(kept, end):
    """Memory each second, into the log too."""
    found = []
    while time.monotonic() < end and kept.lives():
        time.sleep(1)
        found.append(kept.memory())
        common.log("memory", bytes=found[-1])
    return found


def growth(memory):
    """Of the last tenth over the second one, and what it may be."""
    tenth = max(len(memory) // 10, 1)
    early, late = (statistics.median(part) for part in (memory[tenth : 2 * tenth + 1], memory[-tenth:]))
    return early, late, max(0.05 * early, 32 << 20)


def main():
    given = common.arguments(__doc__, minutes=20.0, leak=False)
    kept = server()
    memory = [line["bytes"] for line in common.logged("memory") if line["at"] > common.logged("server")[-1]["at"]] if given.log else []
    end = time.monotonic() + 60 * given.minutes - len(memory)
    workers = [Worker(kept.address, number, end) for number in range(CLIENTS)]
    for one in workers:
        one.start()
    memory += watch(kept, end)
    for one in workers:
        one.join(60)
    early, late, most = growth(memory)
    done = {key: sum(one.done[key] for one in workers) for key in workers[0].done}
    faults = [fault for one in workers for fault in one.faults]
    words = f"{early / MEGABYTE:.1f} to {late / MEGABYTE:.1f} MB in {len(memory)} s: {done}"
    row("growth" + (" with a leak, which has to be missed" if given.leak else ""), f"<= {most / MEGABYTE:.1f} MB", words, late - early <= most)
    row("calls that failed", "0", f"{len(faults)} {sorted(set(faults))[:3]}", not faults)
    row("server", "lives", "lives" if kept.lives() else "is gone", kept.lives())
    kept.kill()
    common.finish()


main()
