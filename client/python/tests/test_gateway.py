"""Behind a proxy whose servers come and go: calls are made again, streams go on, each call names its session.

The proxy is one of gRPC: it hands bytes of messages on, and fails the calls that it is told to, as
HAProxy and nginx do whose server is gone.
"""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Iterator
from concurrent import futures
from typing import Any

import grpc
import pytest

import signorini as s
from signorini import aio, errors

STREAMS = {"Solve": "stream_stream", "Watch": "unary_stream", "ReadStep": "unary_stream", "ReadMesh": "unary_stream"}
STREAMS |= {"UploadMesh": "stream_unary", "UploadSurface": "stream_unary", "ExportState": "unary_stream"}


class Gateway(grpc.GenericRpcHandler):
    """Hands calls on to a server, or fails them."""

    def __init__(self, target: str) -> None:
        self.channel = grpc.insecure_channel(target, [("grpc.default_authority", "localhost")])
        self.failures: list[tuple[grpc.StatusCode, str]] = []
        self.calls: list[tuple[str, str | None]] = []
        self.open: list[Any] = []
        self.lock = threading.Lock()
        self.server = grpc.server(futures.ThreadPoolExecutor(32), handlers=(self,))
        self.address = f"127.0.0.1:{self.server.add_insecure_port('127.0.0.1:0')}"
        self.server.start()

    def service(self, details: Any) -> Any:
        name = details.method.rsplit("/", 1)[1]
        kind = STREAMS.get(name, "unary_unary")
        session = dict(details.invocation_metadata).get("x-signorini-session")

        def handle(request: Any, context: Any) -> Any:
            with self.lock:
                self.calls.append((name, session))
                failure = self.failures.pop(0) if self.failures else None
            if failure:
                context.abort(*failure)
            try:
                call = getattr(self.channel, kind)(details.method)(request)
                if kind in ("unary_unary", "stream_unary"):
                    return call
                context.add_callback(call.cancel)
                self.open.append(call)
                return carried(call, context)
            except grpc.RpcError as error:
                return told(error, context)

        return getattr(grpc, f"{kind}_rpc_method_handler")(handle)

    def fail(self) -> None:
        """The next calls fail in every way of a proxy."""
        pages = [(grpc.StatusCode.UNAVAILABLE, f"Received http2 header with status: {one}") for one in (502, 503, 504)]
        reset = "Stream removed (RST_STREAM (Received RST_STREAM with error code 7))"
        refused = (grpc.StatusCode.UNAVAILABLE, reset)
        self.failures += [*pages, refused, (grpc.StatusCode.CANCELLED, "CANCELLED")]

    def cut(self) -> None:
        for call in self.open:
            call.cancel()
        self.open.clear()


def told(error: Any, context: Any) -> Any:
    """Hands a status on with its details."""
    context.set_trailing_metadata([one for one in error.trailing_metadata() if one[0].endswith("-bin")])
    context.abort(error.code(), error.details())


def carried(call: Any, context: Any) -> Iterator[bytes]:
    try:
        yield from call
    except grpc.RpcError as error:
        told(error, context)


@pytest.fixture
def gateway() -> Iterator[Gateway]:
    one = Gateway(s.connect().address)
    yield one
    one.server.stop(None)


DEPTHS = (0.03, 0.031, 0.032)


def test_calls_and_streams_go_on_and_name_their_session(ball: s.Scene, gateway: Gateway) -> None:
    client = s.Client(gateway.address)
    gateway.fail()
    with client.session(ball, name="behind-a-proxy") as session:
        forces = []
        for depth in DEPTHS:
            gateway.fail()
            gateway.cut()
            forces.append(session.move(ball=(0, 0, -depth)).result().obstacles["ball"].force[2])
        gateway.fail()
        assert session.save() >= 1
        gateway.fail()
    assert sorted(forces, reverse=True) == forces
    assert {session for _, session in gateway.calls} == {"behind-a-proxy"}
    assert {"GetMesh", "CreateSession", "Solve", "SaveState", "DeleteSession"} <= {name for name, _ in gateway.calls}
    with pytest.raises(errors.NotFoundError):
        client.get_session("behind-a-proxy")
    client.close()


def test_coroutines_go_on_and_name_their_session(ball: s.Scene, gateway: Gateway) -> None:
    async def drive() -> list[float]:
        gateway.fail()
        async with aio.session(ball, server=gateway.address) as session:
            forces = []
            for depth in DEPTHS:
                gateway.fail()
                gateway.cut()
                update = await session.move(ball=(0, 0, -depth))
                forces.append((await update.result()).obstacles["ball"].force[2])
            return forces

    forces = asyncio.run(drive())
    assert sorted(forces, reverse=True) == forces
    names = {session for _, session in gateway.calls}
    assert len(names) == 1
    assert None not in names
