#!/usr/bin/env python3
"""Four times the work that a server can do: how soon it refuses, how much it still does, and whether it forgets any.

usage: overload.py --signorini PROGRAM [--log FILE] [--rounds 10] [--seconds 60] [--times 4]

The capacity is what sixteen sessions do that always have six of the eight updates waiting that may, each answer bringing the
next, measured before and after each flood: machines that others use are faster and slower by the minute, so each flood is held
against its own two, by the clock and by the processor time that the server had. Where 10 % more is answered than that, the
capacity is not known. In a flood they send --times as many by the clock, whatever is answered; at a refusal they go on with the update
that was refused, as the contract says. Beside them a client asks for sessions beyond the limit. The server has a data
folder and is killed and started again after the rounds: every update that was accepted has to be answered once, in order.
"""
import statistics
import threading
import time

import grpc

import common
from common import Block, Client, Rejected, Server, milliseconds, row

SESSIONS = 16
# Updates that wait in each while the capacity is measured: the server never lacks work and refuses none.
WINDOW = 6
# What passes before anything is counted: queues fill.
BEFORE = 1.0
SETTINGS = {"maximum_in_flight": 8, "retained_results": 4096, "maximum_sessions": SESSIONS, "session_ttl_seconds": 86400}


class Sender:
    """One session on one connection."""

    def __init__(self, server, number, name=None):
        self.client = Client(server.address, server.tokens["load"])
        self.name = name or self.client.create(Block(4).scene(), session_id=f"load-{number}")
        self.sent = self.answered = self.refused = 0
        self.at, self.refusals, self.faults, self.window = {}, [], [], 0
        self.turn = threading.Lock()

    def attach(self, **opening):
        self.stream = self.client.solve(self.name, **opening)
        self.reading = threading.Thread(target=self.read, daemon=True)
        self.reading.start()

    def read(self):
        """Results have to come in order; a refusal takes the sequence back."""
        try:
            for answer in self.stream.call:
                kind = answer.WhichOneof("message")
                if kind == "step_finished":
                    self.take(answer.step_finished)
                elif kind == "update_rejected":
                    self.take_back(answer.update_rejected)
        except grpc.RpcError as error:
            self.faults.append(error.code().name)

    def take(self, result):
        if result.sequence != self.answered + 1 or result.report.termination != 1:
            self.faults.append(f"{result.sequence} after {self.answered}")
        self.answered = result.sequence
        self.fill()

    def take_back(self, rejected):
        with self.turn:
            self.refusals.append(time.perf_counter() - self.at.pop(rejected.sequence, time.perf_counter()))
            self.refused += 1
            # What was sent behind it is refused, too.
            self.sent = min(self.sent, rejected.sequence - 1)

    def fill(self):
        """As many updates wait as shall."""
        while self.window and self.sent - self.answered < self.window:
            self.send()

    def send(self):
        with self.turn:
            self.sent += 1
            self.at[self.sent] = time.perf_counter()
            self.stream.step(self.sent, 0.01 + 0.001 * (self.sent % 10))

    def flood(self, end, interval):
        """An update an interval, whatever is answered."""
        due = time.monotonic()
        while time.monotonic() < end:
            self.send()
            due += interval
            time.sleep(max(0.0, due - time.monotonic()))

    def settle(self):
        """Waits until all that was accepted is answered."""
        while True:
            session = self.client.describe(self.name)
            if session.last_finished_sequence == session.last_accepted_sequence == self.answered:
                self.sent = self.answered
                return
            time.sleep(0.02)


def answered(server, senders, seconds):
    """Updates that are answered in that time, once queues have filled: a second, and a second of the server's processor time."""
    time.sleep(BEFORE)
    before, begun, used = sum(one.answered for one in senders), time.monotonic(), server.processor()
    time.sleep(seconds)
    count = sum(one.answered for one in senders) - before
    return count / (time.monotonic() - begun), count / (server.processor() - used)


def settle(senders):
    for one in senders:
        one.settle()


def capacity(server, senders, seconds):
    for one in senders:
        one.window = WINDOW
        one.fill()
    rates = answered(server, senders, seconds)
    for one in senders:
        one.window = 0
    settle(senders)
    return rates


def beyond(server, ended, times, reasons):
    """Asks for a session that the limit does not allow, twenty times a second."""
    client, scene = Client(server.address, server.tokens["late"]), Block(1)
    client.upload(scene)
    while not ended.wait(0.05):
        begun = time.perf_counter()
        try:
            client.create(scene.scene())
            reasons.append("made")
        except grpc.RpcError as error:
            times.append(time.perf_counter() - begun)
            reasons.append(error.code().name)


def flood(server, senders, able, seconds):
    """As `answered`, while many times as many are sent."""
    end, interval = time.monotonic() + BEFORE + seconds, len(senders) / (common.given.times * able)
    threads = [threading.Thread(target=one.flood, args=(end, interval)) for one in senders]
    for one in threads:
        one.start()
    rates = answered(server, senders, seconds)
    for one in threads:
        one.join()
    settle(senders)
    return rates


def one_round(server, senders, seconds):
    """A flood between two measures of the capacity; what is told of it."""
    before = capacity(server, senders, seconds / 4)
    ended, times, reasons = threading.Event(), [], []
    late = threading.Thread(target=beyond, args=(server, ended, times, reasons))
    late.start()
    for one in senders:
        one.refusals = []
    rates = flood(server, senders, before[0], seconds)
    ended.set()
    late.join()
    updates = [time for one in senders for time in one.refusals]
    able = [before, capacity(server, senders, seconds / 4)]
    return {"goodput": rates, "able": able, "updates": updates, "sessions": times, "made": reasons.count("made"), "memory": server.memory()}


def tell_goodput(rounds):
    """Nothing is known where more was done than the server was found able to."""
    for number, unit in enumerate(("a second", "a second of the server's processor time")):
        good, able = ([one["goodput"][number] for one in rounds], [statistics.mean(rates[number] for rates in one["able"]) for one in rounds])
        parts = [done / could for done, could in zip(good, able)]
        part = statistics.median(parts)
        words = f"{100 * part:.0f} % (rounds {100 * min(parts):.0f} - {100 * max(parts):.0f}), {statistics.mean(good):.1f} of {statistics.mean(able):.1f}"
        row(f"goodput {unit}", ">= 90 % of capacity", words, part >= 0.9 if part <= 1.1 else None)


def check(server, senders):
    """After a kill the server has every accepted update, once and in order."""
    lost = sum(len(one.faults) for one in senders)
    server.kill()
    server.start()
    for number, one in enumerate(senders):
        again = Sender(server, number, one.name)
        # Old results go; what is kept has to reach the last one without a gap.
        again.answered = again.client.describe(one.name).first_retained_sequence - 1
        again.attach(last_seen_event=0)
        deadline = time.monotonic() + 60
        while again.answered < one.answered and time.monotonic() < deadline:
            time.sleep(0.02)
        lost += one.answered - again.answered + len(again.faults)
    return lost


def main():
    given = common.arguments(__doc__, rounds=10, seconds=60.0, times=4.0)
    server = Server(clients=["load", "late"], data=True, **SETTINGS)
    Client(server.address, server.tokens["load"]).upload(Block(4))
    senders = [Sender(server, number) for number in range(SESSIONS)]
    for one in senders:
        one.attach()
    capacity(server, senders, 4)
    rounds = common.logged("round")
    for number in range(len(rounds), given.rounds):
        rounds.append(one_round(server, senders, given.seconds))
        common.log("round", number=number, **rounds[-1])
    updates, sessions = ([t for one in rounds for t in one[key]] for key in ("updates", "sessions"))
    row("refusals of updates p99", "<= 20 ms", milliseconds(updates), common.percentile(updates, 0.99) <= 0.02)
    row("refusals of sessions p99", "<= 20 ms", milliseconds(sessions), common.percentile(sessions, 0.99) <= 0.02)
    tell_goodput(rounds)
    lost = check(server, senders)
    row("accepted updates that are lost, repeated or out of order", "0", f"{lost} of {sum(one.answered for one in senders)}", lost == 0)
    common.finish()


main()
