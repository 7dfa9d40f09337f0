"""Our own server, addresses, and servers that are not there."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time

import pytest

import signorini as s
from signorini import _connection, _server

CHILD = """
import signorini, sys
print(signorini.connect().address, signorini._server._running[0].process.pid, flush=True)
sys.stdin.readline()
"""


def child() -> tuple[subprocess.Popen[str], int]:
    """An interpreter with a server of its own, and the server's process."""
    process = subprocess.Popen([sys.executable, "-c", CHILD], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    assert process.stdout
    return process, int(process.stdout.readline().split()[-1])


def gone(pid: int) -> bool:
    """Whether a process ends within a few seconds."""
    for _ in range(100):
        try:
            os.kill(pid, 0)
            with open(f"/proc/{pid}/stat") as stat:
                if stat.read().rsplit(")", 1)[1].split()[0] == "Z":
                    return True
        except (ProcessLookupError, FileNotFoundError):
            return True
        time.sleep(0.05)
    return False


@pytest.mark.parametrize("ending", ["exit", "kill"])
def test_our_server_ends_with_the_interpreter(ending: str) -> None:
    process, server = child()
    with process:
        if ending == "kill":
            process.send_signal(signal.SIGKILL)
        else:
            assert process.stdin
            process.stdin.close()
        process.wait(20)
    assert gone(server)


def test_our_server_is_started_once_and_again_when_it_died() -> None:
    address = _server.address()
    assert _server.address() == address
    _server._running[0].process.kill()
    _server._running[0].process.wait()
    assert _server.address() != address


def test_the_environment_names_a_server(monkeypatch: pytest.MonkeyPatch) -> None:
    address = _server.address()
    monkeypatch.setenv("SIGNORINI_SERVER", address)
    assert _connection.resolve(None) == (address, False)
    assert _connection.resolve("localhost:5") == ("localhost:5", False)


def test_addresses_are_hosts_with_ports_or_sockets() -> None:
    for given, taken in [
        ("127.0.0.1:50051", "127.0.0.1:50051"),
        ("http://127.0.0.1:50051/", "127.0.0.1:50051"),
        ("[::1]:50051", "[::1]:50051"),
        ("https://solver.example:50051/", "https://solver.example:50051"),
        ("unix:/run/s.sock", "unix:/run/s.sock"),
        ("unix:///run/s.sock", "unix:/run/s.sock"),
    ]:
        assert _connection.target(given) == taken
    for wrong in ["", "localhost", "https://host", "ftp://host:1", "host:port"]:
        with pytest.raises(ValueError, match="no server address"):
            _connection.target(wrong)


def test_a_server_that_is_not_there_is_named(ball: s.Scene) -> None:
    with pytest.raises(s.errors.UnreachableError, match=r"127\.0\.0\.1:9"):
        s.solve(ball, server="127.0.0.1:9")


def test_a_wrong_scene_names_all_wrong_keys(ball: s.Scene) -> None:
    tables = ball.as_dict()
    tables["material"]["body"]["poisson_ratio"] = 0.7
    tables["obstacle"][0]["on"] = "Z1"
    with pytest.raises(s.errors.SceneError) as caught:
        s.solve(tables)
    assert {one.path for one in caught.value.violations} >= {"material.body.poisson_ratio", "obstacle.ball.on"}
    tables["obstacles"] = []
    with pytest.raises(s.errors.SceneError, match='did you mean "obstacle"'):
        s.solve(tables)


def test_a_plan_says_what_is_done_and_left_out(ball: s.Scene) -> None:
    plan = s.plan(ball)
    assert plan.unknowns.displacement > 0
    assert plan.decisions
    assert all(one.reason for one in plan.left_out)


def test_a_program_that_is_missing_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SIGNORINI_PROGRAM", "/nowhere/signorini")
    with pytest.raises(s.errors.ProgramError, match="/nowhere/signorini"):
        s.Mesh.read("a.msh")
