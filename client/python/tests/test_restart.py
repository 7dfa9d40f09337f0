"""A server with a data folder that is stopped and started again beneath a session."""

from __future__ import annotations

import asyncio
import signal
import subprocess
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

import signorini as s
from signorini import _program, aio

DEPTHS = 0.03 + 0.0005 * np.arange(40)


class Server:
    """A server on a socket and a data folder of its own."""

    def __init__(self, folder: Path) -> None:
        self.address = f"unix:{folder / 'socket'}"
        self.data = folder / "data"
        self.start()

    def start(self) -> None:
        command = [str(_program.program()), "serve", "--listen", self.address, "--metrics-listen", ""]
        self.process = subprocess.Popen([*command, "--data", str(self.data)], stdout=subprocess.PIPE)
        assert self.process.stdout
        assert self.process.stdout.readline().decode().strip() == self.address

    def stop(self) -> None:
        self.process.send_signal(signal.SIGTERM)
        self.process.wait(60)
        assert self.process.stdout
        self.process.stdout.close()

    def restart(self) -> None:
        self.stop()
        self.start()


@pytest.fixture
def server(tmp_path: Path) -> Iterator[Server]:
    one = Server(tmp_path)
    yield one
    one.stop()


def check(increments: list[s.Increment]) -> None:
    """All of them came, in order, each deeper than the one before."""
    forces = [one.obstacles["ball"].force[2] for one in increments]
    assert len(forces) == len(DEPTHS)
    assert all(np.diff(forces) < 0)


def test_a_session_outlives_a_restart(ball: s.Scene, server: Server) -> None:
    client = s.Client(server.address)
    with client.session(ball) as session:
        updates = [session.move(ball=(0, 0, -depth)) for depth in DEPTHS]
        increments = [update.result() for update in updates[:3]]
        server.restart()
        increments += [update.result() for update in updates[3:]]
        check(increments)
    client.close()


def test_a_session_of_coroutines_outlives_a_restart(ball: s.Scene, server: Server) -> None:
    async def drive() -> list[s.Increment]:
        async with aio.session(ball, server=server.address) as session:
            updates = [await session.move(ball=(0, 0, -depth)) for depth in DEPTHS]
            increments = [await update.result() for update in updates[:3]]
            await asyncio.to_thread(server.restart)
            return increments + [await update.result() for update in updates[3:]]

    check(asyncio.run(drive()))
