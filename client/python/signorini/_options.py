"""What sessions of both kinds, waiting and asynchronous, ask of a server: the same messages."""

from __future__ import annotations

import logging
import uuid
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from google.protobuf.duration_pb2 import Duration

from ._encode import Problem, StepLike, field_numbers, load_step, obstacle_targets
from ._journal import Event
from ._solution import Iteration
from .errors import SessionError
from .v1 import scene_pb2
from .v1 import session_service_pb2 as pb

log = logging.getLogger("signorini")

#: Fields of `solve` where the scene names none: those that pictures and curves show.
DEFAULT_FIELDS = ("displacement", "pressure", "contact_pressure", "gap", "contact_state", "contact_path")
#: The longest time that the contract knows, seconds: 30 days.
LONGEST = 30 * 24 * 3600
#: Time to live of sessions of our own server, which ends with us: one day.
EMBEDDED_TTL = 24 * 3600.0
#: How long a broken connection is tried again, seconds.
PATIENCE = 60.0


def duration(seconds: float | None) -> Duration | None:
    """Seconds as they travel."""
    if seconds is None:
        return None
    message = Duration()
    message.FromNanoseconds(round(seconds * 1e9))
    return message


@dataclass(frozen=True)
class Options:
    """How a session is made and followed."""

    fields: Sequence[str] | None = None
    name: str = ""
    ttl: float | None = None
    verify: bool = False
    iterations: float | None = None
    patience: float = PATIENCE
    #: Whether a session outlives its stream.
    keep: bool = False

    def named(self) -> Options:
        """With a name of the session: the client chooses it, so that its mesh can say whose it is."""
        return self if self.name else replace(self, name=f"s{uuid.uuid4().hex[:16]}")

    def create(self, problem: Problem, embedded: bool) -> pb.CreateSessionRequest:
        """Asks for a session; the scene gets the fields, so that they come after a break, too."""
        scene = scene_pb2.Scene()
        scene.CopyFrom(problem.scene)
        if self.fields is not None:
            scene.output.fields[:] = field_numbers(self.fields)  # type: ignore[assignment]
        if self.verify:
            scene.solver.verify = True
        ttl = self.ttl if self.ttl is not None or not embedded else EMBEDDED_TTL
        return pb.CreateSessionRequest(
            scene=scene, session_id=self.name, request_id=uuid.uuid4().hex, ttl=duration(ttl)
        )

    def wants(self, event: Event) -> bool:
        """Whether the user sees it: the server sends one iteration in any case."""
        return self.iterations is not None or not isinstance(event, Iteration)

    def open(self) -> pb.SolveOpen:
        """Attaches a stream. Iterations that nobody asked for are not sent."""
        interval = LONGEST if self.iterations is None else max(self.iterations, 1e-9)
        fields: Any = field_numbers(self.fields or ())
        return pb.SolveOpen(fields=fields, iteration_interval=duration(interval))


def default_fields(scene: scene_pb2.Scene) -> Sequence[str] | None:
    """Those of `solve`: the scene's, or the usual ones."""
    return None if scene.output.fields else DEFAULT_FIELDS


def steps_of(scene: scene_pb2.Scene) -> list[scene_pb2.step__pb2.LoadStep]:  # type: ignore[name-defined]
    """The steps of a scene; without any, one with all loads."""
    return list(scene.steps) or [load_step({})]


def step_request(step: Any, max_wall_time: float | None) -> pb.SolveRequest:
    """A load step."""
    message = step if hasattr(step, "DESCRIPTOR") else load_step(step)
    return pb.SolveRequest(load_step=pb.LoadStepUpdate(step=message, max_wall_time=duration(max_wall_time)))


def move_request(moves: Mapping[str, Any], increments: int | None, max_wall_time: float | None) -> pb.SolveRequest:
    """An update of obstacles."""
    update = pb.ObstacleUpdate(
        obstacles=obstacle_targets(moves), increments=increments, max_wall_time=duration(max_wall_time)
    )
    return pb.SolveRequest(obstacle_update=update)


def given_step(step: StepLike | None, keys: Mapping[str, Any]) -> Any:
    """A step given whole, or by its keys."""
    return keys if step is None else step


def resource(session: str) -> str:
    """The name of a session's resource."""
    return session if session.startswith("sessions/") else f"sessions/{session}"


def busy(error: Exception) -> bool:
    """Whether the server has not noticed yet that the old connection broke."""
    return isinstance(error, SessionError) and error.reason == "SESSION_BUSY"
