#!/usr/bin/env python3
"""Bad clients against a server with a small budget: its memory, its health, and what is left for a good client.

usage: attacks.py --signorini PROGRAM [--log FILE] [--seconds 30] [--megabytes 200] [--rounds 1] [--only NAME,..] [--group 0]

Beside it an idle server of the same program is asked, by turns: what that one takes longer is the machine's. A round has one part a bad client (attackers.py), with the rate of a good client before it, beside it and after it, and
one part with all of them together. Health is asked every 20 ms by a process of its own, resident memory is read every
10 ms. Rounds in the log are not run again. With --group 600 the server runs in a control group of that many megabytes
and has the budget that it gives itself.
"""
import multiprocessing
import os
import statistics
import sys
import threading
import time

import grpc

import attackers
import common
from common import MEGABYTE, Block, Client, Server, channel, health, row

PROCESSES = multiprocessing.get_context("spawn")


def ask(addresses, here, ended, times):
    """Asks each server for health every 20 ms, by turns; what takes longer than ten seconds counts as ten."""
    here.release()
    found, asked = [[] for _ in addresses], [health(channel(address)) for address in addresses]
    while not ended.wait(0.02):
        for one, kept in zip(asked, found):
            begun = time.perf_counter()
            try:
                one(b"", timeout=10)
                kept.append(time.perf_counter() - begun)
            except grpc.RpcError:
                kept.append(10.0)
    times.put(found)


class Good:
    """A client that moves a ball to and fro and waits for each result."""

    def __init__(self, server):
        self.client = Client(server.address, server.tokens["good"])
        block = Block(3)
        self.client.upload(block)
        self.name, self.sequence = self.client.create(block.scene()), 0
        self.stream = self.client.solve(self.name)
        self.results = self.stream.results()

    def rate(self, seconds):
        """Updates a second; every answer has to be the next one and converged."""
        begun, count = time.perf_counter(), 0
        while time.perf_counter() - begun < seconds:
            self.sequence += 1
            self.stream.step(self.sequence, 0.01 + 0.001 * (self.sequence % 10))
            result, _ = next(self.results)
            if result.sequence != self.sequence or result.report.termination != 1:
                raise RuntimeError(f"update {self.sequence} was answered by {result.sequence}, {result.report.termination}")
            count += 1
        return count / (time.perf_counter() - begun)


class Attack:
    """Bad clients and the observers of the server while they go on."""

    idle = None

    def __init__(self, server, names):
        self.server, self.names = server, names
        Attack.idle = Attack.idle or Server(name="idle")

    def __enter__(self):
        self.ended, self.times, self.peak = attackers.Ended(PROCESSES), PROCESSES.Queue(), 0
        self.begun, self.said = time.monotonic(), len(self.server.said())
        here = PROCESSES.Semaphore(0)
        of = lambda name: (name, self.server.address, self.server.tokens[name], here, self.ended)  # noqa: E731
        self.bad = [PROCESSES.Process(target=attackers.run, args=of(name)) for name in self.names]
        self.asking = PROCESSES.Process(target=ask, args=([self.server.address, Attack.idle.address], here, self.ended, self.times))
        for process in (self.asking, *self.bad):
            process.start()
        # On a busy machine they take long to begin.
        for _ in (self.asking, *self.bad):
            here.acquire()
        self.watching = threading.Thread(target=self.watch)
        self.watching.start()
        return self

    def watch(self):
        while not self.ended.wait(0.01):
            self.peak = max(self.peak, self.server.memory())

    def __exit__(self, *_):
        # What the good client does is no stranger's.
        lines = self.server.said()[self.said :].splitlines()
        others = sum(len(line) + 1 for line in lines if "step finished" not in line)
        self.log = others / (time.monotonic() - self.begun)
        self.ended.set()
        self.watching.join()
        self.health, self.calm = self.times.get()
        for process in (*self.bad, self.asking):
            process.join(20)
            if process.is_alive():
                process.kill()


def beside(good, server, name, seconds):
    """Rates of the good client alone and beside a bad one, health, peak memory."""
    before = good.rate(seconds / 4)
    with Attack(server, [name]) as attack:
        # Until the bad client is at work.
        good.rate(min(3.0, seconds / 4))
        rate = good.rate(seconds)
    time.sleep(3)
    alone = statistics.mean([before, good.rate(seconds / 4)])
    return {"name": name, "share": rate / alone, "alone": alone, "peak": attack.peak, **heard(attack)}


def heard(attack):
    """Health of both servers in numbers."""
    at = common.percentile
    return {"health": at(attack.health, 0.99), "worst": max(attack.health), "asked": len(attack.health), "calm": at(attack.calm, 0.99), "log": attack.log}


def together(good, server, names, seconds):
    """All bad clients at once."""
    with Attack(server, names) as attack:
        rate = good.rate(seconds)
    return {"peak": attack.peak, "rate": rate, **heard(attack)}


def tell_health(what, found):
    words = f"{1e3 * found['health']:.1f} ms, max {1e3 * found['worst']:.0f} of {found['asked']} (an idle server: {1e3 * found['calm']:.1f})"
    # Nothing is known where the machine alone takes that long.
    row(what, "<= 50 ms", words, found["health"] <= 0.05 if found["calm"] <= 0.025 else None)


def tell_log(what, found):
    row(what, "<= 10 kB/s", f"{found['log'] / 1e3:.1f} kB/s", found["log"] <= 1e4)


def tell_beside(found, bound):
    row(f"good client beside {found['name']}", ">= 40 %", f"{100 * found['share']:.0f} % of {found['alone']:.0f}/s", found["share"] >= 0.4)
    tell_health(f"health p99 beside {found['name']}", found)
    tell_log(f"log beside {found['name']}", found)
    row(f"peak memory beside {found['name']}", f"<= {bound:.0f} MB", f"{found['peak'] / MEGABYTE:.0f} MB", found["peak"] <= bound * MEGABYTE)


def tell_together(found, bound):
    row("peak memory, all together", f"<= {bound:.0f} MB", f"{found['peak'] / MEGABYTE:.0f} MB", found["peak"] <= bound * MEGABYTE)
    tell_health("health p99, all together", found)
    row("good client, all together", "-", f"{found['rate']:.1f}/s", None)


def one_round(number, names, bound):
    """On a server of its own; parts that the log has are not run again."""
    given, done = common.given, [found["name"] for found in common.logged("beside") if found["round"] == number]
    room = {"prefix": common.control_group(given.group)} if given.group else {"memory_budget_bytes": given.megabytes * MEGABYTE}
    if room.get("prefix", True) is None:
        sys.exit("nobody may make a control group here")
    server = Server(clients=["good", *names], name=f"round-{number}", **room)
    good = Good(server)
    good.rate(2)
    for name in names:
        if name not in done:
            found = beside(good, server, name, given.seconds)
            common.log("beside", round=number, **found)
            tell_beside(found, bound)
    found = together(good, server, names, given.seconds)
    common.log("together", round=number, **found)
    tell_together(found, bound)
    if given.group:
        row(f"server in a control group of {given.group} MB", "lives", "lives" if server.lives() else "is gone", server.lives())
    server.kill()


def main():
    given = common.arguments(__doc__, seconds=30.0, megabytes=200, rounds=1, only=",".join(attackers.ALL), group=0)
    names = given.only.split(",")
    bound = given.group or 1.15 * given.megabytes + 60
    for found in common.logged("beside"):
        tell_beside(found, bound)
    for found in common.logged("together"):
        tell_together(found, bound)
    for number in range(len(common.logged("together")), given.rounds):
        one_round(number, names, bound)
    common.finish()


if __name__ == "__main__":
    main()
