"""What a fleet costs: updates a second of a server with a data folder and of one in a fleet, by turns.

    rate.py PROGRAM [--haproxy PROGRAM] [--rounds 5] [--updates 200]

PROGRAM is a `signorini` with the feature `fleet`; `nats-server` has to be on PATH. Also the time of a call
to a server and through the proxy, by turns. Medians over the rounds; compare within one run only. With
nats-py also the renewals of leases in a second with and without updates: those are made beside them.
"""

from __future__ import annotations

import argparse
import asyncio
import json
import os
import statistics
import sys
import tempfile
import time
from pathlib import Path

from faults import Fleet, Program, depth, free_port, scene


def alone(folder: Path, program: str) -> Program:
    """A server with a data folder."""
    port, settings = free_port(), folder / "alone.toml"
    values = {"metrics_listen": "", "data": str(folder / "data-alone"), "retained_results": 200, "log_format": "text"}
    settings.write_text("".join(f"{key} = {json.dumps(value)}\n" for key, value in values.items()))
    command = [program, "serve", "--config", str(settings), "--listen", f"127.0.0.1:{port}"]
    return Program(command, port, folder / "alone.log")


def rate(session, ahead: int, updates: int) -> float:
    """Updates a second with so many on their way."""
    waiting, start = [], time.perf_counter()
    for number in range(1, updates + 1):
        waiting.append(session.move(ball=(0, 0, -depth(number))))
        if len(waiting) > ahead:
            waiting.pop(0).result()
    for one in waiting:
        one.result()
    return updates / (time.perf_counter() - start)


def call(client, name: str, count: int = 200) -> float:
    """Median time of a call, milliseconds."""
    times = []
    for _ in range(count):
        start = time.perf_counter()
        client.get_session(name)
        times.append(time.perf_counter() - start)
    return 1e3 * statistics.median(times)


async def renewals(url: str) -> int:
    """Renewals of leases so far."""
    import nats

    connection = await nats.connect(url)
    info = await connection.jetstream().stream_info("KV_signorini-leases")
    await connection.close()
    return info.state.last_seq


def renewed(url: str, work) -> str:
    """Renewals in a second of some work."""
    try:
        before, start = asyncio.run(renewals(url)), time.perf_counter()
    except ImportError:
        return "not looked at: no nats-py here"
    work()
    return f"{(asyncio.run(renewals(url)) - before) / (time.perf_counter() - start):.2f}"


def main() -> int:
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("program")
    arguments.add_argument("--haproxy", default="haproxy")
    arguments.add_argument("--rounds", type=int, default=5)
    arguments.add_argument("--updates", type=int, default=200)
    given = arguments.parse_args()
    os.environ["SIGNORINI_PROGRAM"] = given.program
    import signorini as s

    with tempfile.TemporaryDirectory(prefix="signorini-fleet-") as folder:
        fleet = Fleet(Path(folder), given.program, given.haproxy)
        server = alone(Path(folder), given.program)
        time.sleep(1.5)
        clients = {
            "alone": s.Client(f"127.0.0.1:{server.port}"),
            "fleet": s.Client(f"127.0.0.1:{fleet.ports[0]}"),
            "proxy": s.Client(fleet.address),
        }
        sessions = {name: client.session(scene(s), name=f"rate-{name}") for name, client in clients.items()}
        found: dict[tuple[str, str], list[float]] = {}
        for _ in range(given.rounds):
            for ahead in (1, 16):
                for name in ("alone", "fleet", "fleet", "alone"):
                    measured = rate(sessions[name], ahead, given.updates)
                    found.setdefault((f"updates a second, {ahead:2} ahead", name), []).append(measured)
            for name in ("fleet", "proxy", "proxy", "fleet"):
                found.setdefault(("ms a call", name), []).append(call(clients[name], f"rate-{name}"))
        for (what, name), values in sorted(found.items()):
            print(
                f"{what:28} {name:6} median {statistics.median(values):8.3f}  {min(values):8.3f} .. {max(values):8.3f}"
            )
        updates = renewed(fleet.url, lambda: rate(sessions["fleet"], 16, 5 * given.updates))
        print(f"renewals a second: at rest {renewed(fleet.url, lambda: time.sleep(5))}, with updates {updates}")
        server.kill()
        fleet.stop()
    return 0


if __name__ == "__main__":
    sys.exit(main())
