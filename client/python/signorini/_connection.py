"""Connections: addresses, channels, and calls whose failures are typed."""

from __future__ import annotations

import asyncio
import os
import time
from collections.abc import Awaitable, Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import grpc
import grpc.aio

from . import _server
from .errors import ConnectionBrokenError, GatewayError, SignoriniError, UnreachableError, from_call

# For calls that the server answers from what it has, and for those that plan a scene, seconds.
ANSWER_SECONDS = 60.0
PLAN_SECONDS = 600.0
# How long a call is made again behind a proxy whose server is gone, seconds.
CALL_PATIENCE = 30.0
#: Names the session that a call belongs to: what lies between leads by it.
SESSION_HEADER = "x-signorini-session"

#: Every connection of its own, no proxy between us and a server, broken ones tried again soon.
OPTIONS = [
    ("grpc.enable_http_proxy", 0),
    # Newer versions of grpcio name the path of a socket, which is no authority of HTTP.
    ("grpc.default_authority", "localhost"),
    ("grpc.use_local_subchannel_pool", 1),
    ("grpc.keepalive_time_ms", 20_000),
    ("grpc.keepalive_timeout_ms", 10_000),
    ("grpc.http2.max_pings_without_data", 0),
    ("grpc.initial_reconnect_backoff_ms", 100),
    # Also the least time that an attempt is given.
    ("grpc.min_reconnect_backoff_ms", 10_000),
    ("grpc.max_reconnect_backoff_ms", 2_000),
    ("grpc.max_receive_message_length", 16 << 20),
]

Check = Callable[[], Any]


def resolve(server: str | None) -> tuple[str, bool]:
    """The address for gRPC of a server, and whether the server is our own.

    Without a server, `SIGNORINI_SERVER` names it, else our own is started.
    """
    text = server or os.environ.get("SIGNORINI_SERVER") or ""
    if not text:
        return target(_server.address()), True
    return target(text), False


def target(text: str) -> str:
    """`http://HOST:PORT`, `HOST:PORT` or `unix:PATH` as gRPC takes it; `https://HOST:PORT` stays."""
    if text.startswith("unix:"):
        return "unix:" + text.removeprefix("unix:").removeprefix("//")
    scheme = "https://" if text.startswith("https://") else ""
    address = text.removeprefix("http://").removeprefix(scheme).rstrip("/")
    host, _, port = address.rpartition(":")
    if not host or not port.isdigit() or "//" in host:
        raise ValueError(f'"{text}" is no server address: HOST:PORT, http(s)://HOST:PORT or unix:PATH is expected')
    return scheme + address


def channel(address: str, *, aio: bool = False) -> Any:
    """A channel to an address of `target`, with what the environment says about tokens and certificates."""
    calls = _token(address)
    module = grpc.aio if aio else grpc
    if address.startswith("https://"):
        own = grpc.ssl_channel_credentials(_file("SIGNORINI_CA"), _file("SIGNORINI_KEY"), _file("SIGNORINI_CERT"))
        # The name in the certificate is that of the address.
        options = [one for one in OPTIONS if one[0] != "grpc.default_authority"]
    elif calls is None:
        return module.insecure_channel(address, OPTIONS)
    elif address.startswith("unix:"):
        own, options = grpc.local_channel_credentials(grpc.LocalConnectionType.UDS), OPTIONS
    else:
        raise ValueError(f"a token is not sent to {address}: others could read it; use https://HOST:PORT or unix:PATH")
    if calls is not None:
        own = grpc.composite_channel_credentials(own, calls)
    return module.secure_channel(address.removeprefix("https://"), own, options)


def _token(address: str) -> Any:
    """The token of `SIGNORINI_TOKEN_FILE` or `SIGNORINI_TOKEN`, which a server of our own does not ask for."""
    if any(target(one.address) == address for one in _server._running):
        return None
    text = _file("SIGNORINI_TOKEN_FILE") or os.environ.get("SIGNORINI_TOKEN", "").encode()
    token = text.decode().strip()
    return grpc.access_token_call_credentials(token) if token else None


def _file(variable: str) -> bytes | None:
    path = os.environ.get(variable)
    return Path(path).read_bytes() if path else None


def route(session: str) -> tuple[tuple[str, str], ...]:
    """What a call says about the session that it belongs to, by identifier or name; nothing for none."""
    return ((SESSION_HEADER, session.removeprefix("sessions/")),) if session else ()


def pauses(patience: float) -> Iterator[float]:
    """Pauses before further tries: 50 ms, doubling to 2 s, until the patience ends."""
    pause, spent = 0.05, 0.0
    while spent < patience:
        pause = min(pause, patience - spent)
        yield pause
        spent, pause = spent + pause, min(2 * pause, 2.0)


def again(address: str, call: Callable[[], Any]) -> Any:
    """The answer to a call that may be made any number of times; what broke it between here and the
    service is tried again."""
    for pause in pauses(CALL_PATIENCE):
        try:
            with typed(address):
                return call()
        except GatewayError:
            time.sleep(pause)
    with typed(address):
        return call()


async def again_soon(address: str, call: Callable[[], Awaitable[Any]]) -> Any:
    """As `again`, for coroutines."""
    for pause in pauses(CALL_PATIENCE):
        try:
            with typed(address):
                return await call()
        except GatewayError:
            await asyncio.sleep(pause)
    with typed(address):
        return await call()


@contextmanager
def typed(address: str) -> Iterator[None]:
    """Failures of unary calls as exceptions of this package."""
    try:
        yield
    except grpc.RpcError as error:
        raise unanswered(from_call(error, address), address) from None


def unanswered(error: SignoriniError, address: str) -> SignoriniError:
    """A call that broke without an answer means that nobody is there."""
    if isinstance(error, ConnectionBrokenError) and not isinstance(error, GatewayError):
        return UnreachableError(f"no server answers at {address}: {error}")
    return error
