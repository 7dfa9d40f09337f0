"""Arrays of a `meshio.Mesh`: cells and facets of first or second order, and their groups.

Of second order the edges of facets keep how far their middle is off the line between their ends,
where that is more than rounding.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from .errors import MeshError

# Corners of each kind of cell that meshio names.
KINDS = {"line": 2, "line3": 2, "triangle": 3, "triangle6": 3, "tetra": 4, "tetra10": 4}
# Corners of the edges whose middles follow the corners, as meshio orders them.
EDGES = {
    "line3": ((0, 1),),
    "triangle6": ((0, 1), (1, 2), (2, 0)),
    "tetra10": ((0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)),
}
# Distance over the length of an edge that is rounding.
ROUNDING = 1e-9

Array = npt.NDArray[Any]


def arrays(source: Any) -> dict[str, Any]:
    """What `Mesh` takes."""
    corners = max((KINDS.get(block.type, 0) for block in source.cells), default=0)
    if corners < 3:
        kinds = ", ".join(block.type for block in source.cells) or "none"
        raise MeshError(f"triangles or tetrahedra are expected, found {kinds}", "MESH_INVALID")
    strange = [block.type for block in source.cells if block.type not in (*KINDS, "vertex")]
    if strange:
        raise MeshError(f"cells of kind {', '.join(strange)} are not known", "MESH_INVALID")
    points = np.asarray(source.points, dtype=float)
    cells, facets = blocks(source, corners), blocks(source, corners - 1)
    rows = np.concatenate([one.data[:, :corners] for one in cells])
    # Middles of edges are no vertices of their own.
    kept = np.unique(np.concatenate([rows.ravel(), *(b.data[:, : corners - 1].ravel() for b in facets)]))
    number = np.full(len(points), -1)
    number[kept] = np.arange(len(kept))
    sides = [number[block.data[:, : corners - 1]] for block in facets]
    ends, offsets = curved(cells + facets, points, number)
    return {
        "points": points[kept],
        "cells": number[rows],
        "facets": np.concatenate(sides) if sides else np.zeros((0, 0)),
        "bodies": named(source, cells, corners - 1),
        "surfaces": named(source, facets, corners - 2),
        "curved_edges": ends,
        "edge_offsets": offsets,
    }


def blocks(source: Any, corners: int) -> list[Any]:
    """Blocks of cells with that many corners."""
    return [block for block in source.cells if KINDS.get(block.type) == corners]


def named(source: Any, chosen: list[Any], dimension: int) -> dict[str, Array]:
    """Members of each group by name: physical groups of Gmsh, else sets of cells."""
    members: dict[str, Array] = {}
    places = [index for index, block in enumerate(source.cells) if any(block is one for one in chosen)]
    tags = source.cell_data.get("gmsh:physical")
    if tags is not None:
        joined = np.concatenate([np.asarray(tags[place]) for place in places]) if places else np.zeros(0)
        names = {int(tag): name for name, (tag, of) in source.field_data.items() if of == dimension}
        for tag in np.unique(joined[joined != 0]):
            members[names.get(int(tag), str(int(tag)))] = np.flatnonzero(joined == tag)
        return members
    for name, sets in source.cell_sets.items():
        first, found = 0, []
        for place in places:
            if sets[place] is not None:
                found.append(np.asarray(sets[place], dtype=int) + first)
            first += len(source.cells[place].data)
        joined = np.concatenate(found) if found else np.zeros(0, dtype=int)
        if len(joined):
            members[name] = joined
    return members


def curved(chosen: list[Any], points: Array, number: Array) -> tuple[Array, Array]:
    """Edges with an offset, ascending; inside the body the server leaves them out."""
    ends, middles = [np.zeros((0, 2), dtype=int)], [np.zeros(0, dtype=int)]
    for block in chosen:
        corners = KINDS[block.type]
        for place, edge in enumerate(EDGES.get(block.type, ())):
            ends.append(block.data[:, edge])
            middles.append(block.data[:, corners + place])
    pairs, middle = np.concatenate(ends), np.concatenate(middles)
    first, second = points[pairs[:, 0]], points[pairs[:, 1]]
    offsets = points[middle] - (first + second) / 2
    bent = np.linalg.norm(offsets, axis=1) > ROUNDING * np.linalg.norm(second - first, axis=1)
    rows, index = np.unique(np.sort(number[pairs[bent]], axis=1), axis=0, return_index=True)
    offsets = offsets[bent][index].reshape(-1, points.shape[1])
    return rows, np.pad(offsets, ((0, 0), (0, 3 - points.shape[1])))
