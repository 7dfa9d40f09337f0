"""Connections: addresses, channels, and calls whose failures are typed."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import grpc

from . import _server
from .errors import ConnectionBrokenError, SignoriniError, UnreachableError, from_call

# For calls that the server answers from what it has, and for those that plan a scene, seconds.
ANSWER_SECONDS = 60.0
PLAN_SECONDS = 600.0

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
    """`http://HOST:PORT`, `HOST:PORT` or `unix:PATH` as gRPC takes it."""
    if text.startswith("unix:"):
        return "unix:" + text.removeprefix("unix:").removeprefix("//")
    address = text.removeprefix("http://").rstrip("/")
    host, _, port = address.rpartition(":")
    if not host or not port.isdigit() or "//" in host:
        raise ValueError(f'"{text}" is no server address: HOST:PORT, http://HOST:PORT or unix:PATH is expected')
    return address


@contextmanager
def typed(address: str) -> Iterator[None]:
    """Failures of unary calls as exceptions of this package."""
    try:
        yield
    except grpc.RpcError as error:
        raise unanswered(from_call(error, address), address) from None


def unanswered(error: SignoriniError, address: str) -> SignoriniError:
    """A call that broke without an answer means that nobody is there."""
    if isinstance(error, ConnectionBrokenError):
        return UnreachableError(f"no server answers at {address}: {error}")
    return error
