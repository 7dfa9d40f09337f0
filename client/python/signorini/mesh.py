"""Meshes: arrays with named groups, from files, from numpy or from meshio.

A mesh is named by the SHA-256 of its canonical bytes (`mesh_service.proto`), computed here, so
that a server gets only what it does not have. Cost: one pass over the arrays.
"""

from __future__ import annotations

import hashlib
import struct
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _program
from .errors import MeshError
from .v1 import mesh_service_pb2 as pb

__all__ = ["Mesh", "boundary"]

CHUNK_BYTES = 1 << 20

Floats = npt.NDArray[np.float64]
Indices = npt.NDArray[np.int32]

_FIELDS = {
    pb.MESH_ARRAY_COORDINATES: ("points", "<f8", 3),
    pb.MESH_ARRAY_CELLS: ("cells", "<i4", None),
    pb.MESH_ARRAY_FACETS: ("facets", "<i4", None),
    pb.MESH_ARRAY_CURVED_EDGES: ("curved_edges", "<i4", 2),
    pb.MESH_ARRAY_EDGE_OFFSETS: ("edge_offsets", "<f8", 3),
}


def boundary(cells: npt.ArrayLike) -> Indices:
    """Facets (lines of triangles, triangles of tetrahedra) that one cell only has: the skin."""
    cells = np.asarray(cells, dtype="<i4")
    count = cells.shape[1]
    facets = np.concatenate([np.delete(cells, corner, axis=1) for corner in range(count)])
    _, index, found = np.unique(np.sort(facets, axis=1), axis=0, return_index=True, return_counts=True)
    return np.ascontiguousarray(facets[np.sort(index[found == 1])])


@dataclass(eq=False)
class Mesh:
    """Triangles or tetrahedra with named groups of cells and of facets.

    `points` [n, 2 or 3], `cells` [n, 3 or 4] and `facets` [n, 2 or 3] index vertices from 0;
    `bodies` and `surfaces` give indices of cells and of facets by name. Without `facets` a surface
    may be given by vertices itself, [n, 2 or 3]. Without `bodies` all cells are `body`; without
    `surfaces` the boundary is `skin`.
    """

    points: Floats
    cells: Indices
    facets: Indices = field(default_factory=lambda: np.zeros((0, 0), "<i4"))
    bodies: Mapping[str, npt.ArrayLike] = field(default_factory=dict)
    surfaces: Mapping[str, npt.ArrayLike] = field(default_factory=dict)
    curved_edges: Indices = field(default_factory=lambda: np.zeros((0, 2), "<i4"))
    edge_offsets: Floats = field(default_factory=lambda: np.zeros((0, 3)))

    def __post_init__(self) -> None:
        self.points = three(table(self.points, "<f8", "points", (2, 3)))
        self.cells = table(self.cells, "<i4", "cells", (3, 4))
        corners = self.cells.shape[1]
        if np.size(self.facets) == 0 and not self.surfaces:
            self.facets = boundary(self.cells)
            self.surfaces = {"skin": np.arange(len(self.facets), dtype="<i4")}
        elif np.size(self.facets) == 0:
            self.facets, self.surfaces = sides(self.surfaces, corners - 1)
        self.facets = table(self.facets, "<i4", "facets", (corners - 1,))
        self.bodies = groups(self.bodies or {"body": np.arange(len(self.cells))}, "body")
        self.surfaces = groups(self.surfaces, "surface")
        self.curved_edges = table(self.curved_edges, "<i4", "curved_edges", (2,))
        self.edge_offsets = table(self.edge_offsets, "<f8", "edge_offsets", (3,))

    @classmethod
    def read(cls, path: str | Path) -> Mesh:
        """A mesh file, as the command line reads it."""
        return cls.from_upload(_program.read_mesh(Path(path)))

    @classmethod
    def from_upload(cls, messages: Iterable[bytes]) -> Mesh:
        """A mesh from the messages of its upload."""
        first, *rest = (pb.UploadMeshRequest.FromString(one) for one in messages)
        return cls.from_messages(first.header, (one.chunk for one in rest))

    @classmethod
    def from_messages(cls, header: pb.MeshHeader, chunks: Iterable[pb.MeshChunk]) -> Mesh:
        """A mesh from its header and chunks; arrays of one chunk are not copied."""
        parts: dict[tuple[int, int], list[bytes]] = {}
        for chunk in chunks:
            parts.setdefault((chunk.array, chunk.group_index), []).append(chunk.data)
        corners = 3 if header.cell_kind == pb.CELL_KIND_TRIANGLE else 4
        width = {pb.MESH_ARRAY_CELLS: corners, pb.MESH_ARRAY_FACETS: corners - 1}
        arrays: dict[str, Any] = {}
        for kind, (name, element, columns) in _FIELDS.items():
            data = joined(parts.get((kind, 0), []))
            arrays[name] = np.frombuffer(data, element).reshape(-1, columns or width[kind])
        members: dict[int, dict[str, npt.ArrayLike]] = {pb.GROUP_KIND_CELLS: {}, pb.GROUP_KIND_FACETS: {}}
        for index, group in enumerate(header.groups):
            data = joined(parts.get((pb.MESH_ARRAY_GROUP_MEMBERS, index), []))
            members[group.kind][group.name] = np.frombuffer(data, "<i4")
        bodies, surfaces = members[pb.GROUP_KIND_CELLS], members[pb.GROUP_KIND_FACETS]
        return cls(bodies=bodies, surfaces=surfaces, **arrays)

    @classmethod
    def from_meshio(cls, source: Any) -> Mesh:
        """A `meshio.Mesh`: physical groups of Gmsh, or cell sets; second order keeps curved sides."""
        from ._meshio import arrays

        return cls(**arrays(source))

    @property
    def dimension(self) -> int:
        """2 for triangles, 3 for tetrahedra."""
        return int(self.cells.shape[1]) - 1

    @cached_property
    def edges(self) -> Indices:
        """Ends of the unique edges of all cells, [edges, 2]: nodes after the vertices, in this order."""
        count = self.cells.shape[1]
        pairs = [self.cells[:, [i, j]] for i in range(count) for j in range(i + 1, count)]
        unique: Indices = np.unique(np.sort(np.concatenate(pairs), axis=1), axis=0)
        return unique

    def nodes(self, surface: str) -> Indices:
        """Numbers of the nodes of a surface, ascending: vertices, then edges."""
        vertices = self.facet_nodes(surface)
        unique: Indices = np.unique(vertices)
        return unique

    def facet_nodes(self, surface: str) -> Indices:
        """Nodes of every facet of a surface, [facets, 3 or 6]: its vertices, then edges 01, 02, 12."""
        corners = self.facets[np.asarray(self.surfaces[surface])]
        ends = [
            np.sort(corners[:, [i, j]], axis=1) for i in range(self.dimension) for j in range(i + 1, self.dimension)
        ]
        # An edge is found by its ends as one number.
        size = np.int64(len(self.points))
        keys = self.edges[:, 0] * size + self.edges[:, 1]
        middles = [len(self.points) + np.searchsorted(keys, pair[:, 0] * size + pair[:, 1]) for pair in ends]
        return np.ascontiguousarray(np.column_stack([corners, *middles]), dtype="<i4")

    @cached_property
    def places(self) -> Floats:
        """Where the nodes are on straight edges, [nodes, 3]."""
        return np.concatenate([self.points, self.points[self.edges].mean(axis=1)])

    @property
    def groups(self) -> list[tuple[str, int, Indices]]:
        """Name, dimension and members: facet groups, then cell groups."""
        named = [(self.dimension - 1, self.surfaces), (self.dimension, self.bodies)]
        return [(name, of, np.asarray(one)) for of, some in named for name, one in some.items()]

    @cached_property
    def digest(self) -> str:
        """SHA-256 of the canonical bytes."""
        curved = len(self.curved_edges) > 0
        digest = hashlib.sha256(b"signorini-mesh-v2\n" if curved else b"signorini-mesh-v1\n")
        counts = (len(self.points), len(self.cells), len(self.facets), len(self.groups))
        digest.update(struct.pack("<B4Q", self.cells.shape[1], *counts))
        for array in (self.points, self.cells, self.facets):
            digest.update(array.data)
        for name, dimension, members in self.groups:
            encoded = name.encode()
            digest.update(struct.pack("<Q", len(encoded)) + encoded)
            digest.update(struct.pack("<BQ", dimension, len(members)))
            digest.update(members.data)
        if curved:
            digest.update(struct.pack("<Q", len(self.curved_edges)))
            digest.update(self.curved_edges.data)
            digest.update(self.edge_offsets.data)
        return digest.hexdigest()

    @property
    def name(self) -> str:
        """Name of the resource on a server."""
        return f"meshes/{self.digest}"

    def header(self) -> pb.MeshHeader:
        """First message of an upload."""
        triangles = self.dimension == 2
        kinds = {self.dimension: pb.GROUP_KIND_CELLS, self.dimension - 1: pb.GROUP_KIND_FACETS}
        return pb.MeshHeader(
            digest=self.digest,
            cell_kind=pb.CELL_KIND_TRIANGLE if triangles else pb.CELL_KIND_TETRAHEDRON,
            vertex_count=len(self.points),
            cell_count=len(self.cells),
            facet_count=len(self.facets),
            curved_edge_count=len(self.curved_edges),
            groups=[
                pb.MeshGroup(name=name, kind=kinds[dimension], member_count=len(members))
                for name, dimension, members in self.groups
            ],
        )

    def requests(self) -> Iterator[pb.UploadMeshRequest]:
        """The messages of an upload."""
        yield pb.UploadMeshRequest(header=self.header())
        for kind, (name, _, _) in _FIELDS.items():
            yield from chunks(kind, 0, getattr(self, name))
        for index, (_, _, members) in enumerate(self.groups):
            yield from chunks(pb.MESH_ARRAY_GROUP_MEMBERS, index, members)

    def __repr__(self) -> str:
        kind = "triangles" if self.dimension == 2 else "tetrahedra"
        named = f"bodies {', '.join(self.bodies)}; surfaces {', '.join(self.surfaces)}"
        return f"Mesh({len(self.cells)} {kind}, {len(self.points)} vertices; {named})"


def chunks(kind: Any, group_index: int, values: npt.NDArray[Any]) -> Iterator[pb.UploadMeshRequest]:
    """An array in messages of at most 1 MiB."""
    data = values.data.cast("B") if values.size else memoryview(b"")
    for start in range(0, len(data), CHUNK_BYTES):
        chunk = pb.MeshChunk(
            array=kind,
            group_index=group_index,
            offset_elements=start // values.itemsize,
            data=bytes(data[start : start + CHUNK_BYTES]),
        )
        yield pb.UploadMeshRequest(chunk=chunk)


def joined(parts: list[bytes]) -> bytes:
    """One buffer; without a copy where it is one already."""
    return parts[0] if len(parts) == 1 else b"".join(parts)


def table(values: npt.ArrayLike, element: str, what: str, columns: tuple[int, ...]) -> Any:
    """Rows of numbers, contiguous as they travel."""
    given = np.asarray(values)
    if given.size == 0:
        given = given.reshape(0, columns[-1])
    if given.ndim != 2 or given.shape[1] not in columns:
        wanted = " or ".join(map(str, columns))
        raise MeshError(f"{what}: an array [rows, {wanted}] is expected, found {list(given.shape)}", "MESH_INVALID")
    return integral(given, element, what)


def integral(given: npt.NDArray[Any], element: str, what: str) -> Any:
    """The same values as `element`; an index that would change is an error."""
    converted = np.ascontiguousarray(given, dtype=element)
    if element == "<i4" and not np.array_equal(converted, given):
        raise MeshError(f"{what}: integers of 32 bits are expected, found {given.dtype}", "MESH_INVALID")
    return converted


def three(points: Floats) -> Floats:
    """Points of the plane with z = 0."""
    return points if points.shape[1] == 3 else np.ascontiguousarray(np.pad(points, ((0, 0), (0, 1))))


def sides(surfaces: Mapping[str, npt.ArrayLike], corners: int) -> tuple[Any, dict[str, npt.ArrayLike]]:
    """Facets, and their indices by name, of surfaces given by vertices."""
    given = {name: table(one, "<i4", f"surface {name}", (corners,)) for name, one in surfaces.items()}
    facets, index = np.unique(np.concatenate(list(given.values())), axis=0, return_inverse=True)
    ends = np.cumsum([len(one) for one in given.values()])[:-1]
    return facets, dict(zip(given, np.split(index.ravel(), ends), strict=True))


def groups(named: Mapping[str, npt.ArrayLike], what: str) -> dict[str, npt.ArrayLike]:
    """Members by name; a mask of truth values is as good as indices."""
    members = {}
    for name, given in named.items():
        values = np.asarray(given)
        values = np.flatnonzero(values) if values.dtype == bool else values.ravel()
        members[name] = integral(values, "<i4", f"{what} {name}")
    return members
