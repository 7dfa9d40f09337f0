"""Goals: their bounds, their derivatives, and both as functions of jax and torch."""

from __future__ import annotations

import asyncio
import runpy
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import signorini as s
from signorini import aio

EXAMPLE = Path(__file__).resolve().parents[1] / "examples" / "differentiable.py"
HARDNESS, DEPTH = "material.body.c10", "obstacle.press.translation.z"


@pytest.fixture(scope="module")
def example() -> dict[str, Any]:
    """What the example defines."""
    return runpy.run_path(str(EXAMPLE))


@pytest.fixture
def force(example: dict[str, Any]) -> Any:
    """Force of the press of a small block by hardness and depth."""
    return example["Goal"](s.example("mr-block"), "force.press.z", example["PARAMETERS"], **{"step.0.increments": 2})


def test_a_scene_of_classes_asks_for_bounds_and_derivatives() -> None:
    result = s.solve(
        s.example("mr-block"),
        set={
            "step.0.increments": 2,
            "step.0.obstacle.press.translation.2": -0.05,
            "gradient": [s.Gradient(of="force.press.z", to=[HARDNESS, DEPTH])],
            "accuracy": s.Accuracy(bound="force.press.z"),
        },
    )
    goal = result.goal("force.press.z")
    assert goal.bound is not None
    assert 0 < goal.bound.total < 0.2 * abs(goal.value)
    assert goal.value == pytest.approx(result.obstacles["press"].force[2], rel=1e-9)
    assert set(result.gradient("force.press.z")) == {HARDNESS, DEPTH}
    table = result.table()
    # The end of the step alone is asked about.
    assert table["goal.force.press.z.bound"] == [None, goal.bound.total]
    assert f"goal.force.press.z by {DEPTH}" in table


def test_the_example_finds_a_hardness(capsys: pytest.CaptureFixture[str]) -> None:
    runpy.run_path(str(EXAMPLE), run_name="__main__")
    assert "solves" in capsys.readouterr().out


def test_derivatives_are_those_of_differences(force: Any) -> None:
    place = np.array([0.4, -0.05])
    _, gradient = force(place)
    for axis in range(2):
        step = 1e-5 * np.eye(2)[axis]
        difference = (force(place + step)[0] - force(place - step)[0]) / 2e-5
        assert gradient[axis] == pytest.approx(difference, rel=1e-5)


def test_jax_differentiates_a_force(example: dict[str, Any], force: Any) -> None:
    jax = pytest.importorskip("jax")
    jax.config.update("jax_enable_x64", True)
    place = jax.numpy.array([0.4, -0.05])
    function = example["in_jax"](force)
    value, gradient = force(place)
    assert float(function(place)) == pytest.approx(value, rel=1e-12)
    twice = jax.jit(jax.grad(lambda x: function(x) ** 2))(place)
    np.testing.assert_allclose(twice, 2 * value * gradient, rtol=1e-9)


def test_torch_differentiates_a_force(example: dict[str, Any], force: Any) -> None:
    torch = pytest.importorskip("torch")
    place = torch.tensor([0.4, -0.05], dtype=torch.float64, requires_grad=True)
    value, gradient = force(place.detach().numpy())
    (example["in_torch"](force)(place) ** 2).backward()
    np.testing.assert_allclose(place.grad.numpy(), 2 * value * gradient, rtol=1e-9)


WITHIN = {"step.0.increments": 1, "step.0.obstacle.press.translation.2": -0.05}


def test_a_force_within_a_tolerance_is_that_of_a_refined_mesh() -> None:
    asked = s.Accuracy(force={"press": 0.02}, max_unknowns=2e5)
    result = s.solve(s.example("mr-block"), set={**WITHIN, "accuracy": asked})
    assert result.rounds[-1].end == "reached"
    last = result.rounds[-1].goals["force.press.z"]
    assert last.bound <= 0.02 * abs(last.value)
    assert result.mesh.cells.shape[0] == result.rounds[-1].cells
    goal = result.goal("force.press.z")
    assert goal.value == pytest.approx(last.value, rel=1e-6)
    assert goal.bound is not None
    assert goal.bound.total == pytest.approx(last.bound, rel=1e-3)


def test_a_limit_that_comes_first_is_a_warning() -> None:
    asked = s.Accuracy(force={"press": 1e-5}, max_rounds=1)
    with pytest.warns(s.SignoriniWarning, match="not reached: 1 meshes are allowed"):
        result = s.solve(s.example("mr-block"), set={**WITHIN, "accuracy": asked})
    assert result.rounds[-1].end == "max_rounds"


def test_the_asynchronous_twin_refines_the_mesh_too() -> None:
    asked = s.Accuracy(force={"press": 0.05})
    result = asyncio.run(aio.solve(s.example("mr-block"), set={**WITHIN, "accuracy": asked}))
    assert result.rounds[-1].end == "reached"
    assert result.mesh.cells.shape[0] == result.rounds[-1].cells
