"""Tables, curves, pictures and what a notebook shows."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import signorini as s


@pytest.fixture
def result(ball: s.Scene) -> s.Result:
    ball.steps = [s.Step(increments=3, obstacles={"ball": s.Move(translation=(0, 0, -0.05))})]
    return s.solve(ball)


def test_a_result_says_what_its_last_increment_says(result: s.Result) -> None:
    assert len(result) == 3
    assert result.converged
    assert result.check() is result
    np.testing.assert_array_equal(result.obstacles["ball"].force, result[-1].obstacles["ball"].force)
    assert set(result.fields) == {"displacement", "pressure", "contact_pressure", "gap", "contact_state"}
    assert "ball" in repr(result)


def test_travel_and_force_are_positive_where_the_tool_presses(result: s.Result) -> None:
    moved = result.travel("ball")
    assert moved is not None
    travel, force = moved
    np.testing.assert_allclose(travel, [0.05 / 3, 0.1 / 3, 0.05])
    assert all(np.diff(force) > 0)
    assert force[0] > 0


def test_the_pressure_along_a_section_sums_up_to_the_normal_force(result: s.Result, examples: Path) -> None:
    few = {"step.0.increments": 2, "step.0.obstacle.lid.translation": [0, -0.3, 0], "step.1.increments": 1}
    few["output.fields"] = ["contact_path"]
    ring = s.solve(examples / "o-ring.toml", set=few)
    squeezed = next(one for one in ring if one.report.step == 1 and one.last)
    arc, pressure = squeezed.contact_path("lid", interval=0)
    assert len(arc) == len(pressure) > 5
    assert all(np.diff(arc) > 0)
    place = squeezed.fields["contact_path"][squeezed.fields["contact_path"][:, 0] == 1]
    of_rings = 2 * np.pi * place[:, 4] * pressure
    force = float(np.diff(arc) @ (of_rings[1:] + of_rings[:-1])) / 2
    lid = squeezed.obstacles["lid"]
    assert lid.mean_pressure is not None
    assert force == pytest.approx(lid.mean_pressure * lid.deformed_contact_area, rel=0.05)
    with pytest.raises(KeyError, match="floor, lid, wall"):
        ring.contact_path("roof")
    with pytest.raises(KeyError, match="scenes in space have none"):
        result.contact_path("ball")


def test_the_table_has_a_row_an_increment(result: s.Result) -> None:
    table = result.table()
    assert {len(column) for column in table.values()} == {3}
    np.testing.assert_array_equal(table["ball.force_z"], result.forces("ball")[:, 2])


def test_a_step_that_does_not_converge_is_a_result_until_it_is_checked(ball: s.Scene) -> None:
    ball.steps = [s.Step(obstacles={"ball": s.Move(translation=(0, 0, -0.05))})]
    result = s.solve(ball, set={"solver.max_wall_time": 1e-6})
    assert not result.converged
    with pytest.raises(s.errors.NotConvergedError, match="deadline_exceeded"):
        result.check()
    assert "not converged" in result._repr_html_()


def test_doubts_are_warnings(ball: s.Scene) -> None:
    ball.steps = [s.Step(obstacles={"ball": s.Move(translation=(0, 0, -0.3))})]
    with pytest.warns(s.SignoriniWarning, match="strains"):
        result = s.solve(ball)
    assert "large_strain" in {one.kind for one in result.warnings}


def test_a_tool_that_goes_the_wrong_way_is_doubted(ball: s.Scene) -> None:
    ball.steps = [s.Step(obstacles={"ball": s.Move(translation=(0, 0, 0.5))})]
    with pytest.warns(s.SignoriniWarning, match="touched nothing in any increment"):
        result = s.solve(ball)
    assert [(one.kind, one.subject) for one in result.warnings] == [("untouched_obstacle", "ball")]


def test_a_tool_that_is_met_later_is_no_doubt(ball: s.Scene) -> None:
    at = [0.5, 0.25, -0.02]
    ball.steps = [s.Step(obstacles={"ball": s.Move(translation=(0, 0, z))}) for z in at]
    result = s.solve(ball)
    assert "untouched_obstacle" in {one.kind for one in result[1].report.warnings}
    assert result.warnings == []


def test_a_notebook_shows_a_table_and_a_curve(result: s.Result) -> None:
    page = result._repr_html_()
    assert page.count("<tr>") == 4
    pytest.importorskip("matplotlib")
    assert "<svg" in page


def test_curves_of_force_have_an_error_band(result: s.Result, tmp_path: Path) -> None:
    pytest.importorskip("matplotlib").use("Agg")
    axes = result.plot_force(file=tmp_path / "force.svg")
    assert len(axes.lines) == 1
    np.testing.assert_allclose(axes.lines[0].get_xdata()[-1], 0.05)
    assert (tmp_path / "force.svg").stat().st_size > 1000


@pytest.mark.parametrize("field", ["contact_pressure", "displacement", "pressure"])
def test_a_picture_shows_the_deformed_body(result: s.Result, tmp_path: Path, field: str) -> None:
    pyvista = pytest.importorskip("pyvista")
    file = tmp_path / "body.png"
    plotter = result.plot(field, file=file, size=(320, 240))
    values = np.concatenate([mesh["drawn"] for mesh in plotter.meshes if "drawn" in mesh.array_names])
    shown = result.fields[field][: len(result.mesh.points)]
    largest = np.abs(shown).max() if shown.ndim == 1 else np.linalg.norm(shown, axis=1).max()
    assert np.abs(values).max() == pytest.approx(largest)
    image = pyvista.read(file)
    assert np.ptp(image.active_scalars) > 100


def test_a_section_is_drawn_without_pyvista(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib").use("Agg")
    from signorini.plot import draw_section

    result = s.solve(
        s.example("o-ring"), set={"step": [{"load": 0.0, "obstacle": {"lid": {"translation": [0, -0.2, 0]}}}]}
    )
    for field in ("contact_pressure", "pressure"):
        draw_section(result, field, result.last, 1.0, tmp_path / f"{field}.png")
        assert (tmp_path / f"{field}.png").stat().st_size > 5000


def test_a_field_that_was_not_asked_for_is_told(result: s.Result) -> None:
    from signorini.plot import scalars

    for look in (lambda: scalars(result.last, "stress"), lambda: result.fields["stress"]):
        with pytest.raises(KeyError) as told:
            look()
        assert isinstance(told.value, s.errors.FieldError)
        assert str(told.value).startswith('no field "stress" in this increment, there are ')
        assert "`output.fields` of the scene" in str(told.value)
    assert result.fields.get("stress") is None
    with pytest.raises(s.errors.FieldError, match='"strss" is no field: known are displacement'):
        result.fields["strss"]
