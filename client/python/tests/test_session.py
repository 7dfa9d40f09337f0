"""Sessions: steps, updates, live iterations, refusals, cancels, breaks of the connection."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import Proxy

import signorini as s

DEEP = {"ball": (0, 0, -0.05)}


def test_increments_come_one_by_one_with_their_fields(ball: s.Scene) -> None:
    with s.session(ball, fields=["displacement", "contact_pressure"]) as session:
        update = session.step(increments=3, obstacles=DEEP)
        increments = list(update)
        assert [one.report.increment for one in increments] == [1, 2, 3]
        assert update.done
        last = increments[-1]
        assert update.result() is last
    assert last.obstacles["ball"].force[2] == pytest.approx(-0.0183, rel=1e-2)
    displacement, pressure = last.fields["displacement"], last.fields["contact_pressure"]
    assert displacement.shape[1] == 3
    assert pressure.shape == (len(displacement),)
    # The bytes of the message, not a copy.
    assert not displacement.flags.owndata
    assert not displacement.flags.writeable
    assert pressure.max() == pytest.approx(last.obstacles["ball"].max_pressure, rel=1e-12)


def test_a_session_is_gone_when_it_is_left(ball: s.Scene) -> None:
    with s.session(ball) as session:
        assert session.name in {one.name for one in s.connect().sessions()}
    assert session.name not in {one.name for one in s.connect().sessions()}
    with pytest.raises(s.SignoriniError, match="closed"):
        session.step(obstacles=DEEP).result()


def test_iterations_are_live_where_they_are_asked_for(ball: s.Scene) -> None:
    with s.session(ball, iterations=0) as session:
        events = list(session.step(increments=2, obstacles=DEEP).events())
    iterations = [one for one in events if isinstance(one, s.Iteration)]
    assert iterations
    assert isinstance(events[-1], s.Increment)
    assert iterations[0].report.residuals.equilibrium > 0
    with s.session(ball) as session:
        assert all(isinstance(one, s.Increment) for one in session.step(obstacles=DEEP).events())


def test_updates_may_go_ahead_of_their_results(ball: s.Scene) -> None:
    depths = 0.04 + 0.0001 * np.arange(100)
    with s.session(ball) as session:
        updates = [session.move(ball=(0, 0, -depth)) for depth in depths]
        forces = [update.result().obstacles["ball"].force[2] for update in updates]
    assert len(forces) == 100
    assert all(np.diff(forces) < 0)


def test_a_refused_update_is_an_error_of_its_own_and_the_session_goes_on(ball: s.Scene) -> None:
    with s.session(ball) as session:
        wrong = session.move(bal=(0, 0, -0.01))
        behind = session.move(ball=(0, 0, -0.01))
        with pytest.raises(s.errors.SceneError) as caught:
            wrong.result()
        assert "did you mean `ball`" in caught.value.violations[0].message
        assert caught.value.reason == "SCENE_INVALID"
        with pytest.raises(s.errors.SessionError) as caught_behind:
            behind.result()
        assert caught_behind.value.reason == "SEQUENCE_GAP"
        assert session.move(ball=(0, 0, -0.01)).result().converged


def test_a_cancelled_step_gives_its_last_good_state(ball: s.Scene) -> None:
    with s.session(ball) as session:
        update = session.step(increments=10_000, obstacles=DEEP)
        next(iter(update))
        update.cancel()
        last = update.result()
        assert last.report.termination == "cancelled"
        assert session.move(ball=(0, 0, -0.01)).result().converged


def test_a_detached_session_is_found_again_with_its_state(ball: s.Scene) -> None:
    session = s.session(ball, name="detached-ball")
    session.step(increments=2, obstacles=DEEP)
    name = session.detach()
    client = s.connect()
    with client.attach(name, fields=["gap"]) as again:
        increment = again.move(ball=(0, 0, -0.051)).result()
        assert increment.report.step == 2
        assert "gap" in increment.fields
    client.delete_session(name)
    with pytest.raises(s.errors.NotFoundError):
        client.get_session(name)


def test_a_break_loses_and_repeats_nothing(ball: s.Scene, proxy: Proxy) -> None:
    depths = 0.03 + 0.001 * np.arange(30)
    with s.session(ball) as session:
        expected = [session.move(ball=(0, 0, -depth)).result().obstacles["ball"].force for depth in depths]
    client = s.Client(proxy.address)
    with client.session(ball, fields=["contact_pressure"]) as session:
        updates = [session.move(ball=(0, 0, -depth)) for depth in depths]
        forces = []
        for index, update in enumerate(updates):
            if index % 10 == 5:
                proxy.break_connections()
            increment = update.result()
            assert increment.fields["contact_pressure"].max() > 0
            forces.append(increment.obstacles["ball"].force)
    np.testing.assert_allclose(forces, expected, rtol=1e-6, atol=1e-9)
    assert proxy.connections > 3
    client.close()


def test_a_break_without_an_end_is_told(ball: s.Scene, proxy: Proxy) -> None:
    client = s.Client(proxy.address)
    session = client.session(ball, patience=0.5)
    assert session.move(ball=(0, 0, -0.01)).result().converged
    proxy.close()
    with pytest.raises(s.errors.ConnectionBrokenError):
        session.move(ball=(0, 0, -0.02)).result()
    client.close()
    s.connect().delete_session(session.name)
