"""Tools from files: triangulations, and heights or distances on grids, on their way to a server."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from . import _program
from .v1 import scene_pb2
from .v1 import surface_service_pb2 as pb

#: Of each shape from a file: the field that names it, and what reads it.
FILES = {"surface": ("surface", "surface"), "height_field": ("grid", "grid"), "distance_grid": ("grid", "grid")}


@dataclass
class Surface:
    """A file as the messages of its upload."""

    requests: list[pb.UploadSurfaceRequest]

    @property
    def name(self) -> str:
        """Name of the resource on a server."""
        return f"surfaces/{self.requests[0].header.digest}"


def read_surfaces(scene: scene_pb2.Scene) -> list[Surface]:
    """Reads the files that the obstacles of a scene name, and names them by their digests there."""
    read: list[Surface] = []
    for obstacle in scene.obstacles:
        kind = obstacle.shape.WhichOneof("kind")
        if kind in FILES:
            field, command = FILES[kind]
            shape = getattr(obstacle.shape, kind)
            weld = shape.weld if kind == "surface" and shape.HasField("weld") else None
            messages = _program.read_surface(command, Path(getattr(shape, field)), weld)
            read.append(Surface([pb.UploadSurfaceRequest.FromString(one) for one in messages]))
            setattr(shape, field, read[-1].name)
    return read


def write_grid(path: str | Path, values: npt.ArrayLike, origin: npt.ArrayLike, spacing: npt.ArrayLike) -> None:
    """Writes the file of a `HeightField` (values [x, y]) or a `DistanceGrid` (values [x, y, z]).

    `origin` is the first node, `spacing` the distance of nodes along each axis.
    """
    table = np.asarray(values, dtype=float)
    keys = {"counts": np.asarray(table.shape), "origin": np.asarray(origin), "spacing": np.asarray(spacing)}
    if table.ndim not in (2, 3) or any(one.shape != (table.ndim,) for one in keys.values()):
        shapes = ", ".join(f"{key} {list(one.shape)}" for key, one in keys.items() if key != "counts")
        raise ValueError(f"values have the shape {list(table.shape)}, two or three axes are expected; {shapes}")
    header = "\n".join(f"{key} {' '.join(map(repr, one.tolist()))}" for key, one in keys.items())
    np.savetxt(path, table.reshape(-1, table.shape[-1]), fmt="%.17g", header=header, comments="")
