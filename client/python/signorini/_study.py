"""Studies: the program of the package solves the cases, the table of them becomes a frame."""

from __future__ import annotations

import contextlib
import signal
import subprocess
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Literal

import tomli_w

from . import _program
from ._encode import toml
from .errors import (
    PackageError,
    ProgramError,
    RefusedError,
    SceneError,
    ServerError,
    SignoriniError,
    UnreachableError,
)

__all__ = ["read_study", "study"]

Frame = Literal["pandas", "polars"]

#: Exit codes with a table: all cases converged, or some did not.
WITH_TABLE = (0, 3)


def study(
    study: str | Path | Mapping[str, Any],
    *,
    out: str | Path | None = None,
    set: Mapping[str, Any] | None = None,
    workers: int | None = None,
    tries: int | None = None,
    resume: bool = False,
    fields: str | Path | None = None,
    server: str | None = None,
    queue: str | None = None,
    progress: bool = False,
    frame: Frame = "pandas",
) -> Any:
    """Solves every case of a study: a frame with one row for each, failed ones with their cause.

    `study` is a file, or a dictionary with the keys of one, whose files begin in the working directory.
    Without `out`, a file that ends in `.csv` or `.parquet`, the table is not kept; with it, `resume` goes on with
    a study that was interrupted. The other arguments are those of `signorini study`; `progress` lets it show
    its bar. `frame` is the package that the frame is of.
    """
    package(frame)
    with place(study, out) as (file, table):
        arguments = [str(file), "--out", str(table)]
        for change, value in (set or {}).items():
            arguments += ["--set", f"{change}={toml(value)}"]
        named = {"workers": workers, "tries": tries, "fields": fields, "server": server, "queue": queue}
        for name, given in named.items():
            arguments += [] if given is None else [f"--{name}", str(given)]
        arguments += ["--resume"] if resume else []
        arguments += [] if progress else ["--quiet"]
        run(arguments, progress)
        return read_study(table, frame=frame)


def read_study(table: str | Path, *, frame: Frame = "pandas") -> Any:
    """The table of a study, CSV or Parquet, as a frame; doubles are those that were written."""
    module = package(frame)
    path = Path(table)
    if path.suffix == ".parquet":
        return module.read_parquet(path)
    if frame == "polars":
        return module.read_csv(path, schema_overrides={"id": module.String}, infer_schema_length=None)
    # Later ones do so anyway.
    exact = {"float_precision": "round_trip"} if int(module.__version__.split(".")[0]) < 3 else {}
    return module.read_csv(path, dtype={"id": str}, **exact)


def package(frame: str) -> Any:
    """The module that makes frames."""
    if frame not in ("pandas", "polars"):
        raise ValueError(f'"{frame}" is not known; known are pandas, polars')
    try:
        return __import__(frame)
    except ImportError:
        raise PackageError(f"a frame of {frame} needs that package: pip install {frame}") from None


@contextlib.contextmanager
def place(study: str | Path | Mapping[str, Any], out: str | Path | None) -> Iterator[tuple[Path, Path]]:
    """The file of a study and that of its table, those that nobody named in a folder that goes."""
    with tempfile.TemporaryDirectory(prefix="signorini-study-") as folder:
        table = Path(out) if out is not None else Path(folder) / "study.csv"
        if isinstance(study, (str, Path)):
            yield Path(study), table
            return
        file = Path(folder) / "study.toml"
        file.write_text(tomli_w.dumps(absolute(study)))
        yield file, table


def absolute(study: Mapping[str, Any]) -> dict[str, Any]:
    """The same study from anywhere."""
    tables = dict(study)
    if isinstance(tables.get("scene"), (str, Path)):
        tables["scene"] = str(Path(tables["scene"]).resolve())
    if isinstance(tables.get("list"), Mapping) and "file" in tables["list"]:
        tables["list"] = {**tables["list"], "file": str(Path(tables["list"]["file"]).resolve())}
    return tables


def run(arguments: Sequence[str], progress: bool) -> None:
    """Runs `signorini study` to its end; an interrupt lets it keep its rows."""
    command = [str(_program.program()), "study", *arguments]
    errors = None if progress else subprocess.PIPE
    try:
        # Of its own session: an interrupt reaches it once, from here.
        process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=errors, text=True, start_new_session=True)
    except OSError as error:
        raise ProgramError(f"{command[0]}: {error}") from error
    with process:
        try:
            _, told = process.communicate()
        except KeyboardInterrupt:
            process.send_signal(signal.SIGINT)
            process.communicate()
            raise
    if process.returncode not in WITH_TABLE:
        raise failure(process.returncode, _program.faults((told or "").splitlines()))


def failure(code: int, messages: list[str]) -> SignoriniError:
    """The exception of an exit code."""
    text = "; ".join(messages) or f"exit code {code}"
    if code == 4:
        return SceneError(text, "SCENE_INVALID", "INVALID_ARGUMENT", {}, _program.parted(messages))
    if code == 5:
        return UnreachableError(text)
    if code == 6:
        return RefusedError(text)
    if code in (8, 9):
        return ServerError(text)
    return ProgramError(text)
