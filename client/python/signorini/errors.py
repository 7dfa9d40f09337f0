"""What can go wrong, by kind; refusals of the service carry the reason of its contract."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from google.rpc import error_details_pb2, status_pb2

__all__ = [
    "AccessError",
    "ConnectionBrokenError",
    "DeadlineError",
    "FieldError",
    "GatewayError",
    "GoalError",
    "MeshError",
    "NotConvergedError",
    "NotFoundError",
    "PackageError",
    "ProgramError",
    "ProtocolError",
    "QuotaError",
    "RefusedError",
    "ResultsLostError",
    "SceneError",
    "ServerError",
    "SessionError",
    "ShutdownError",
    "SignoriniError",
    "SignoriniWarning",
    "UnreachableError",
    "UnsupportedError",
    "Violation",
]

DETAILS = "grpc-status-details-bin"


class SignoriniError(Exception):
    """Everything that this package raises of its own."""


class SignoriniWarning(UserWarning):
    """What a mechanic would doubt in a scene or in a result."""


class ProgramError(SignoriniError):
    """The program `signorini` is missing, does not start or gives no answer."""


class PackageError(SignoriniError, ImportError):
    """A package that is needed for what was asked is not there."""


class UnreachableError(SignoriniError):
    """No server answers at the address."""


class ConnectionBrokenError(SignoriniError):
    """The connection broke and no other took its place within the patience."""


class GatewayError(ConnectionBrokenError):
    """A proxy answers, and no server behind it, or the session goes on later or elsewhere."""


class ResultsLostError(SignoriniError):
    """Results that came while the connection was broken are no longer kept."""


class ProtocolError(SignoriniError):
    """The server's answer breaks the contract."""


class NotConvergedError(SignoriniError):
    """Raised by `Result.check()` only: not converging is a result, not an error."""


class GoalError(SignoriniError, KeyError):
    """A goal that a result has not: it was not asked for, or it has no answer."""

    def __str__(self) -> str:
        """The sentence; a `KeyError` would show it in quotes."""
        return str(self.args[0]) if self.args else ""


class FieldError(SignoriniError, KeyError):
    """A field that a result has not: it was not asked for, or there is none of that name."""

    def __str__(self) -> str:
        """The sentence; a `KeyError` would show it in quotes."""
        return str(self.args[0]) if self.args else ""


@dataclass(frozen=True)
class Violation:
    """One key of a scene that is wrong."""

    path: str
    message: str

    def __str__(self) -> str:
        """The path and what is wrong."""
        return f"{self.path}: {self.message}" if self.path else self.message


class RefusedError(SignoriniError):
    """The service says no."""

    def __init__(
        self,
        message: str,
        reason: str = "",
        code: str = "",
        metadata: dict[str, str] | None = None,
        violations: tuple[Violation, ...] = (),
    ) -> None:
        super().__init__(message)
        #: Reason of the contract, such as `SCENE_INVALID`; empty when it does not come from the service.
        self.reason = reason
        #: Canonical code of gRPC, such as `INVALID_ARGUMENT`.
        self.code = code
        #: Whatever is variable in the message.
        self.metadata = metadata or {}
        #: Keys of the scene that are wrong.
        self.violations = violations

    def __str__(self) -> str:
        """Every violation, else the message."""
        text = "\n".join(map(str, self.violations)) or super().__str__()
        return f"{text} ({self.reason})" if self.reason else text


class SceneError(RefusedError):
    """A scene, a tool of it or an update that is wrong; `violations` name the keys."""


class UnsupportedError(RefusedError):
    """A capability that the server does not have."""


class MeshError(RefusedError):
    """A mesh that is wrong, or in use."""


class NotFoundError(RefusedError):
    """No such mesh, tool, session or step, or not any more."""


class SessionError(RefusedError):
    """A session that is busy, failed, damaged, deleted or there already, or a state that it cannot begin with."""


class QuotaError(RefusedError):
    """No room: memory, queue, sessions, size of a message."""


class DeadlineError(RefusedError):
    """Time is up."""


class ShutdownError(RefusedError):
    """The server shuts down."""


class AccessError(RefusedError):
    """A token that the server does not know, or whose role does not do."""


class ServerError(RefusedError):
    """A defect of the server, or of its disk."""


BY_REASON: dict[str, type[RefusedError]] = {
    "SCENE_INVALID": SceneError,
    "REQUEST_INVALID": SceneError,
    "UNSUPPORTED_COMBINATION": UnsupportedError,
    "MESH_INVALID": MeshError,
    "MESH_DIGEST_MISMATCH": MeshError,
    "MESH_IN_USE": MeshError,
    "MESH_NOT_FOUND": NotFoundError,
    "SURFACE_INVALID": SceneError,
    "SURFACE_NOT_FOUND": NotFoundError,
    "SURFACE_IN_USE": SessionError,
    "REFINEMENT_FAILED": RefusedError,
    "SESSION_NOT_FOUND": NotFoundError,
    "SESSION_EXPIRED": NotFoundError,
    "SESSION_ELSEWHERE": SessionError,
    "STEP_NOT_FOUND": NotFoundError,
    "EVENT_NOT_FOUND": NotFoundError,
    "STATE_NOT_FOUND": NotFoundError,
    "STATE_INVALID": SessionError,
    "SEQUENCE_NOT_RETAINED": NotFoundError,
    "SESSION_EXISTS": SessionError,
    "SESSION_FAILED": SessionError,
    "SESSION_BUSY": SessionError,
    "SESSION_DELETED": SessionError,
    "SESSION_DAMAGED": SessionError,
    "MESH_DAMAGED": SessionError,
    "SURFACE_DAMAGED": SessionError,
    "STATE_DAMAGED": SessionError,
    "SEQUENCE_GAP": SessionError,
    "MEMORY_BUDGET": QuotaError,
    "QUEUE_FULL": QuotaError,
    "SESSION_LIMIT": QuotaError,
    "CALL_RATE": QuotaError,
    "MESSAGE_LIMIT": QuotaError,
    "STREAM_DEADLINE": DeadlineError,
    "STREAM_UNREAD": ShutdownError,
    "SHUTTING_DOWN": ShutdownError,
    "DATA_UNWRITABLE": ServerError,
    "UNAUTHENTICATED": AccessError,
    "PERMISSION_DENIED": AccessError,
    "INTERNAL": ServerError,
}

# What gRPC tells of a page of HTML in place of an answer.
PAGES = ("status: 502", "status: 503", "status: 504", "status code 502", "status code 503", "status code 504")
# A stream that is reset by itself: by a proxy that found no server, and goes on answering.
RESET = "Received RST_STREAM"
# Codes that the transport gives by itself when a connection breaks.
TRANSPORT = {"UNAVAILABLE", "INTERNAL", "UNKNOWN", "CANCELLED"}


def refusal(status: Any, code: str) -> RefusedError:
    """A `google.rpc.Status` as the exception of its reason."""
    reason, metadata = "", {}
    violations: tuple[Violation, ...] = ()
    for detail in status.details:
        info, request = error_details_pb2.ErrorInfo(), error_details_pb2.BadRequest()
        if detail.Unpack(info):
            reason, metadata = info.reason, dict(info.metadata)
        elif detail.Unpack(request):
            violations = tuple(Violation(one.field, one.description) for one in request.field_violations)
    kind = BY_REASON.get(reason, RefusedError)
    return kind(status.message, reason, code, metadata, violations)


def from_call(error: Any, address: str) -> SignoriniError:
    """The exception of a call that failed; broken connections are `ConnectionBrokenError`."""
    code, message = error.code().name, error.details() or ""
    # Not `dict(...)`: metadata of older asynchronous calls have keys, and no look-up by them.
    details = next((value for key, value in error.trailing_metadata() or () if key == DETAILS), None)
    if details is not None:
        refused = refusal(status_pb2.Status.FromString(details), code)
        # The session is in the data folder of a server that is being restarted, or whose disk is full.
        if refused.metadata.get("resumes") == "true":
            return GatewayError(f"the server at {address} broke off: {message}")
        return refused
    if code == "DEADLINE_EXCEEDED":
        return UnreachableError(f"the server at {address} does not answer in time")
    if code == "CANCELLED" or (code in TRANSPORT and any(part in message for part in (*PAGES, RESET))):
        return GatewayError(f"a proxy at {address} answers, and no server behind it: {message}")
    if code in TRANSPORT:
        return ConnectionBrokenError(f"the connection to {address} broke: {message}")
    return RefusedError(message, code=code)
