"""Tools from files press as the tools that they stand for."""

from __future__ import annotations

import asyncio
from pathlib import Path

import numpy as np
import pytest

import signorini as s
import signorini.aio


def distances(path: Path) -> Path:
    """The ball of the other tests, at nodes 0.1 apart."""
    origin, spacing = np.array([-1.3, -1.3, -0.3]), np.full(3, 0.1)
    x, y, z = np.meshgrid(*(first + 0.1 * np.arange(27) for first in origin), indexing="ij")
    s.write_grid(path, np.sqrt(x**2 + y**2 + (z - 1) ** 2) - 1, origin, spacing)
    return path


def heights(path: Path) -> Path:
    """Its lower cap."""
    x, y = np.meshgrid(*(-0.6 + 0.05 * np.arange(25),) * 2, indexing="ij")
    s.write_grid(path, 1 - np.sqrt(1 - x**2 - y**2), [-0.6, -0.6], [0.05, 0.05])
    return path


def octahedron(path: Path) -> Path:
    """An STL file of eight facets around (0, 0, 1)."""
    text = ["solid tool"]
    for signs in np.ndindex(2, 2, 2):
        corners = np.diag(1.0 - 2.0 * np.array(signs))
        corners = corners[::-1] if sum(signs) % 2 else corners
        lines = [f"vertex {x} {y} {z}" for x, y, z in corners + [0, 0, 1]]
        text += ["facet normal 0 0 0", "outer loop", *lines, "endloop", "endfacet"]
    path.write_text("\n".join([*text, "endsolid tool", ""]))
    return path


def pressed(scene: s.Scene, shape: s.scene.Shape) -> float:
    scene.obstacles = [s.Obstacle(name="ball", on="z1", shape=shape)]
    scene.steps = [s.Step(obstacles={"ball": s.Move(translation=(0, 0, -0.05))})]
    result = s.solve(scene).check()
    return float(result.obstacles["ball"].force[2])


def test_a_ball_on_a_grid_is_the_ball(ball: s.Scene, tmp_path: Path) -> None:
    exact = pressed(ball, s.Sphere(centre=(0, 0, 1), radius=1.0))
    for shape in (
        s.DistanceGrid(file=distances(tmp_path / "ball.grid")),
        s.HeightField(file=heights(tmp_path / "cap.grid"), inside=True),
    ):
        assert pressed(ball, shape) == pytest.approx(exact, rel=1e-4)
        assert s.plan(ball).as_dict()


def test_corners_that_differ_by_rounding_are_welded_within_a_tolerance(ball: s.Scene, tmp_path: Path) -> None:
    path = octahedron(tmp_path / "tool.stl")
    shape = s.Surface(file=path, facets=True)
    exact = pressed(ball, shape)
    lines = path.read_text().splitlines()
    vertices = [index for index, line in enumerate(lines) if line.startswith("vertex")]
    for index in vertices[::2]:
        lines[index] += "0002" if "." in lines[index].split()[-1] else ".00002"
    path.write_text("\n".join([*lines, ""]))
    with pytest.raises(s.SignoriniError, match="`weld`"):
        pressed(ball, shape)
    shape.weld = 1e-4
    assert pressed(ball, shape) == pytest.approx(exact, rel=1e-3)


def test_a_triangulated_tool_is_pressed(ball: s.Scene, tmp_path: Path) -> None:
    shape = s.Surface(file=octahedron(tmp_path / "tool.stl"), facets=True)
    assert pressed(ball, shape) < 0

    async def forces() -> float:
        async with signorini.aio.session(ball) as session:
            last = await (await session.step(obstacles={"ball": (0, 0, -0.05)})).result()
            return float(last.obstacles["ball"].force[2])

    assert asyncio.run(forces()) == pytest.approx(pressed(ball, shape), rel=1e-9)


def test_faults_of_files_are_told(ball: s.Scene, tmp_path: Path) -> None:
    cut = tmp_path / "cut.grid"
    cut.write_text("counts 4 4\norigin 0 0\nspacing 1 1\n0.5\n")
    with pytest.raises(s.errors.SceneError, match=r"cut\.grid: 1 numbers for 16 nodes"):
        pressed(ball, s.HeightField(file=cut))
    with pytest.raises(s.errors.SceneError, match="no grid of distances"):
        pressed(ball, s.DistanceGrid(file=heights(tmp_path / "cap.grid")))
    step = tmp_path / "step.grid"
    s.write_grid(step, np.repeat([[0.0], [0.0], [1.0], [1.0]], 4, axis=1), [0, 0], [1, 1])
    with pytest.raises(s.errors.SceneError, match="less than three spacings"):
        pressed(ball, s.HeightField(file=step))
    with pytest.raises(ValueError, match="two or three axes"):
        s.write_grid(step, np.zeros((4, 4)), [0, 0, 0], [1, 1])
