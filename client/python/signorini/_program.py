"""The program `signorini` that comes with the package: where it is, and what it reads for us."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import sysconfig
import warnings
from collections.abc import Iterator
from pathlib import Path

from .errors import MeshError, ProgramError, SceneError, SignoriniWarning, Violation

NAME = "signorini"


def candidates() -> Iterator[Path]:
    """Where an installer may have put the program, likely places first."""
    yield Path(sysconfig.get_path("scripts")) / NAME
    yield Path(sysconfig.get_path("scripts", f"{os.name}_user")) / NAME
    yield Path(sys.executable).parent / NAME
    # `pip install --target` and `--prefix`.
    package = Path(__file__).resolve().parent
    yield from (folder / "bin" / NAME for folder in list(package.parents)[:4])


def program() -> Path:
    """The program; `SIGNORINI_PROGRAM` names another one."""
    chosen = os.environ.get("SIGNORINI_PROGRAM")
    if chosen:
        return Path(chosen)
    found = next((path for path in candidates() if path.is_file()), None) or shutil.which(NAME)
    if found is None:
        raise ProgramError(
            f"the program {NAME} is not there; install the wheel, or name the program in SIGNORINI_PROGRAM"
        )
    return Path(found)


def run(*arguments: str, text: bytes = b"") -> tuple[int, bytes, list[str]]:
    """Exit code, output and errors of one request; warnings are told."""
    command = [str(program()), "embed", *arguments]
    try:
        done = subprocess.run(command, input=text, capture_output=True, check=False)
    except OSError as error:
        raise ProgramError(f"{command[0]}: {error}") from error
    notes = done.stderr.decode(errors="replace").splitlines()
    for note in notes:
        if note.startswith("warning: "):
            warnings.warn(note.removeprefix("warning: "), SignoriniWarning, stacklevel=5)
    return done.returncode, done.stdout, faults(notes)


def faults(notes: list[str]) -> list[str]:
    """Messages of errors; one may have several lines."""
    messages: list[str] = []
    for note in notes:
        if note.startswith("error: "):
            messages.append(note.removeprefix("error: "))
        elif messages and not note.startswith("warning: "):
            messages[-1] += "\n" + note
    return messages or ["\n".join(notes)]


def read_scene(text: bytes, path: Path, changes: list[str]) -> bytes:
    """The message of a scene file's text; its `mesh`, and the files of tools, are paths."""
    settings = [part for change in changes for part in ("--set", change)]
    code, output, messages = run("scene", *settings, "--", str(path), text=text)
    if code != 0:
        raise SceneError("; ".join(messages), "SCENE_INVALID", "INVALID_ARGUMENT", {}, parted(messages))
    return output


def parted(messages: list[str]) -> tuple[Violation, ...]:
    """Messages with the key that they are about."""
    pairs = (message.partition(": ") for message in messages)
    return tuple(Violation(path, rest) if rest else Violation("", path) for path, _, rest in pairs)


def read_bodies(text: bytes, path: Path, changes: list[str]) -> list[bytes]:
    """The messages of the upload of the bodies of a scene file's text, as one mesh."""
    settings = [part for change in changes for part in ("--set", change)]
    code, output, messages = run("bodies", *settings, "--", str(path), text=text)
    if code != 0:
        raise MeshError("; ".join(messages), "MESH_INVALID", "INVALID_ARGUMENT")
    return list(delimited(output))


def read_mesh(path: Path) -> list[bytes]:
    """The messages of the upload of a mesh file."""
    code, output, messages = run("mesh", "--", str(path))
    if code != 0:
        raise MeshError("; ".join(messages), "MESH_INVALID", "INVALID_ARGUMENT")
    return list(delimited(output))


def read_surface(command: str, path: Path, weld: float | None = None) -> list[bytes]:
    """The messages of the upload of a tool's file: `surface` of facets, within `weld`, `grid` of numbers."""
    named = [] if weld is None else [f"--weld={weld!r}"]
    code, output, messages = run(command, *named, "--", str(path))
    if code != 0:
        raise SceneError("; ".join(messages), "SURFACE_INVALID", "INVALID_ARGUMENT")
    return list(delimited(output))


def delimited(data: bytes) -> Iterator[bytes]:
    """Messages that follow their lengths."""
    view, at = memoryview(data), 0
    while at < len(data):
        size, shift = 0, 0
        while True:
            byte = data[at]
            size, shift, at = size | (byte & 127) << shift, shift + 7, at + 1
            if byte < 128:
                break
        yield bytes(view[at : at + size])
        at += size
