"""Sessions: a body under a scene whose state stays on the server, driven step by step.

A connection that breaks is replaced inside: updates that the server did not get are sent again,
results come once. One thread drives a session; `cancel` may come from any.
"""

from __future__ import annotations

import queue
import time
from collections import deque
from collections.abc import Iterable, Iterator, Mapping
from types import TracebackType
from typing import Any

import grpc

from ._calls import Calls
from ._connection import again, pauses, route
from ._encode import Problem, StepLike
from ._journal import Event, Journal, Rejected, open_request
from ._options import Options, busy, given_step, log, move_request, step_request
from .errors import ConnectionBrokenError, SignoriniError, from_call
from .reports import Plan
from .results import Increment, Iteration, Result
from .v1 import session_service_pb2 as pb

__all__ = ["Pending", "Session"]


class Pending:
    """An update on its way; iterates over its increments as they come."""

    def __init__(self, session: Session, sequence: int) -> None:
        self.sequence = sequence
        self._session = session
        self._events: deque[Increment | Iteration] = deque()
        self._last: Increment | None = None
        self._error: SignoriniError | None = None

    def events(self) -> Iterator[Increment | Iteration]:
        """Iterations and increments in order; iterations need `Session(iterations=...)`."""
        while True:
            while self._events:
                yield self._events.popleft()
            if self._error is not None:
                raise self._error
            if self.done:
                return
            self._session._advance()

    def __iter__(self) -> Iterator[Increment]:
        """The increments in order."""
        return (event for event in self.events() if isinstance(event, Increment))

    @property
    def done(self) -> bool:
        """Whether its last result is here."""
        return self._error is not None or (self._last is not None and self._last.last)

    def result(self) -> Increment:
        """Waits for its last increment."""
        while not self.done:
            self._session._advance()
        if self._error is not None:
            raise self._error
        assert self._last is not None
        return self._last

    def cancel(self) -> None:
        """Ends it; its last good state is its result."""
        self._session._cancel(self.sequence)

    def _take(self, event: Event) -> None:
        if isinstance(event, Rejected):
            self._error = event.error
            return
        if isinstance(event, Increment):
            self._last = event
        self._events.append(event)


class Session:
    """A session and its stream. Made by `signorini.session` and `Client.session`."""

    def __init__(self, client: Calls, name: str, problem: Problem, plan: Plan, options: Options) -> None:
        #: Name on the server, `sessions/...`.
        self.name = name
        self.scene = problem.scene
        self.mesh = problem.mesh
        #: Meshes on the way to this one, where the scene asks for one that is fine enough.
        self.rounds = problem.rounds
        self.plan = plan
        self._client = client
        self._options = options
        self._keep = options.keep
        self._pending: dict[int, Pending] = {}
        self._requests: queue.SimpleQueue[pb.SolveRequest | None] = queue.SimpleQueue()
        self._call: Any = None
        self._journal = Journal(again(client.address, self._first), None)

    def step(self, step: StepLike | None = None, *, max_wall_time: float | None = None, **keys: Any) -> Pending:
        """Sends a load step: a `Step`, a dictionary, or its keys (`increments`, `load`, `obstacles`, `supports`)."""
        return self._send(step_request(given_step(step, keys), max_wall_time))

    def move(
        self,
        moves: Mapping[str, Any] | None = None,
        *,
        increments: int | None = None,
        max_wall_time: float | None = None,
        **named: Any,
    ) -> Pending:
        """Moves obstacles at constant load: `move(ball=(0, 0, -0.05))`, `move({"ball": Move(...)})`."""
        return self._send(move_request({**(moves or {}), **named}, increments, max_wall_time))

    def collect(self, increments: Iterable[Increment]) -> Result:
        """Increments of this session as a result: its tables, curves and pictures."""
        return Result(self.scene, self.mesh, self.plan, list(increments), self.rounds)

    def cancel(self) -> int:
        """Cancels the step that runs, from any thread; its sequence, 0 when none runs."""
        return self._client.cancel(self.name)

    def save(self) -> int:
        """Keeps the state after all updates sent so far, to go back to; its number.

        A session keeps the newest eight.
        """
        self._settle()
        return self._client.save(self.name)

    def restore(self, save: int) -> None:
        """Goes back to a saved state: the same steps give the same bits from there."""
        self._settle()
        self._client.restore(self.name, save)

    def close(self) -> None:
        """Ends the stream and, unless it is kept, the session on the server."""
        self._abandon()
        if not self._keep:
            self._keep = True
            self._client.delete_session(self.name)

    def detach(self) -> str:
        """Leaves the session, with every update that was sent, to the server and gives its name."""
        while self._journal.sent < self._journal.tail:
            self._advance()
        while self._client.get_session(self.name).last_accepted_sequence < self._journal.tail:
            time.sleep(0.01)
        self._keep = True
        self._abandon()
        return self.name

    def __enter__(self) -> Session:
        """Itself."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Closes it; what went wrong before is more telling than a failure to close."""
        try:
            self.close()
        except SignoriniError:
            if error is None:
                raise

    def __repr__(self) -> str:
        return f"Session({self.name} on {self._client.address}, {len(self._pending)} updates on their way)"

    def _settle(self) -> None:
        """Waits for every update that was sent."""
        while self._pending:
            self._advance()

    def _send(self, request: pb.SolveRequest) -> Pending:
        pending = Pending(self, self._journal.update(request))
        self._pending[pending.sequence] = pending
        self._flush()
        return pending

    def _cancel(self, sequence: int) -> None:
        self._journal.cancel(sequence)
        self._flush()

    def _flush(self) -> None:
        for request in self._journal.requests():
            self._requests.put(request)

    def _advance(self) -> None:
        """Waits for the next answer of the server and hands its events over."""
        try:
            events = self._journal.take(self._next())
        except ConnectionBrokenError as error:
            self._reconnect(error)
            return
        for event in events:
            pending = self._pending.get(event.sequence)
            if pending is not None and self._options.wants(event):
                pending._take(event)
                if pending.done:
                    del self._pending[event.sequence]
        self._flush()

    def _next(self) -> Any:
        if self._call is None:
            raise SignoriniError(f"the stream of {self.name} is closed")
        try:
            return next(self._call)
        except StopIteration:
            raise ConnectionBrokenError("the stream ended before its answers") from None
        except grpc.RpcError as error:
            raise from_call(error, self._client.address) from None

    def _first(self) -> pb.StreamOpened:
        self._abandon()
        return self._connect(None)

    def _connect(self, seen: int | None, timeout: float | None = None) -> pb.StreamOpened:
        """Opens the stream; `opened` comes before any work."""
        requests: queue.SimpleQueue[pb.SolveRequest | None] = queue.SimpleQueue()
        self._requests = requests
        requests.put(open_request(self.name, self._options.open(), seen))
        self._call = self._client.sessions_stub.Solve(iter(requests.get, None), metadata=route(self.name))
        first = self._next()
        if first.WhichOneof("message") != "opened":
            raise SignoriniError("the first message `opened` is missing")
        opened: pb.StreamOpened = first.opened
        return opened

    def _reconnect(self, error: SignoriniError) -> None:
        log.warning("%s; trying again", error)
        for pause in pauses(self._options.patience):
            time.sleep(pause)
            self._abandon()
            try:
                opened = self._connect(self._journal.seen)
            except SignoriniError as again:
                if not (isinstance(again, ConnectionBrokenError) or busy(again)):
                    raise
                error = again
                continue
            self._journal.resume(opened)
            self._flush()
            log.warning("connected again")
            return
        raise error

    def _abandon(self) -> None:
        self._requests.put(None)
        if self._call is not None:
            self._call.cancel()
            self._call = None


def create(client: Calls, problem: Problem, options: Options) -> Session:
    """Uploads the mesh where needed, makes the session and opens its stream."""
    options = options.named()
    client.upload_problem(problem, options.name)
    problem = client.fine_enough(problem, options.name)
    answer = client.create(options.create(problem, client.embedded))
    return Session(client, answer.session.name, problem, Plan(answer.plan), options)


def attach(client: Calls, name: str, options: Options) -> Session:
    """Opens the stream of a session that is there; leaving it does not delete it."""
    session = client.get_session(name)
    problem = Problem(session.scene, client.read_mesh(session.mesh, name))
    return Session(client, session.name, problem, Plan(session.plan), options)
