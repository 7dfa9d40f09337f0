"""The asynchronous twin: the same sessions on `grpc.aio`.

    async with signorini.aio.session("block.toml") as session:
        async for increment in await session.step(increments=10, obstacles={"ball": (0, 0, -0.05)}):
            print(increment.obstacles["ball"].force)

Every session has a connection of its own, in the loop that runs. Scenes and meshes are read in a
thread, so that the loop goes on meanwhile.
"""

from __future__ import annotations

import asyncio
import contextlib
from collections import deque
from collections.abc import AsyncIterator, Callable, Iterable, Mapping, Sequence
from types import TracebackType
from typing import Any

import grpc
import grpc.aio

from ._connection import ANSWER_SECONDS, PLAN_SECONDS, again_soon, channel, pauses, resolve, route, unanswered
from ._encode import Problem, SceneLike, StepLike, problem
from ._journal import Event, Journal, Rejected, open_request
from ._options import (
    PATIENCE,
    Options,
    busy,
    default_fields,
    given_step,
    log,
    move_request,
    step_request,
    steps_of,
)
from ._refinement import is_asked, rounds_of
from ._surfaces import Surface
from .client import tell
from .errors import ConnectionBrokenError, NotFoundError, SignoriniError, from_call
from .mesh import Mesh
from .reports import Plan
from .results import Increment, Iteration, Result
from .v1 import (
    mesh_service_pb2,
    mesh_service_pb2_grpc,
    session_service_pb2_grpc,
    surface_service_pb2,
    surface_service_pb2_grpc,
)
from .v1 import session_service_pb2 as pb

__all__ = ["Pending", "Session", "session", "solve"]


class Pending:
    """An update on its way; iterates over its increments as they come."""

    def __init__(self, session: Session, sequence: int) -> None:
        self.sequence = sequence
        self._session = session
        self._events: deque[Increment | Iteration] = deque()
        self._last: Increment | None = None
        self._error: SignoriniError | None = None
        # Events so far, handed over or not.
        self._taken = 0

    async def events(self) -> AsyncIterator[Increment | Iteration]:
        """Iterations and increments in order; iterations need `session(iterations=...)`."""
        while True:
            while self._events:
                yield self._events.popleft()
            if self._error is not None:
                raise self._error
            if self.done:
                return
            await self._session._advance(self)

    async def __aiter__(self) -> AsyncIterator[Increment]:
        """The increments in order."""
        async for event in self.events():
            if isinstance(event, Increment):
                yield event

    @property
    def done(self) -> bool:
        """Whether its last result is here."""
        return self._error is not None or (self._last is not None and self._last.last)

    async def result(self) -> Increment:
        """Waits for its last increment."""
        while not self.done:
            await self._session._advance(self)
        if self._error is not None:
            raise self._error
        assert self._last is not None
        return self._last

    async def cancel(self) -> None:
        """Ends it; its last good state is its result."""
        await self._session._cancel(self.sequence)

    def _take(self, event: Event) -> None:
        self._taken += 1
        if isinstance(event, Rejected):
            self._error = event.error
            return
        if isinstance(event, Increment):
            self._last = event
        self._events.append(event)


class Session:
    """A session and its stream; tasks of one loop may share it. Opened by `async with`."""

    def __init__(self, read: Callable[[], Problem], server: str | None, options: Options) -> None:
        #: Name on the server, `sessions/...`; empty before it is opened.
        self.name = ""
        self.plan: Plan
        self._read = read
        self._server = server
        self._options = options.named()
        self._pending: dict[int, Pending] = {}
        self._reading = asyncio.Lock()
        self._writing = asyncio.Lock()
        self._call: Any = None
        self._attached = False

    @property
    def mesh(self) -> Mesh:
        """The mesh of its scene."""
        return self._problem.mesh

    def collect(self, increments: Iterable[Increment]) -> Result:
        """Increments of this session as a result: its tables, curves and pictures."""
        return Result(self._problem.scene, self.mesh, self.plan, list(increments), self._problem.rounds)

    async def step(self, step: StepLike | None = None, *, max_wall_time: float | None = None, **keys: Any) -> Pending:
        """Sends a load step: a `Step`, a dictionary, or its keys (`increments`, `load`, `obstacles`, `supports`)."""
        return await self._send(step_request(given_step(step, keys), max_wall_time))

    async def move(
        self,
        moves: Mapping[str, Any] | None = None,
        *,
        increments: int | None = None,
        max_wall_time: float | None = None,
        **named: Any,
    ) -> Pending:
        """Moves obstacles at constant load: `move(ball=(0, 0, -0.05))`."""
        return await self._send(move_request({**(moves or {}), **named}, increments, max_wall_time))

    async def save(self) -> int:
        """Keeps the state after all updates sent so far, to go back to; its number."""
        await self._settle()
        answer = await self._ask(self._stub.SaveState, pb.SaveStateRequest(name=self.name))
        return int(answer.save)

    async def restore(self, save: int) -> None:
        """Goes back to a saved state: the same steps give the same bits from there."""
        await self._settle()
        await self._ask(self._stub.RestoreState, pb.RestoreStateRequest(name=self.name, save=save))

    async def _ask(self, method: Any, request: Any, timeout: float = ANSWER_SECONDS) -> Any:
        """The answer to a call about the session."""
        return await again_soon(
            self._address, lambda: method(request, timeout=timeout, metadata=route(self._options.name))
        )

    async def _settle(self) -> None:
        """Waits for every update that was sent."""
        for pending in list(self._pending.values()):
            while not pending.done:
                await self._advance(pending)

    async def __aenter__(self) -> Session:
        """Uploads the mesh where needed, makes the session and opens its stream."""
        self._problem = await asyncio.to_thread(self._read)
        self._address, embedded = await asyncio.to_thread(resolve, self._server)
        self._channel = channel(self._address, aio=True)
        self._stub = session_service_pb2_grpc.SessionServiceStub(self._channel)  # type: ignore[no-untyped-call]
        try:
            await self._open(embedded)
        except BaseException:
            await self._channel.close()
            raise
        return self

    async def _open(self, embedded: bool) -> None:
        await self._upload()
        await self._refine()
        request = self._options.create(self._problem, embedded)
        answer = await self._ask(self._stub.CreateSession, request, PLAN_SECONDS)
        self.name, self.plan = answer.session.name, Plan(answer.plan)
        self._journal = Journal(await again_soon(self._address, self._first), None)
        self._attached = True

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Ends the stream and forgets the session on the server."""
        self._abandon()
        try:
            await self._ask(self._stub.DeleteSession, pb.DeleteSessionRequest(name=self.name))
        except NotFoundError:
            pass
        except SignoriniError:
            if error is None:
                raise
        finally:
            await self._channel.close()

    async def _upload(self) -> None:
        meshes = mesh_service_pb2_grpc.MeshServiceStub(self._channel)  # type: ignore[no-untyped-call]
        mesh = self._problem.mesh
        try:
            await self._ask(meshes.GetMesh, mesh_service_pb2.GetMeshRequest(name=mesh.name))
        except NotFoundError:
            metadata = route(self._options.name)
            await again_soon(self._address, lambda: meshes.UploadMesh(mesh.requests(), metadata=metadata))
        for surface in self._problem.surfaces:
            await self._upload_surface(surface)

    async def _refine(self) -> None:
        """Lets the server refine the mesh where the scene asks for one that is fine enough."""
        if not is_asked(self._problem.scene):
            return
        meshes = mesh_service_pb2_grpc.MeshServiceStub(self._channel)  # type: ignore[no-untyped-call]
        metadata, told = route(self._options.name), []
        try:
            request = mesh_service_pb2.RefineMeshRequest(scene=self._problem.scene)
            async for message in meshes.RefineMesh(request, metadata=metadata):
                if message.HasField("round"):
                    told.append(message.round)
                elif message.HasField("refined"):
                    refined = message.refined
            reading = meshes.ReadMesh(mesh_service_pb2.ReadMeshRequest(name=refined.scene.mesh), metadata=metadata)
            parts = [part async for part in reading]
        except grpc.aio.AioRpcError as error:
            raise unanswered(from_call(error, self._address), self._address) from None
        mesh = Mesh.from_messages(parts[0].header, [part.chunk for part in parts[1:]])
        self._problem = Problem(refined.scene, mesh, self._problem.surfaces, rounds_of(told, refined))

    async def _upload_surface(self, surface: Surface) -> None:
        surfaces = surface_service_pb2_grpc.SurfaceServiceStub(self._channel)  # type: ignore[no-untyped-call]
        try:
            await self._ask(surfaces.GetSurface, surface_service_pb2.GetSurfaceRequest(name=surface.name))
        except NotFoundError:
            metadata = route(self._options.name)
            await again_soon(self._address, lambda: surfaces.UploadSurface(iter(surface.requests), metadata=metadata))

    async def _send(self, request: pb.SolveRequest) -> Pending:
        pending = Pending(self, self._journal.update(request))
        self._pending[pending.sequence] = pending
        await self._flush()
        return pending

    async def _cancel(self, sequence: int) -> None:
        self._journal.cancel(sequence)
        await self._flush()

    async def _flush(self) -> None:
        async with self._writing:
            if not self._attached:
                # Nothing may come before the first message of a connection.
                return
            for request in self._journal.requests():
                try:
                    await self._call.write(request)
                except (grpc.RpcError, asyncio.InvalidStateError):
                    # Reading says why; what was not sent is sent again.
                    return

    async def _advance(self, waiting: Pending) -> None:
        """Waits for the next answer of the server and hands its events over."""
        known = waiting._taken
        async with self._reading:
            # Another task may have read for this one meanwhile.
            if waiting._taken != known or waiting.done:
                return
            try:
                events = self._journal.take(await self._next())
            except ConnectionBrokenError as error:
                await self._reconnect(error)
                return
            for event in events:
                pending = self._pending.get(event.sequence)
                if pending is not None and self._options.wants(event):
                    pending._take(event)
                    if pending.done:
                        del self._pending[event.sequence]
            await self._flush()

    async def _next(self) -> Any:
        try:
            answer = await self._call.read()
        except grpc.RpcError as error:
            raise from_call(error, self._address) from None
        if answer is grpc.aio.EOF:
            raise ConnectionBrokenError("the stream ended before its answers")
        return answer

    async def _first(self) -> pb.StreamOpened:
        self._abandon()
        return await self._connect(None)

    async def _connect(self, seen: int | None) -> pb.StreamOpened:
        self._call = self._stub.Solve(metadata=route(self.name))
        with contextlib.suppress(grpc.RpcError, asyncio.InvalidStateError):
            # Reading says why.
            await self._call.write(open_request(self.name, self._options.open(), seen))
        first = await self._next()
        if first.WhichOneof("message") != "opened":
            raise SignoriniError("the first message `opened` is missing")
        opened: pb.StreamOpened = first.opened
        return opened

    async def _reconnect(self, error: SignoriniError) -> None:
        log.warning("%s; trying again", error)
        for pause in pauses(self._options.patience):
            await asyncio.sleep(pause)
            self._abandon()
            try:
                opened = await self._connect(self._journal.seen)
            except SignoriniError as again:
                if not (isinstance(again, ConnectionBrokenError) or busy(again)):
                    raise
                error = again
                continue
            self._journal.resume(opened)
            self._attached = True
            await self._flush()
            log.warning("connected again")
            return
        raise error

    def _abandon(self) -> None:
        self._attached = False
        if self._call is not None:
            self._call.cancel()


def session(
    scene: SceneLike,
    mesh: Any = None,
    *,
    server: str | None = None,
    fields: Sequence[str] | None = None,
    set: Mapping[str, Any] | None = None,
    name: str = "",
    ttl: float | None = None,
    iterations: float | None = None,
    patience: float = PATIENCE,
) -> Session:
    """A session of a scene, for `async with`; options as in `signorini.Client.session`."""
    options = Options(fields, name, ttl, iterations=iterations, patience=patience)
    return Session(lambda: problem(scene, mesh, set), server, options)


async def solve(
    scene: SceneLike,
    mesh: Any = None,
    *,
    server: str | None = None,
    fields: Sequence[str] | None = None,
    set: Mapping[str, Any] | None = None,
    verify: bool = False,
    patience: float = PATIENCE,
) -> Result:
    """Solves a scene; options as in `signorini.Client.solve`."""
    one = await asyncio.to_thread(problem, scene, mesh, set)
    wanted = fields if fields is not None else default_fields(one.scene)
    options = Options(fields=wanted, verify=verify, patience=patience)
    async with Session(lambda: one, server, options) as opened:
        pending = [await opened.step(step) for step in steps_of(one.scene)]
        increments = [increment for update in pending async for increment in update]
        result = opened.collect(increments)
    tell(result)
    return result
