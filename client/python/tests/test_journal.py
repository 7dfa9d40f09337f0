"""The book of a stream, without a network."""

from __future__ import annotations

import numpy as np
import pytest

import signorini as s
from signorini._journal import Collector, Increment, Journal, Rejected
from signorini.v1 import array_pb2, scene_pb2
from signorini.v1 import session_service_pb2 as pb


def opened(accepted: int = 0, finished: int = 0, event: int = 0, window: int = 64) -> pb.StreamOpened:
    session = pb.Session(last_accepted_sequence=accepted, last_finished_sequence=finished)
    return pb.StreamOpened(session=session, last_event=event, max_in_flight=window)


def update() -> pb.SolveRequest:
    return pb.SolveRequest(load_step=pb.LoadStepUpdate())


def finished(sequence: int, event: int, last: bool = True) -> pb.SolveResponse:
    return pb.SolveResponse(step_finished=pb.StepFinished(sequence=sequence, event=event, last=last))


def sequences(requests: list[pb.SolveRequest]) -> list[int]:
    return [one.load_step.sequence or -one.cancel.sequence for one in requests]


def test_no_more_updates_go_than_the_server_holds() -> None:
    journal = Journal(opened(window=2), None)
    assert [journal.update(update()) for _ in range(4)] == [1, 2, 3, 4]
    assert sequences(journal.requests()) == [1, 2]
    assert journal.requests() == []
    journal.take(finished(1, 1))
    assert sequences(journal.requests()) == [3]


def test_a_new_connection_sends_what_the_server_did_not_accept_and_drops_what_was_seen() -> None:
    journal = Journal(opened(), None)
    for _ in range(3):
        journal.update(update())
    journal.requests()
    assert len(journal.take(finished(1, 1))) == 1
    journal.resume(opened(accepted=2, event=2))
    assert sequences(journal.requests()) == [3]
    assert journal.take(finished(1, 1)) == []
    assert [one.sequence for one in journal.take(finished(2, 2))] == [2]
    assert not journal.answered
    journal.take(finished(3, 3))
    assert journal.answered


def test_results_that_are_gone_are_an_error() -> None:
    journal = Journal(opened(), None)
    journal.update(update())
    journal.resume(opened(event=5))
    with pytest.raises(s.errors.ResultsLostError, match="1 to 3"):
        journal.take(finished(1, 4))


def test_another_session_is_an_error() -> None:
    journal = Journal(opened(event=7), None)
    with pytest.raises(s.errors.ProtocolError, match="had 7"):
        journal.resume(opened(event=3))


def test_a_rejected_update_takes_those_behind_it_and_frees_their_sequences() -> None:
    journal = Journal(opened(), None)
    for _ in range(3):
        journal.update(update())
    journal.requests()
    rejected = pb.SolveResponse(update_rejected=pb.UpdateRejected(sequence=2))
    events = journal.take(rejected)
    assert [one.sequence for one in events] == [2, 3]
    assert isinstance(events[1], Rejected)
    assert events[1].error.reason == "SEQUENCE_GAP"
    assert journal.update(update()) == 2
    # The server's own word on the third comes later and is known.
    assert journal.take(pb.SolveResponse(update_rejected=pb.UpdateRejected(sequence=3))) == []


def test_a_cancel_follows_its_update_and_is_repeated_after_a_break() -> None:
    journal = Journal(opened(), None)
    journal.update(update())
    journal.cancel(1)
    assert sequences(journal.requests()) == [1, -1]
    journal.resume(opened(accepted=1))
    assert sequences(journal.requests()) == [-1]
    journal.take(finished(1, 1))
    journal.cancel(1)
    assert journal.requests() == []


def chunk(values: list[float], offset: int = 0, rows: int = 0, last: bool = True) -> pb.SolveResponse:
    return pb.SolveResponse(
        field=pb.FieldChunk(
            sequence=1,
            event=1,
            field=scene_pb2.FIELD_NAME_GAP,
            element_type=array_pb2.ELEMENT_TYPE_F64,
            shape=[rows or len(values), 1],
            offset_elements=offset,
            data=np.array(values).tobytes(),
            last=last,
        )
    )


def with_gap() -> Collector:
    collector = Collector()
    one = finished(1, 1)
    one.step_finished.fields.append(scene_pb2.FIELD_NAME_GAP)
    assert collector.take(one) is None
    return collector


def test_fields_are_put_together_from_slices() -> None:
    collector = with_gap()
    assert collector.take(chunk([1.0, 2.0], rows=3, last=False)) is None
    done = collector.take(chunk([3.0], offset=2, rows=3))
    assert isinstance(done, Increment)
    assert done.fields["gap"].tolist() == [1.0, 2.0, 3.0]
    with pytest.raises(s.errors.FieldError, match=r"there are gap: name it in `output\.fields`"):
        done.fields["stress"]


def test_slices_out_of_place_break_the_protocol() -> None:
    with pytest.raises(s.errors.ProtocolError, match="without its result"):
        Collector().take(chunk([1.0]))
    collector = with_gap()
    collector.take(chunk([1.0], rows=3, last=False))
    with pytest.raises(s.errors.ProtocolError, match="gap"):
        collector.take(chunk([2.0], offset=2, rows=3))
    with pytest.raises(s.errors.ProtocolError, match="shape"):
        with_gap().take(chunk([1.0], rows=2))
    with pytest.raises(s.errors.ProtocolError, match="before the fields"):
        with_gap().take(finished(1, 2))
