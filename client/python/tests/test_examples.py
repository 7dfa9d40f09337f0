"""Every example of the command line means the same here: the same numbers, key by key."""

from __future__ import annotations

import json
import re
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import EXAMPLES

import signorini as s
from signorini._program import program

FILES = sorted(EXAMPLES.glob("*.toml"))
assert FILES


def by_command_line(path: Path) -> list[dict[str, Any]]:
    """The result lines of the steps."""
    done = subprocess.run(
        [str(program()), "solve", str(path), "--json", "--quiet"], capture_output=True, check=True, text=True
    )
    lines = [json.loads(line) for line in done.stdout.splitlines()]
    return [line for line in lines if line["event"] == "step"]


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_forces_are_those_of_the_command_line(path: Path) -> None:
    expected = by_command_line(path)
    result = s.solve(path).check()
    assert len(result) == len(expected) > 0
    for line, increment in zip(expected, result, strict=True):
        assert increment.obstacles.keys() == line["obstacles"].keys()
        for kind in ("obstacles", "supports"):
            for name, one in line[kind].items():
                force = getattr(increment, kind)[name].force
                np.testing.assert_allclose(force, one["force"], rtol=1e-12, atol=1e-12)
        for name, one in line["probes"].items():
            np.testing.assert_allclose(increment.probes[name].displacement, one["displacement"], rtol=1e-12, atol=1e-12)
        assert increment.report.strain_energy == pytest.approx(line["strain_energy"], rel=1e-12)


def test_every_example_of_the_command_line_comes_with_the_package() -> None:
    for path in FILES:
        own = s.example(path.stem)
        assert own.read_bytes() == path.read_bytes()
        files = re.findall(r'\b(?:mesh|file) = "([^"]+)"', own.read_text())
        assert files
        assert all((own.parent / file).exists() for file in files)


def test_an_unknown_example_says_which_there_are() -> None:
    with pytest.raises(FileNotFoundError, match=r"there are backed-ring, .*, o-ring, .*, tyre"):
        s.example("o_ring")
