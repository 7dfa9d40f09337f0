"""Calls to one server with one answer each: meshes, surfaces, sessions by name."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from typing import Any

from ._connection import ANSWER_SECONDS, PLAN_SECONDS, again, channel, route, typed
from ._encode import Problem
from ._options import resource
from ._refinement import is_asked, rounds_of
from ._surfaces import Surface
from .errors import NotFoundError
from .mesh import Mesh
from .v1 import (
    mesh_service_pb2,
    mesh_service_pb2_grpc,
    session_service_pb2_grpc,
    surface_service_pb2,
    surface_service_pb2_grpc,
)
from .v1 import session_service_pb2 as pb

__all__ = ["Calls"]


class Calls:
    """What a server is asked; threads may share it."""

    def __init__(self, address: str, *, embedded: bool = False) -> None:
        self.address = address
        self.embedded = embedded
        self.channel = channel(address)
        self.sessions_stub = session_service_pb2_grpc.SessionServiceStub(self.channel)  # type: ignore[no-untyped-call]
        self.meshes_stub = mesh_service_pb2_grpc.MeshServiceStub(self.channel)  # type: ignore[no-untyped-call]
        self.surfaces_stub = surface_service_pb2_grpc.SurfaceServiceStub(self.channel)  # type: ignore[no-untyped-call]

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

    def fine_enough(self, problem: Problem, session: str = "") -> Problem:
        """The problem on a mesh that is fine enough for its goals, which the server makes of the one it has.

        The same where the scene asks for none.
        """
        if not is_asked(problem.scene):
            return problem
        told = []
        with typed(self.address):
            request = mesh_service_pb2.RefineMeshRequest(scene=problem.scene)
            for message in self.meshes_stub.RefineMesh(request, metadata=route(session)):
                if message.HasField("round"):
                    told.append(message.round)
                elif message.HasField("refined"):
                    refined = message.refined
        mesh = self.read_mesh(refined.scene.mesh, session)
        return Problem(refined.scene, mesh, problem.surfaces, rounds_of(told, refined))

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
