"""A connection to one server: meshes, plans, sessions, solves."""

from __future__ import annotations

import atexit
import contextlib
import threading
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from ._connection import ANSWER_SECONDS, PLAN_SECONDS, again, channel, resolve, route, typed
from ._encode import Problem, SceneLike, problem
from ._options import PATIENCE, Options, default_fields, resource, steps_of
from ._surfaces import Surface
from .errors import NotFoundError, SignoriniWarning
from .mesh import Mesh
from .reports import Plan
from .results import Increment, Result
from .v1 import (
    mesh_service_pb2,
    mesh_service_pb2_grpc,
    session_service_pb2_grpc,
    surface_service_pb2,
    surface_service_pb2_grpc,
)
from .v1 import session_service_pb2 as pb

if TYPE_CHECKING:
    from ._session import Session

__all__ = ["Client", "connect", "plan", "session", "solve"]


class Client:
    """A connection to a server; threads may share it."""

    def __init__(self, address: str, *, embedded: bool = False) -> None:
        self.address = address
        self.embedded = embedded
        self.channel = channel(address)
        self.sessions_stub = session_service_pb2_grpc.SessionServiceStub(self.channel)  # type: ignore[no-untyped-call]
        self.meshes_stub = mesh_service_pb2_grpc.MeshServiceStub(self.channel)  # type: ignore[no-untyped-call]
        self.surfaces_stub = surface_service_pb2_grpc.SurfaceServiceStub(self.channel)  # type: ignore[no-untyped-call]

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
        from ._session import create

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

    def plan(self, scene: SceneLike, mesh: Any = None, *, set: Mapping[str, Any] | None = None) -> Plan:
        """What a scene needs, what is left out and why; nothing is solved."""
        one = problem(scene, mesh, set)
        self.upload_problem(one)
        request = Options().create(one, self.embedded)
        request.validate_only = True
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
        from ._session import create

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
        from ._session import attach

        return attach(self, name, Options(fields, iterations=iterations, patience=patience, keep=True))

    def upload(self, mesh: Mesh, session: str = "") -> str:
        """Makes sure that the server has a mesh, the one of a session where it is for one; its name there."""
        request = mesh_service_pb2.GetMeshRequest(name=mesh.name)
        try:
            self._call(self.meshes_stub.GetMesh, request, session)
        except NotFoundError:
            again(self.address, lambda: self.meshes_stub.UploadMesh(mesh.requests(), metadata=route(session)))
        return mesh.name

    def upload_problem(self, problem: Problem, session: str = "") -> None:
        """Makes sure that the server has the mesh and the tools of a scene."""
        self.upload(problem.mesh, session)
        for surface in problem.surfaces:
            self._upload_surface(surface, session)

    def _upload_surface(self, surface: Surface, session: str) -> None:
        upload = self.surfaces_stub.UploadSurface
        try:
            self._call(self.surfaces_stub.GetSurface, surface_service_pb2.GetSurfaceRequest(name=surface.name), session)
        except NotFoundError:
            again(self.address, lambda: upload(iter(surface.requests), metadata=route(session)))

    def read_mesh(self, name: str, session: str = "") -> Mesh:
        """The arrays of a stored mesh."""
        with typed(self.address):
            request = mesh_service_pb2.ReadMeshRequest(name=name)
            answers = self.meshes_stub.ReadMesh(request, metadata=route(session))
            header = next(answers).header
            return Mesh.from_messages(header, [one.chunk for one in answers])

    def create(self, request: pb.CreateSessionRequest) -> pb.CreateSessionResponse:
        """Sends a request for a session."""
        create = self.sessions_stub.CreateSession
        answer: pb.CreateSessionResponse = self._call(create, request, request.session_id, PLAN_SECONDS)
        return answer

    def get_session(self, name: str) -> pb.Session:
        """What the server says of a session."""
        request = pb.GetSessionRequest(name=resource(name))
        session: pb.Session = self._call(self.sessions_stub.GetSession, request, name).session
        return session

    def sessions(self) -> Iterator[pb.Session]:
        """All sessions in order of their names."""
        token = ""
        while True:
            page = self._call(self.sessions_stub.ListSessions, pb.ListSessionsRequest(page_token=token))
            yield from page.sessions
            token = page.next_page_token
            if not token:
                return

    def delete_session(self, name: str) -> None:
        """Cancels what runs and forgets a session; one that is gone is no fault."""
        with contextlib.suppress(NotFoundError):
            self._call(self.sessions_stub.DeleteSession, pb.DeleteSessionRequest(name=resource(name)), name)

    def cancel(self, name: str, sequence: int = 0) -> int:
        """Cancels a step of a session; its sequence, 0 when none runs."""
        request = pb.CancelStepRequest(name=resource(name), sequence=sequence)
        return int(self._call(self.sessions_stub.CancelStep, request, name).sequence)

    def save(self, name: str) -> int:
        """Keeps the state of a session to go back to; its number. A session keeps the newest eight.

        Where a proxy loses the answer, a save that nobody has the number of may be one of them.
        """
        request = pb.SaveStateRequest(name=resource(name))
        return int(self._call(self.sessions_stub.SaveState, request, name).save)

    def restore(self, name: str, save: int) -> None:
        """Goes back to a saved state of a session."""
        request = pb.RestoreStateRequest(name=resource(name), save=save)
        self._call(self.sessions_stub.RestoreState, request, name)

    def _call(self, method: Any, request: Any, session: str = "", timeout: float = ANSWER_SECONDS) -> Any:
        """The answer to a call about a session, or about none."""
        return again(self.address, lambda: method(request, timeout=timeout, metadata=route(session)))

    def close(self) -> None:
        """Ends the connection."""
        self.channel.close()

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
    for message in [*result.plan.warnings, *doubts]:
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
