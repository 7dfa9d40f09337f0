#!/usr/bin/env python3
"""Does the time of a refusal tell how near a token was?

usage: token_times.py --signorini PROGRAM [--calls 20000]

Calls with tokens that are none, in random order, on one connection: that of a client with its first digit changed, with its last
digit changed, one that nobody has, and one of another length beside. The test is Welch's on the times below the 90th percentile;
|t| above 4.5 would be a difference that can be measured. A number of the same kind is drawn twice, so that the machine's own
noise is told too.
"""
import random
import statistics
import time

import grpc

import common
from common import Client, Server, row, session_pb

OTHERS = 200


def changed(token, place):
    """Another hexadecimal digit at that place."""
    digit = token[place]
    return token[:place] + ("0" if digit != "0" else "1") + token[place + 1 :]


def kinds(token):
    place = len("signorini_")
    unknown = "signorini_" + "%064x" % random.getrandbits(256)
    return {"first digit": changed(token, place), "last digit": changed(token, len(token) - 1), "unknown": unknown, "first digit again": changed(token, place)}


def welch(one, other):
    """t of two samples, each without its slowest tenth."""
    one, other = (sorted(values)[: 9 * len(values) // 10] for values in (one, other))
    spread = statistics.variance(one) / len(one) + statistics.variance(other) / len(other)
    return (statistics.fmean(one) - statistics.fmean(other)) / spread**0.5


def measure(server, shown, calls):
    times = {kind: [] for kind in shown}
    client, request = Client(server.address), session_pb.ListSessionsRequest()
    order = [kind for kind in shown for _ in range(calls // len(shown))]
    random.shuffle(order)
    for kind in order:
        metadata = [("authorization", f"Bearer {shown[kind]}")]
        begun = time.perf_counter_ns()
        try:
            client.sessions.ListSessions(request, metadata=metadata)
            raise SystemExit(f"a token with its {kind} changed was taken")
        except grpc.RpcError as error:
            times[kind].append(time.perf_counter_ns() - begun)
            if error.code() is not grpc.StatusCode.UNAUTHENTICATED:
                raise
    return times


def main():
    given = common.arguments(__doc__, calls=20000)
    server = Server(clients=[f"line-{number}" for number in range(OTHERS)], log_level="error")
    times = measure(server, kinds(server.tokens["line-0"]), given.calls)
    reference = times["first digit"]
    for kind in ("last digit", "unknown", "first digit again"):
        t = welch(reference, times[kind])
        words = f"t {t:.1f}, medians {statistics.median(reference) / 1e3:.1f} and {statistics.median(times[kind]) / 1e3:.1f} us"
        row(f"first digit changed against {kind}", "|t| <= 4.5", words, abs(t) <= 4.5)
    common.finish()


main()
