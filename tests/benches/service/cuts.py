#!/usr/bin/env python3
"""Connections that break at random moments, and the server killed beneath them: every client ends with all its results.

usage: cuts.py --signorini PROGRAM [--log FILE] [--rounds 1] [--clients 10] [--cuts 200] [--kills 20]

Each client goes through a proxy of its own that resets its connections; it reconnects and goes on from the last result
that it has whole. Its results, fields included, have to be gapless, each the same however often it comes, and those of a
session that nobody disturbed, bit by bit. Rounds in the log are not run again.
"""
import random
import socket
import struct
import threading
import time

import grpc

import common
from common import Block, Client, Server, row, scene_pb

WINDOW = 8
SETTINGS = {"maximum_in_flight": 16, "retained_results": 60}
# What differs from run to run: times, memory, what was found prepared.
OWN = ("seconds", "memory_bytes", "reused", "factorisations", "eigenvalue_applications", "compliance_columns")
RESET = struct.pack("ii", 1, 0)


class Proxy:
    """Forwards a port to the socket of a server, until it resets all connections."""

    def __init__(self, path):
        self.path, self.open, self.lock = path, set(), threading.Lock()
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.address = "127.0.0.1:%d" % self.listener.getsockname()[1]
        threading.Thread(target=self.accept, daemon=True).start()

    def accept(self):
        while True:
            near, far = self.listener.accept()[0], socket.socket(socket.AF_UNIX)
            try:
                far.connect(self.path)
            except OSError:
                near.close()
                continue
            near.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, RESET)
            with self.lock:
                self.open |= {near, far}
            for source, target in ((near, far), (far, near)):
                threading.Thread(target=self.pump, args=(source, target), daemon=True).start()

    def pump(self, source, target):
        try:
            while data := source.recv(1 << 14):
                target.sendall(data)
        except OSError:
            pass
        self.close({source, target})

    def close(self, sockets):
        with self.lock:
            sockets = sockets & self.open
            self.open -= sockets
        for one in sockets:
            try:
                # Wakes the reader in its thread, without which the close below would wait for it; that
                # resets the connection, because it may not linger.
                one.shutdown(socket.SHUT_RD)
                one.close()
            except OSError:
                pass

    def cut(self):
        self.close(set(self.open))


def step(sequence):
    """To and fro, every seventh in parts: depth and increments."""
    return 0.01 + 0.002 * ((sequence * 7) % 11), 3 if sequence % 7 == 0 else 1


def bare(result):
    for field in OWN:
        result.report.ClearField(field)
    return result.SerializeToString(deterministic=True)


class Worker(threading.Thread):
    """A client that sends steps a window at a time and keeps what it is answered."""

    def __init__(self, address, name, goal):
        super().__init__(daemon=True)
        self.address, self.name, self.goal = address, name, goal
        self.kept, self.next, self.repeats, self.breaks, self.fault = [], 1, 0, 0, None

    def run(self):
        client = Client(self.address)
        while not self.goal(self.next - 1):
            try:
                self.follow(client)
            except grpc.RpcError as error:
                self.breaks += 1
                if error.code() not in (grpc.StatusCode.UNAVAILABLE, grpc.StatusCode.ABORTED, grpc.StatusCode.CANCELLED, grpc.StatusCode.UNKNOWN, grpc.StatusCode.INTERNAL):
                    self.fault = f"{error.code()}: {error.details()}"
                    return
                time.sleep(0.01)
            except ValueError as error:
                self.fault = str(error)
                return

    def follow(self, client):
        """One stream, until it breaks or the goal is reached."""
        fields = [scene_pb.FIELD_NAME_GAP, scene_pb.FIELD_NAME_DISPLACEMENT]
        stream = client.solve(self.name, last_seen_event=len(self.kept), fields=fields)
        sent = self.next - 1
        try:
            for count in range(WINDOW):
                sent = self.send(stream, sent)
            for result, data in stream.results():
                self.keep(result, data)
                if self.goal(self.next - 1):
                    return
                while sent < self.next - 1 + WINDOW:
                    sent = self.send(stream, sent)
        finally:
            stream.call.cancel()
            stream.close()

    def send(self, stream, sent):
        stream.step(sent + 1, *step(sent + 1))
        return sent + 1

    def keep(self, result, data):
        """Gapless; what comes again has to be the same."""
        one, event = (bare(result), data), result.event
        if event <= len(self.kept):
            self.repeats += 1
            if self.kept[event - 1] != one:
                raise ValueError(f"event {event} came twice and not the same")
            return
        if event != len(self.kept) + 1:
            raise ValueError(f"event {event} after {len(self.kept)}")
        self.kept.append(one)
        self.next = result.sequence + result.last


def session(client, block, name):
    client.upload(block)
    return client.create(block.scene(), session_id=name, request_id=name, ttl={"seconds": 86400})


def disturb(proxies, workers, server, given):
    """Cuts each client's connections so often at random moments, and kills the server meanwhile."""
    kills = sorted(random.sample(range(given.cuts), given.kills))
    for cut in range(given.cuts):
        # Each client at its own moment.
        moments = sorted((random.uniform(0.01, 0.2), proxy) for proxy in proxies)
        begun = time.monotonic()
        for moment, proxy in moments:
            time.sleep(max(0.0, begun + moment - time.monotonic()))
            proxy.cut()
        if cut in kills:
            server.kill()
            server.start()
        if any(one.fault for one in workers):
            return


def one_round(number, given):
    server = Server(data=True, name=f"round-{number}", **SETTINGS)
    block, ended = Block(2), threading.Event()
    names = [session(Client(server.address), block, f"cut-{n}") for n in range(given.clients)]
    proxies = [Proxy(server.address.removeprefix("unix:")) for _ in names]
    workers = [Worker(proxy.address, name, lambda _: ended.is_set()) for proxy, name in zip(proxies, names)]
    for one in workers:
        one.start()
    disturb(proxies, workers, server, given)
    time.sleep(1)
    ended.set()
    for one in workers:
        one.join(60)
    server.kill()
    return [one.fault or compare(one, number) for one in workers], workers


CALM = {}


def compare(worker, number):
    """With a session that nobody disturbed."""
    calm = CALM.setdefault(number, Calm(f"calm-{number}"))
    expected = calm.at_least(worker.next)[: len(worker.kept)]
    wrong = [event for event, (one, other) in enumerate(zip(worker.kept, expected), 1) if one != other]
    return f"events {wrong[:3]} differ" if wrong else None


class Calm:
    """Results of an undisturbed server, as many as are asked for."""

    def __init__(self, name):
        # With a data folder, too: a session begins anew from each checkpoint, on every server that makes some.
        server = Server(data=True, name=name, **SETTINGS)
        self.worker, self.server = Worker(server.address, session(Client(server.address), Block(2), "calm"), None), server

    def at_least(self, sequence):
        self.worker.goal = lambda done: done >= sequence
        self.worker.run()
        return self.worker.kept


def main():
    given = common.arguments(__doc__, rounds=1, clients=10, cuts=200, kills=20)
    for number in range(len(common.logged("round")), given.rounds):
        faults, workers = one_round(number, given)
        common.log("round", faults=faults, results=sum(len(one.kept) for one in workers))
        row(f"clients with all results, in order, once, of {given.cuts} cuts and {given.kills} kills", given.clients,
            f"{faults.count(None)}; {sum(len(one.kept) for one in workers)} results, {sum(one.breaks for one in workers)} broken streams, "
            f"{sum(one.repeats for one in workers)} came again and were the same {[f for f in faults if f][:2]}", not any(faults))
    row("rounds with a fault, the log's included", "0", sum(any(line["faults"]) for line in common.logged("round")), not any(any(line["faults"]) for line in common.logged("round")))
    common.finish()


main()
