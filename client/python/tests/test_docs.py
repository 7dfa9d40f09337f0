"""Every Python snippet of READMEs and manual runs, and prints the numbers that stand beside it."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import signorini as s

CLIENT = Path(__file__).resolve().parents[2]
PAGES = sorted([CLIENT.parent / "README.md", *CLIENT.glob("*/README.md"), *CLIENT.glob("manual/*.md")])
SNIPPET = re.compile(r"^```python\n(.*?)^```", re.MULTILINE | re.DOTALL)
OWN = CLIENT / "python" / "README.md"


def snippets(page: Path) -> list[str]:
    """The Python of a page."""
    return SNIPPET.findall(page.read_text())


def test_every_page_with_python_is_run_here() -> None:
    counts = {page.relative_to(CLIENT.parent).as_posix(): len(snippets(page)) for page in PAGES}
    assert {name: count for name, count in counts.items() if count} == {
        "README.md": 1,
        "client/manual/first-seal.md": 2,
        "client/manual/scenes.md": 1,
        "client/python/README.md": 4,
    }


def run(code: str, names: dict[str, Any]) -> None:
    """Runs a snippet as a user would, with these names at hand."""
    exec(compile(code, "snippet", "exec"), names)


def test_the_readme_of_the_repository(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(CLIENT.parent)
    names: dict[str, Any] = {}
    run(snippets(CLIENT.parent / "README.md")[0], names)
    assert names["r"].check().obstacles["lid"].force[1] < -1000
    assert capsys.readouterr().out.startswith("[")


def test_the_first_lines(tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("matplotlib").use("Agg")
    monkeypatch.chdir(tmp_path)
    code, names = snippets(OWN)[0], {}
    with warnings.catch_warnings():
        # The first thing that a user runs doubts nothing.
        warnings.simplefilter("error")
        run(code, names)
    told = [float(one) for one in re.findall(r"-?\d+\.?\d*", code.split("# [", 1)[1].split("]")[0])]
    # To the digits that the comment has.
    np.testing.assert_allclose(names["r"].obstacles["lid"].force, told, atol=0.5)
    assert capsys.readouterr().out.startswith("[")
    assert (tmp_path / "o-ring.png").stat().st_size > 5000


@pytest.fixture
def scene(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> s.Scene:
    """The scene of classes of the README, after it has been solved there."""
    shutil.copy(CLIENT / "examples" / "meshes" / "o-ring.msh", tmp_path / "o-ring.msh")
    monkeypatch.chdir(tmp_path)
    names: dict[str, Any] = {"s": s}
    run(snippets(OWN)[1], names)
    # The literature's range for a squeeze of 20 %; the section is axisymmetric: no force along x.
    force = names["r"].check().obstacles["top"].force
    assert -690 < force[1] < -640
    assert abs(force[0]) < 1e-6 * abs(force[1])
    made: s.Scene = names["scene"]
    return made


def test_scenes_of_classes_and_sessions(scene: s.Scene, capsys: pytest.CaptureFixture[str]) -> None:
    run(snippets(OWN)[2], {"s": s, "scene": scene})
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == 5
    assert float(lines[-1]) > 0.5


def test_coupled_with_other_codes(ball: s.Scene, indent: s.Mesh) -> None:
    code = snippets(OWN)[3]
    # A block that is held at its cut, under wind, in the place of the reader's body.
    mesh = s.Mesh(indent.points, indent.cells, surfaces={"cut": facets(indent, "z0"), "blown": facets(indent, "z1")})
    held = s.Support(name="cut", on="cut", displacement={"x": 0.0, "y": 0.0, "z": 0.0})
    wind = s.Traction(name="wind", on="blown", value=(0, 0, 0))
    body = s.Scene(
        mesh=mesh,
        materials={"body": s.LinearElastic(young_modulus=1.0, poisson_ratio=0.3)},
        supports=[held],
        tractions=[wind],
    )
    nodes = mesh.nodes("cut")
    names: dict[str, Any] = {"s": s, "motion": np.zeros((len(nodes), 3))}
    names["t"] = np.tile([0, 0, -0.1], (len(mesh.nodes("blown")), 1))
    names["weights"] = s.Values(rows=np.tile([0, 0, -0.01], (len(mesh.cells), 1)), place="cells")
    with s.session(body, fields=["nodal_force"]) as names["session"]:
        run(code, names)
        reaction = names["update"].result().supports["cut"].force
        np.testing.assert_allclose(names["forces"].sum(axis=0), reaction, atol=1e-9)
        assert names["session"].step(increments=1).result().supports["cut"].force[2] > 0.01


def facets(mesh: s.Mesh, surface: str) -> Any:
    """Sides of a surface by their vertices."""
    return mesh.facets[np.asarray(mesh.surfaces[surface])]


def test_a_grid_from_an_array(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, ball: s.Scene) -> None:
    monkeypatch.chdir(tmp_path)
    code = snippets(CLIENT / "manual" / "scenes.md")[0]
    axis = np.linspace(-1, 0.92, 65)
    x, y, z = np.meshgrid(axis, axis, axis, indexing="ij")
    run(code, {"numpy": np, "distances": np.sqrt(x**2 + y**2 + z**2) - 0.5})
    ball.obstacles = [s.Obstacle(name="ball", on="z1", shape=s.DistanceGrid(file="tool.grid"))]
    ball.steps = [s.Step(obstacles={"ball": s.Move(translation=(0, 0, 0.47))})]
    by_grid = s.solve(ball).check().obstacles["ball"].force
    ball.obstacles = [s.Obstacle(name="ball", on="z1", shape=s.Sphere(centre=(0, 0, 0), radius=0.5))]
    np.testing.assert_allclose(by_grid, s.solve(ball).obstacles["ball"].force, rtol=1e-3)


def test_the_first_seal(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("gmsh")
    monkeypatch.chdir(tmp_path)
    page = CLIENT / "manual" / "first-seal.md"
    # In a process of its own: Gmsh changes how signals are handled.
    subprocess.run([sys.executable, "-c", snippets(page)[0]], check=True, stdout=subprocess.DEVNULL)
    text = page.read_text()
    Path("ring.toml").write_text(re.findall(r"^```toml\n(.*?)^```", text, re.MULTILINE | re.DOTALL)[0])
    result = s.solve("ring.toml").check()
    assert len(result) == 10
    assert "some 660 N" in text
    assert result.obstacles["lid"].force[1] == pytest.approx(-660, abs=5)
    names: dict[str, Any] = {}
    run(snippets(page)[1], names)
    deeper, opened = (names[name].obstacles["lid"].force[1] for name in ("deeper", "opened"))
    assert deeper < -660 < opened < 0
