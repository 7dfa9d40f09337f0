"""What the tests share: the examples of the command line, a small mesh, a proxy that breaks connections."""

from __future__ import annotations

import contextlib
import socket
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest

import signorini as s

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"


@pytest.fixture(scope="session")
def examples() -> Path:
    return EXAMPLES


@pytest.fixture(scope="session")
def indent() -> s.Mesh:
    return s.Mesh.read(EXAMPLES / "meshes" / "indent_l1.msh")


@pytest.fixture
def ball(indent: s.Mesh) -> s.Scene:
    """A sphere over a quarter block."""
    return s.Scene(
        mesh=indent,
        materials={"body": s.LinearElastic(shear_modulus=1.0, poisson_ratio=0.5)},
        supports=[
            s.Support(name="base", on="z0", displacement={"x": 0.0, "y": 0.0, "z": 0.0}),
            s.Support(name="symmetry-x", on="x0", displacement={"x": 0.0}),
            s.Support(name="symmetry-y", on="y0", displacement={"y": 0.0}),
        ],
        obstacles=[s.Obstacle(name="ball", on="z1", shape=s.Sphere(centre=(0, 0, 1), radius=1.0))],
        solver=s.Solver(tolerance=1e-8),
    )


class Proxy:
    """Carries TCP connections to a server until it is told to break them."""

    def __init__(self, target: str) -> None:
        self.target = target.removeprefix("unix:")
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.address = f"127.0.0.1:{self.listener.getsockname()[1]}"
        self.pairs: list[socket.socket] = []
        self.connections = 0
        threading.Thread(target=self._accept, daemon=True).start()

    def _accept(self) -> None:
        while True:
            try:
                client, _ = self.listener.accept()
            except OSError:
                return
            self.connections += 1
            server = socket.socket(socket.AF_UNIX)
            server.connect(self.target)
            self.pairs += [client, server]
            for one, other in ((client, server), (server, client)):
                threading.Thread(target=self._carry, args=(one, other), daemon=True).start()

    def _carry(self, source: socket.socket, sink: socket.socket) -> None:
        with contextlib.suppress(OSError):
            while data := source.recv(1 << 16):
                sink.sendall(data)
        for one in (source, sink):
            with contextlib.suppress(OSError):
                one.shutdown(socket.SHUT_RDWR)

    def break_connections(self) -> None:
        for one in self.pairs:
            with contextlib.suppress(OSError):
                one.shutdown(socket.SHUT_RDWR)
            one.close()
        self.pairs.clear()

    def close(self) -> None:
        # Closing alone would leave the thread in `accept`, and one more connection to it.
        with contextlib.suppress(OSError):
            self.listener.shutdown(socket.SHUT_RDWR)
        self.listener.close()
        self.break_connections()


@pytest.fixture
def proxy() -> Iterator[Proxy]:
    address = s.connect().address
    assert address.startswith("unix:")
    one = Proxy(address)
    yield one
    one.close()
