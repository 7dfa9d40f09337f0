#!/usr/bin/env python3
"""What a server takes that nobody uses, how soon it serves, and what it does with little memory.

usage: footprint.py --signorini PROGRAM [--starts 20] [--megabytes 600] [--seconds 30]

Resident memory two seconds after the start, the time from the start of the process to the first answer of health
(least and median of --starts), both without a data folder. Then a server in a control group of --megabytes, or where
the machine lets nobody make one in an address space of that size: its default budget, and whether it lives
through --seconds of scenes that do not fit.
"""
import re
import statistics
import sys
import threading
import time

import grpc

import common
from common import MEGABYTE, Block, Client, Server, row


def starts(count):
    """Seconds from the start of the process until it takes a connection and answers."""
    seconds = []
    for number in range(count):
        begun = time.perf_counter()
        server = Server(name=f"start-{number}")
        seconds.append(time.perf_counter() - begun)
        if number + 1 < count:
            server.kill()
    time.sleep(2)
    idle = server.memory() / MEGABYTE
    server.kill()
    return seconds, idle


def limited(megabytes):
    """What a command is put behind to have so much memory, and in words what that is."""
    if group := common.control_group(megabytes):
        return group, "control group"
    # A limit of the address space counts what is set aside and never touched, too: the idle server's comes on top.
    idle = Server(name="reserved")
    aside = idle.memory("VmSize")
    idle.kill()
    return ["prlimit", f"--as={aside + megabytes * MEGABYTE}"], "address space above the idle server's (no control groups here)"


def budget(server):
    """The budget that the server told at its start."""
    found = re.findall(r"memory_budget_bytes=(\d+)", server.said())
    return int(found[-1]) / MEGABYTE if found else float("nan")


def load(server, end, outcomes):
    """Sessions on ever larger blocks, over and over, until `end`."""
    client, n = Client(server.address), 4
    while time.monotonic() < end and server.lives():
        try:
            block = Block(n)
            client.upload(block)
            name = client.create(block.scene(), request_id="")
            stream = client.solve(name)
            stream.step(1, 0.02)
            next(stream.results())
            stream.call.cancel()
            outcomes.append("solved")
        except grpc.RpcError as error:
            outcomes.append(error.code().name)
        except common.Rejected:
            outcomes.append("SESSION_FAILED")
        n = 4 if n > 28 else n + 4


def little_memory():
    """One client after the other makes the server full."""
    prefix, words = limited(common.given.megabytes)
    server = Server(prefix=prefix, name="little")
    asked = f"<= {common.given.megabytes} MB"
    found = budget(server)
    row(f"default budget in {words} of {common.given.megabytes} MB", asked, f"{found:.0f} MB", found <= common.given.megabytes)
    outcomes, end = [], time.monotonic() + common.given.seconds
    clients = [threading.Thread(target=load, args=(server, end, outcomes)) for _ in range(3)]
    for one in clients:
        one.start()
    for one in clients:
        one.join()
    counts = {word: outcomes.count(word) for word in sorted(set(outcomes))}
    lives = server.lives() and server.answers()
    row(f"{common.given.seconds} s of scenes of all sizes in it", "lives", f"{'lives' if lives else 'is gone'}: {counts}", lives)
    if not lives:
        print(server.said()[-1000:], file=sys.stderr)
    server.kill()


def main():
    given = common.arguments(__doc__, starts=20, megabytes=600, seconds=30)
    seconds, idle = starts(given.starts)
    row("idle", "<= 30 MB", f"{idle:.1f} MB", idle <= 30)
    least = 1e3 * min(seconds)
    row("start until health answers", "<= 50 ms", f"{least:.0f} ms, median {1e3 * statistics.median(seconds):.0f}", least <= 50)
    little_memory()
    common.finish()


main()
