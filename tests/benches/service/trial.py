"""Where a fault is provoked: a server whose metrics page is watched, its clients, and the means to spoil them.

A fault is a function of a `Site`: it starts its server, says when it begins, and goes on until the site is over. What
the machine does not allow (a disk of its own needs root, a fleet NATS and a program with the feature) is left out, and
why is said.
"""
import contextlib
import ctypes
import os
import shutil
import subprocess
import threading
import time
import urllib.error
from pathlib import Path

import grpc

import common
from common import FOLDER, Block, Client, Server, attached, free_port
from watching import get

ALL = []


class LeftOut(Exception):
    """This machine does not allow it."""


def fault(what, alert, word=""):
    """Enters a fault; `word` is the label that its alert has to have, where there are several."""
    return lambda provoke: ALL.append((what, alert, word, provoke)) or provoke


class Observed(Server):
    """A server whose metrics page is watched, on a Unix socket or on loopback."""

    def __init__(self, loopback=False, **more):
        self.page = f"127.0.0.1:{free_port()}"
        self.loopback = f"127.0.0.1:{free_port()}" if loopback else None
        super().__init__(metrics_listen=self.page, **more)

    def start(self):
        self.address = self.loopback or self.address
        super().start()

    def answers(self):
        with contextlib.suppress(OSError):
            return bool(get(f"http://{self.page}/livez"))
        return False

    def sample(self, series):
        """A number of the page."""
        lines = get(f"http://{self.page}/metrics").splitlines()
        return next(float(line.rsplit(" ", 1)[1]) for line in lines if line.startswith(series + " "))

    def ready(self):
        """What /healthz answers."""
        try:
            get(f"http://{self.page}/healthz")
            return 200
        except urllib.error.HTTPError as error:
            return error.code


class Site:
    """Where one fault is provoked: its server, its clients, when it began, whether it is over."""

    def __init__(self, prometheus, number):
        self.prometheus, self.number = prometheus, number
        self.over, self.began, self.failed = threading.Event(), None, None
        self.observed, self.clients = None, []

    def server(self, **settings):
        self.observed = Observed(name=f"drill-{self.number}", **settings)
        self.prometheus.add(self.observed.page)
        return self.observed

    def begin(self):
        """The server was looked at twice and is well; from here on it is not."""
        while self.prometheus.looked(self.observed.page) < 2:
            time.sleep(0.1)
        self.began = time.monotonic()

    def client(self):
        client = Client(self.observed.address)
        self.clients.append(client)
        return client

    def session(self, block, client=None):
        client = client or self.client()
        client.upload(block)
        return client, client.create(block.scene(rubber=True))

    def pressed(self, increments=3):
        """A session that is pressed once; its client, its name and the results."""
        client, name = self.session(Block(1))
        stream = attached(client, name)
        stream.step(1, 0.01, increments)
        results = [finished for finished, _ in until_the_last(stream)]
        stream.close()
        return client, name, results

    def works(self, block, increments=20_000):
        """A session with a long step whose results are read."""
        client, name = self.session(block)
        stream = attached(client, name)
        stream.step(1, 0.05, increments)
        threading.Thread(target=read, args=(stream,), daemon=True).start()
        return client, name

    def repeat(self, act, seconds=0.5):
        """Goes on until the site is over; refusals are what it is about."""
        while not self.over.is_set():
            with contextlib.suppress(grpc.RpcError, OSError):
                act()
            self.over.wait(seconds)

    def clear(self):
        for client in self.clients:
            client.close()
        if self.observed:
            self.prometheus.drop(self.observed.page)
            self.observed.kill()


def until_the_last(stream):
    for finished, data in stream.results():
        yield finished, data
        if finished.last:
            return


def read(stream):
    with contextlib.suppress(grpc.RpcError, common.Rejected):
        for _ in stream.results():
            pass


def ask(client, call, request):
    """A call that is refused; by what."""
    try:
        getattr(client.sessions, call)(request, metadata=client.metadata, timeout=30)
    except grpc.RpcError as error:
        return error.code()
    return None


def solving_threads(server):
    """Numbers of the threads that solve."""
    for task in os.scandir(f"/proc/{server.process.pid}/task"):
        name = Path(f"{task.path}/comm").read_text()
        if name.startswith(("solver-", "seat-")):
            yield int(task.name)


@contextlib.contextmanager
def frozen(server):
    """The threads that solve stand still, and no other; left and entered by one thread."""
    seize, interrupt, detach = 0x4206, 0x4207, 17
    system = ctypes.CDLL(None, use_errno=True)
    system.ptrace.argtypes = [ctypes.c_long, ctypes.c_long, ctypes.c_void_p, ctypes.c_void_p]
    system.ptrace.restype = ctypes.c_long
    stopped = list(solving_threads(server))
    for thread in stopped:
        if system.ptrace(seize, thread, None, None) != 0:
            raise LeftOut("this system lets nobody stop a thread (ptrace)")
        system.ptrace(interrupt, thread, None, None)
    yield
    for thread in stopped:
        # It has stopped by now; waited for, because only a stopped one can be let go.
        with contextlib.suppress(ChildProcessError):
            os.waitpid(thread, 0x40000000)
        system.ptrace(detach, thread, None, None)


@contextlib.contextmanager
def small_disk(site, megabytes=64):
    """A disk of its own, of which a file takes what shall not be free."""
    place = FOLDER / f"disk-{site.number}"
    place.mkdir()
    command = ["mount", "-t", "tmpfs", "-o", f"size={megabytes}m", "tmpfs", place]
    if os.geteuid() != 0 or subprocess.run(command, capture_output=True).returncode != 0:
        raise LeftOut("a disk of its own needs root and mount")
    try:
        yield place
    finally:
        subprocess.run(["umount", "--lazy", place], check=False)


def fill(place, left):
    """Leaves so many bytes of a disk."""
    free = shutil.disk_usage(place).free
    with open(place / "filler", "wb") as filler:
        os.posix_fallocate(filler.fileno(), 0, max(free - left, 1))
