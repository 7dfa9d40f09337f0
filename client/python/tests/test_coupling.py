"""Values by node, forces by node, saved states: what coupled codes exchange."""

from __future__ import annotations

import runpy
from pathlib import Path

import numpy as np
import pytest

import signorini as s

PRESSED = {"ball": (0, 0, -0.04)}


def test_two_coupled_sessions_are_the_body_in_one_piece(capsys: pytest.CaptureFixture[str]) -> None:
    path = Path(__file__).resolve().parents[1] / "examples" / "coupled.py"
    runpy.run_path(str(path), run_name="__main__")
    assert "relative difference" in capsys.readouterr().out


def test_the_same_steps_from_a_saved_state_give_the_same_bits(ball: s.Scene) -> None:
    with s.session(ball, fields=["displacement"]) as session:
        session.step(obstacles={"ball": (0, 0, -0.02)})
        saved = session.save()

        def two() -> list[bytes]:
            updates = [session.step(obstacles=PRESSED), session.move(ball=(0.01, 0, -0.03))]
            return [update.result().fields["displacement"].tobytes() for update in updates]

        first = two()
        session.restore(saved)
        assert two() == first
        with pytest.raises(s.errors.NotFoundError) as caught:
            session.restore(99)
        assert caught.value.reason == "STATE_NOT_FOUND"


def test_forces_by_node_sum_up_to_the_reaction(ball: s.Scene) -> None:
    with s.session(ball, fields=["nodal_force"]) as session:
        increment = session.step(obstacles=PRESSED).result()
        forces = increment.fields["nodal_force"]
        assert forces.shape == session.mesh.places.shape
        base = forces[session.mesh.nodes("z0")].sum(axis=0)
    force = increment.supports["base"].force
    assert base[2] == pytest.approx(force[2], rel=1e-9)


def test_arrays_files_and_constants_mean_the_same(ball: s.Scene, indent: s.Mesh, tmp_path: Path) -> None:
    nodes = indent.nodes("z0")
    rows = np.tile([0.0, 0.0, 0.01], (len(nodes), 1))
    values = s.Values(rows=rows, numbers=nodes)
    s.write_values(tmp_path / "lift.csv", values)
    ball.steps = [s.Step(obstacles={"ball": s.Move(translation=(0, 0, -0.03))})]
    base = ball.supports[0]
    assert isinstance(base, s.Support)
    base.displacement = {"x": 0.0, "y": 0.0, "z": 0.01}
    expected = s.solve(ball).obstacles["ball"].force
    base.displacement = {"x": 0.0, "y": 0.0, "z": 0.0}
    ways: list[s.scene.Given] = [values, rows, tmp_path / "lift.csv"]
    for way in ways:
        base.values = way
        np.testing.assert_allclose(s.solve(ball).obstacles["ball"].force, expected, rtol=1e-6, atol=1e-9)
    base.values = None
    ball.steps = [
        s.Step(obstacles={"ball": s.Move(translation=(0, 0, -0.03))}, supports={"base": s.SupportMove(values=values)})
    ]
    np.testing.assert_allclose(s.solve(ball).obstacles["ball"].force, expected, rtol=1e-6, atol=1e-9)


def test_tractions_and_body_forces_take_arrays_too(ball: s.Scene, indent: s.Mesh) -> None:
    ball.obstacles = []
    ball.tractions = [s.Traction(name="wind", on="z1", value=(0, 0, -0.01))]
    ball.body_force = (0, 0, -0.02)
    expected = s.solve(ball).supports["base"].force
    facets = np.asarray(indent.surfaces["z1"])
    wind = s.Values(rows=np.tile([0, 0, -0.01], (len(facets), 1)), numbers=facets, place="facets")
    weight = s.Values(rows=np.tile([0, 0, -0.02], (len(indent.cells), 1)), place="cells")
    ball.tractions = [s.Traction(name="wind", on="z1", values=wind)]
    ball.body_force = s.BodyForce(values=weight)
    np.testing.assert_allclose(s.solve(ball).supports["base"].force, expected, rtol=1e-6, atol=1e-9)
    ball.tractions, ball.body_force = [s.Traction(name="wind", on="z1", value=(0, 0, 0))], None
    step = {"tractions": {"wind": {"values": wind}}, "body_force": {"values": weight}}
    with s.session(ball) as session:
        found = session.step(step).result().supports["base"].force
    np.testing.assert_allclose(found, expected, rtol=1e-6, atol=1e-9)


def test_wrong_values_name_their_key(ball: s.Scene) -> None:
    with s.session(ball) as session:
        for values, said in [
            (np.zeros(3), "step.support.base.values: an array [rows, 3] is expected"),
            (s.Values(rows=np.zeros((2, 3)), numbers=[0.5, 1.5]), "step.support.base.values: 2 rows need"),
            (s.Values(rows=np.zeros((2, 3)), place="node"), "step.support.base.values: `node` is not known"),
            ("values.csv", "step.support.base.values: an array is expected"),
        ]:
            with pytest.raises(s.errors.SceneError, match="values") as caught:
                session.step(supports={"base": {"values": values}})
            assert str(caught.value).startswith(said)
        with pytest.raises(s.errors.SceneError) as refused:
            session.step(supports={"base": {"values": np.zeros((2, 3))}}).result()
        assert refused.value.violations[0].path == "step.support.base.values"
