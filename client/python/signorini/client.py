"""A connection to one server: meshes, plans, sessions, solves."""

from __future__ import annotations

import atexit
import threading
import warnings
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from ._calls import Calls
from ._connection import resolve
from ._encode import SceneLike, problem
from ._options import PATIENCE, Options, default_fields, steps_of
from ._session import Session, attach, create
from .errors import SignoriniWarning
from .reports import Plan
from .results import Increment, Result

__all__ = ["Client", "connect", "plan", "session", "solve"]


class Client(Calls):
    """A connection to a server; threads may share it."""

    def solve(
        self,
        scene: SceneLike,
        mesh: Any = None,
        *,
        fields: Sequence[str] | None = None,
        set: Mapping[str, Any] | None = None,
        verify: bool = False,
        progress: Callable[[Increment], None] | None = None,
        patience: float = PATIENCE,
    ) -> Result:
        """Solves a scene: all its steps, with the fields that it names or those of the pictures.

        `scene` is a file, a dictionary with the keys of one, or a `Scene`; `mesh` (a `Mesh`, one of
        meshio, a file) replaces the scene's; `set` changes keys, such as `{"solver.tolerance": 1e-6}`;
        `progress` is called with each increment. Not converging is a result: see `Result.check`.
        """
        one = problem(scene, mesh, set)
        wanted = fields if fields is not None else default_fields(one.scene)
        options = Options(fields=wanted, verify=verify, patience=patience)
        with create(self, one, options) as session:
            pending = [session.step(step) for step in steps_of(one.scene)]
            increments = []
            for increment in (increment for update in pending for increment in update):
                increments.append(increment)
                if progress is not None:
                    progress(increment)
            result = session.collect(increments)
        tell(result)
        return result

    def plan(
        self,
        scene: SceneLike,
        mesh: Any = None,
        *,
        set: Mapping[str, Any] | None = None,
        constants: bool = False,
    ) -> Plan:
        """What a scene needs, what is left out and why; nothing is solved.

        With `constants` the plan's message lists the numbers, too, that the solver compares with.
        """
        one = problem(scene, mesh, set)
        self.upload_problem(one)
        request = Options().create(one, self.embedded)
        request.validate_only = True
        request.constants = constants
        return Plan(self.create(request).plan)

    def session(
        self,
        scene: SceneLike,
        mesh: Any = None,
        *,
        fields: Sequence[str] | None = None,
        set: Mapping[str, Any] | None = None,
        name: str = "",
        ttl: float | None = None,
        keep: bool = False,
        iterations: float | None = None,
        patience: float = PATIENCE,
    ) -> Session:
        """A session of a scene, to be driven step by step; the scene's own steps are not sent.

        `fields` come with each result (those of the scene's output unless given); `iterations` asks
        for live iterations, at most one in so many seconds; `keep` leaves the session to the server
        when it is closed; `ttl` are the seconds that it lives without a call.
        """
        options = Options(fields, name, ttl, iterations=iterations, patience=patience, keep=keep)
        return create(self, problem(scene, mesh, set), options)

    def attach(
        self,
        name: str,
        *,
        fields: Sequence[str] | None = None,
        iterations: float | None = None,
        patience: float = PATIENCE,
    ) -> Session:
        """The stream of a session that is there, by name."""
        return attach(self, name, Options(fields, iterations=iterations, patience=patience, keep=True))

    def __repr__(self) -> str:
        return f"Client({self.address}{', own server' if self.embedded else ''})"


def tell(result: Result) -> None:
    """Warns of what a mechanic would doubt."""
    kinds: dict[tuple[str, str], list[str]] = {}
    for one in result.warnings:
        kinds.setdefault((one.kind, one.subject), []).append(one.message)
    doubts = [
        messages[0] + (f" (and {len(messages) - 1} like it)" * (len(messages) > 1)) for messages in kinds.values()
    ]
    rounds = [f"accuracy: not reached: {one.why}" for one in result.rounds[-1:] if one.end != "reached"]
    for message in [*rounds, *result.plan.warnings, *doubts]:
        warnings.warn(message, SignoriniWarning, stacklevel=4)


_lock = threading.Lock()
_clients: dict[str, Client] = {}


def connect(server: str | None = None) -> Client:
    """The connection to a server, shared by all who ask for the same one.

    `server` is `HOST:PORT`, `http://HOST:PORT` or `unix:PATH`; without it `SIGNORINI_SERVER` names
    it, and without that a server of our own starts and ends with this interpreter.
    """
    address, embedded = resolve(server)
    with _lock:
        if address not in _clients:
            _clients[address] = Client(address, embedded=embedded)
        return _clients[address]


def solve(scene: SceneLike, mesh: Any = None, *, server: str | None = None, **options: Any) -> Result:
    """Solves a scene; see `Client.solve` for the options."""
    return connect(server).solve(scene, mesh, **options)


def plan(scene: SceneLike, mesh: Any = None, *, server: str | None = None, **options: Any) -> Plan:
    """Plans a scene; see `Client.plan`."""
    return connect(server).plan(scene, mesh, **options)


def session(scene: SceneLike, mesh: Any = None, *, server: str | None = None, **options: Any) -> Session:
    """A session of a scene; see `Client.session` for the options."""
    return connect(server).session(scene, mesh, **options)


@atexit.register
def _close() -> None:
    for client in _clients.values():
        client.close()
    _clients.clear()
