from __future__ import annotations

import sys
from pathlib import Path

import pytest

import signorini as s

pandas = pytest.importorskip("pandas")


def keys(examples: Path) -> dict[str, object]:
    """The sphere on the smallest block, three depths."""
    return {
        "scene": str(examples / "hertz-sphere.toml"),
        "set": [f"mesh={examples / 'meshes' / 'indent_l1.msh'}", "solver.tolerance=1e-8"],
        "grid": [{"key": "step.0.obstacle.ball.translation.2", "from": -0.05, "to": -0.03, "count": 3}],
        "result": [{"name": "force", "of": "obstacles.ball.force.z"}],
    }


def test_a_study_is_a_frame_with_a_row_for_each_case(examples: Path, ball: s.Scene) -> None:
    frame = s.study(keys(examples), workers=2)
    assert frame["case"].tolist() == [0, 1, 2]
    assert frame["termination"].tolist() == ["converged"] * 3
    assert frame["step.0.obstacle.ball.translation.2"].tolist() == [-0.05, -0.04, -0.03]
    step = s.Step(obstacles={"ball": s.Move(translation=(0, 0, -0.05))})
    ball.steps = [step]
    # The same bits as through a session.
    assert frame["force"][0] == s.solve(ball).obstacles["ball"].force[2]


def test_a_study_of_the_examples_keeps_its_table_and_goes_on(examples: Path, tmp_path: Path) -> None:
    out = tmp_path / "hertz.csv"
    frame = s.study(examples / "studies" / "hertz.toml", out=out)
    assert len(frame) == 12
    again = s.study(examples / "studies" / "hertz.toml", out=out, resume=True)
    pandas.testing.assert_frame_equal(again, frame)
    pandas.testing.assert_frame_equal(s.read_study(out), frame)


def test_failed_cases_are_rows_and_wrong_keys_are_errors(examples: Path) -> None:
    study = keys(examples)
    study["grid"] = [{"key": "material.body.poisson_ratio", "values": [0.5, 0.6]}]
    frame = s.study(study)
    assert frame["termination"].tolist() == ["converged", "refused"]
    assert frame["cause"][1] == "SCENE_INVALID"
    assert pandas.isna(frame["force"][1])
    study["grid"] = [{"key": "material.body.poison_ratio", "values": [0.5]}]
    with pytest.raises(s.errors.SceneError) as caught:
        s.study(study)
    assert caught.value.violations[0].path == "material.body.poison_ratio"


def test_a_package_that_is_not_there_is_named(examples: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "polars", None)
    with pytest.raises(s.errors.PackageError, match="pip install polars"):
        s.study(keys(examples), frame="polars")
