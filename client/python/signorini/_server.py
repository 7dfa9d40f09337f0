"""A server of our own: a process of the program, on a Unix socket that only this user opens.

It starts when first needed and ends with the interpreter: it ends by itself when its stdin,
which this process holds, is closed. Cost: some 20 ms.
"""

from __future__ import annotations

import atexit
import contextlib
import os
import shutil
import subprocess
import tempfile
import threading
from dataclasses import dataclass
from pathlib import Path

from ._program import program
from .errors import ProgramError

# A path of a socket has 108 bytes at most.
LONGEST_SOCKET_PATH = 100
STOP_SECONDS = 5.0


@dataclass
class Embedded:
    """A running server."""

    address: str
    process: subprocess.Popen[bytes]
    folder: str
    owner: int

    def alive(self) -> bool:
        """Whether it runs, as a child of this very process."""
        return self.owner == os.getpid() and self.process.poll() is None

    def stop(self) -> None:
        """Lets it end, or ends it."""
        if self.owner == os.getpid():
            if self.process.stdin:
                with contextlib.suppress(OSError):
                    self.process.stdin.close()
            try:
                self.process.wait(STOP_SECONDS)
            except subprocess.TimeoutExpired:
                self.process.kill()
                self.process.wait()
            if self.process.stdout:
                self.process.stdout.close()
            shutil.rmtree(self.folder, ignore_errors=True)


_lock = threading.Lock()
_running: list[Embedded] = []


def start() -> Embedded:
    """Starts a server and waits until it listens."""
    folder = tempfile.mkdtemp(prefix="signorini-")
    socket = Path(folder) / "socket"
    fits = len(os.fsencode(socket)) < LONGEST_SOCKET_PATH
    listen = f"unix:{socket}" if fits else "127.0.0.1:0"
    command = [str(program()), "embed", "serve", listen]
    # In a session of its own, so that Ctrl-C reaches only the interpreter.
    process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, start_new_session=True)
    line = process.stdout.readline() if process.stdout else b""
    server = Embedded(line.decode().strip(), process, folder, os.getpid())
    if not server.address:
        server.stop()
        raise ProgramError(f"{' '.join(command)}: the server did not start")
    return server


def address() -> str:
    """Where our server listens; starts it first where none runs."""
    with _lock:
        if _running and not _running[0].alive():
            _running.pop().stop()
        if not _running:
            _running.append(start())
        return _running[0].address


def stop() -> None:
    """Ends our server, if one runs; the next call starts another."""
    with _lock:
        while _running:
            _running.pop().stop()


atexit.register(stop)
