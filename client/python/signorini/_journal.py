"""What one stream owes its user: lets a broken connection be replaced by another without losing or
repeating a result. No network, no clock.

Sequences have no gaps, so four numbers say where a session stands: `finished <= sent <= tail` (the
last one whose results are all here, the last one that the server has, the last one that the user
sent) and `seen`, the last result. Updates stay here until they are finished; a new connection
sends what the server did not accept.
"""

from __future__ import annotations

import copy
from collections import deque
from dataclasses import dataclass
from typing import Any

import numpy as np

from ._solution import Field, Fields, Increment, Iteration
from .errors import ProtocolError, RefusedError, ResultsLostError, SessionError, refusal
from .reports import IterationReport, StepReport
from .v1 import array_pb2, scene_pb2
from .v1 import session_service_pb2 as pb

CODES = {
    3: "INVALID_ARGUMENT",
    5: "NOT_FOUND",
    9: "FAILED_PRECONDITION",
    11: "OUT_OF_RANGE",
    12: "UNIMPLEMENTED",
}


@dataclass(frozen=True)
class Rejected:
    """An update that the server did not take."""

    sequence: int
    error: RefusedError


Event = Increment | Iteration | Rejected

ELEMENTS = {array_pb2.ELEMENT_TYPE_F64: "<f8", array_pb2.ELEMENT_TYPE_F32: "<f4"}


class Collector:
    """Puts results together from their messages."""

    def __init__(self) -> None:
        self.finished: Any = None
        self.fields = Fields()
        self.buffer: Any = None

    def take(self, message: Any) -> Event | None:
        """An event, when it is complete."""
        kind = message.WhichOneof("message")
        if kind == "step_finished":
            return self.begin(message.step_finished)
        if kind == "field":
            return self.add(message.field)
        if kind == "iteration":
            said = message.iteration
            return Iteration(said.sequence, IterationReport(said.report), said.skipped_count)
        if kind == "update_rejected":
            rejected = message.update_rejected
            code = CODES.get(rejected.status.code, str(rejected.status.code))
            return Rejected(rejected.sequence, refusal(rejected.status, code))
        if kind == "heartbeat":
            return None
        raise ProtocolError(f"an unexpected message: {kind}")

    def begin(self, finished: Any) -> Increment | None:
        """A result; its fields follow."""
        if self.finished is not None:
            raise ProtocolError("a result before the fields of the last one")
        self.finished, self.fields = finished, Fields()
        return None if finished.fields else self.complete()

    def add(self, chunk: Any) -> Increment | None:
        """A slice of a field; one that is whole is taken as it is."""
        if self.finished is None or chunk.event != self.finished.event:
            raise ProtocolError("a field without its result")
        if chunk.element_type not in ELEMENTS or len(chunk.data) % np.dtype(ELEMENTS[chunk.element_type]).itemsize:
            raise ProtocolError("a field that is not of whole numbers")
        values = np.frombuffer(chunk.data, ELEMENTS[chunk.element_type])
        whole = values if self.buffer is None and chunk.last else self.fill(chunk, values)
        if not chunk.last:
            return None
        shape = list(chunk.shape)
        if whole.size != int(np.prod(shape)):
            raise ProtocolError(f"a field of {whole.size} values for the shape {shape}")
        self.fields[name_of(chunk.field)] = whole.reshape(shape[:1] if shape[1:] == [1] else shape)
        self.buffer = None
        return self.complete() if len(self.fields) == len(self.finished.fields) else None

    def fill(self, chunk: Any, values: Field) -> Field:
        """Copies a slice to its place; memory grows with what arrives only."""
        if self.buffer is None:
            self.buffer = []
        if chunk.offset_elements != sum(map(len, self.buffer)):
            raise ProtocolError("slices of a field with a gap")
        self.buffer.append(values)
        return np.concatenate(self.buffer) if chunk.last else values

    def complete(self) -> Increment:
        """The result with its fields."""
        done, self.finished = self.finished, None
        return Increment(
            done.sequence, done.event, done.last, StepReport(done.report), self.fields, done.fields_dropped
        )


def name_of(number: int) -> str:
    """The name of a field."""
    known = scene_pb2.FieldName.DESCRIPTOR.values_by_number.get(number)
    return known.name.removeprefix("FIELD_NAME_").lower() if known else f"field-{number}"


class Journal:
    """Updates and results of one session's stream."""

    def __init__(self, opened: pb.StreamOpened, last_seen: int | None) -> None:
        session = opened.session
        self.collector = Collector()
        self.seen = opened.last_event if last_seen is None else min(last_seen, opened.last_event)
        # Whether the next result has to follow directly.
        self.contiguous = last_seen is None
        self.tail = self.sent = session.last_accepted_sequence
        self.finished = session.last_finished_sequence
        self.window = max(opened.max_in_flight, 1)
        self.updates: deque[tuple[int, pb.SolveRequest]] = deque()
        self.cancels: dict[int, bool] = {}
        # Sent after a rejected update; their own rejections are given already.
        self.doomed: set[int] = set()

    @property
    def answered(self) -> bool:
        """Whether every update is answered."""
        return not self.updates

    def update(self, request: pb.SolveRequest) -> int:
        """Takes an update and gives its sequence."""
        self.tail += 1
        kind = request.WhichOneof("message")
        getattr(request, str(kind)).sequence = self.tail
        self.updates.append((self.tail, request))
        return self.tail

    def cancel(self, sequence: int) -> None:
        """Asks for the end of an update."""
        if self.finished < sequence <= self.tail:
            self.cancels.setdefault(sequence, False)

    def requests(self) -> list[pb.SolveRequest]:
        """The messages that go to the server now."""
        due = []
        for sequence, request in self.updates:
            if self.sent < sequence <= self.finished + self.window:
                self.sent = sequence
                due.append(request)
        for sequence, gone in self.cancels.items():
            if not gone and sequence <= self.sent:
                self.cancels[sequence] = True
                due.append(pb.SolveRequest(cancel=pb.SolveCancel(sequence=sequence)))
        return due

    def take(self, message: Any) -> list[Event]:
        """Takes an answer and gives what the user shall see."""
        event = self.collector.take(message)
        if isinstance(event, Increment):
            return self.result(event)
        if isinstance(event, Rejected):
            return self.rejection(event)
        return [] if event is None else [event]

    def result(self, increment: Increment) -> list[Event]:
        """A result, each once."""
        if increment.event <= self.seen:
            return []
        if self.contiguous and increment.event != self.seen + 1:
            raise ResultsLostError(
                f"results {self.seen + 1} to {increment.event - 1} are lost: the server no longer keeps them"
            )
        self.contiguous, self.seen = True, increment.event
        if increment.last:
            self.finish(increment.sequence)
        return [increment]

    def finish(self, sequence: int) -> None:
        """Forgets an update that is answered."""
        self.finished = max(self.finished, sequence)
        while self.updates and self.updates[0][0] <= sequence:
            self.updates.popleft()
        self.cancels = {one: gone for one, gone in self.cancels.items() if one > sequence}

    def rejection(self, rejected: Rejected) -> list[Event]:
        """A rejected update takes those after it with it; their sequences are free again."""
        first = rejected.sequence
        if first in self.doomed:
            self.doomed.remove(first)
            return []
        events: list[Event] = [rejected]
        if not self.finished < first <= self.tail:
            return events
        for sequence, _ in [one for one in self.updates if one[0] > first]:
            if sequence <= self.sent:
                self.doomed.add(sequence)
            events.append(Rejected(sequence, gap(sequence, first)))
        self.updates = deque(one for one in self.updates if one[0] < first)
        self.tail = first - 1
        self.sent = min(self.sent, self.tail)
        self.cancels = {one: gone for one, gone in self.cancels.items() if one < first}
        return events

    def resume(self, opened: pb.StreamOpened) -> None:
        """Starts on a new connection."""
        if opened.last_event < self.seen:
            raise ProtocolError(f"the session has {opened.last_event} results and had {self.seen}")
        self.collector = Collector()
        self.contiguous = True
        self.sent = min(opened.session.last_accepted_sequence, self.tail)
        self.window = max(opened.max_in_flight, 1)
        self.doomed.clear()
        self.cancels = dict.fromkeys(self.cancels, False)


def gap(sequence: int, expected: int) -> RefusedError:
    """What the server answers to an update after a rejected one."""
    message = f"update {sequence} leaves a gap: {expected} is expected"
    return SessionError(message, "SEQUENCE_GAP", "OUT_OF_RANGE", {"expected": str(expected)})


def open_request(session: str, options: pb.SolveOpen, seen: int | None) -> pb.SolveRequest:
    """The first message of a connection."""
    request = copy.deepcopy(options)
    request.session = session
    if seen is not None:
        request.last_seen_event = seen
    return pb.SolveRequest(open=request)
