"""Meshes from files, arrays and meshio are the same meshes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import signorini as s

SQUARE = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], dtype=float)
CELLS = np.array([[0, 1, 2], [0, 2, 3]])


def test_the_digest_of_an_example_is_that_of_the_other_clients(examples: Path) -> None:
    mesh = s.Mesh.read(examples / "meshes" / "indent_l3.msh")
    assert mesh.digest == "cbc7b4f0d3207b874645602a5793f44dd57da1b89b11b853de3c4184018f6eba"


@pytest.mark.parametrize("name", ["indent_l1", "square_n16", "cylinder_l1"])
def test_meshio_gives_the_same_mesh(examples: Path, name: str) -> None:
    meshio = pytest.importorskip("meshio")
    path = examples / "meshes" / f"{name}.msh"
    assert s.Mesh.from_meshio(meshio.read(path)).digest == s.Mesh.read(path).digest


def test_meshio_keeps_curved_sides(examples: Path) -> None:
    meshio = pytest.importorskip("meshio")
    path = examples / "meshes" / "o-ring.msh"
    ours, program = s.Mesh.from_meshio(meshio.read(path)), s.Mesh.read(path)
    assert len(ours.curved_edges) == len(program.curved_edges) > 0
    np.testing.assert_array_equal(ours.curved_edges, program.curved_edges)
    np.testing.assert_allclose(ours.edge_offsets, program.edge_offsets, atol=1e-12)
    np.testing.assert_array_equal(ours.cells, program.cells)


def test_sets_of_cells_are_groups() -> None:
    meshio = pytest.importorskip("meshio")
    source = meshio.Mesh(
        SQUARE,
        [("line", [[0, 1]]), ("triangle", CELLS)],
        cell_sets={"floor": [np.array([0]), None], "rubber": [None, np.array([0, 1])]},
    )
    mesh = s.Mesh.from_meshio(source)
    assert (list(mesh.bodies), list(mesh.surfaces)) == (["rubber"], ["floor"])


def test_arrays_alone_give_a_body_and_its_skin() -> None:
    mesh = s.Mesh(SQUARE, CELLS)
    assert mesh.points.shape == (4, 3)
    assert {tuple(sorted(side)) for side in mesh.facets.tolist()} == {(0, 1), (1, 2), (2, 3), (0, 3)}
    assert (list(mesh.bodies), list(mesh.surfaces)) == (["body"], ["skin"])


def test_surfaces_may_be_given_by_vertices_and_bodies_by_masks() -> None:
    mesh = s.Mesh(SQUARE, CELLS, bodies={"a": np.array([True, False]), "b": [1]}, surfaces={"floor": [[0, 1]]})
    assert mesh.groups[0][0] == "floor"
    assert [list(members) for _, _, members in mesh.groups] == [[0], [0], [1]]


def test_the_boundary_of_a_tetrahedron_is_its_four_sides() -> None:
    assert len(s.boundary([[0, 1, 2, 3]])) == 4
    assert len(s.boundary([[0, 1, 2, 3], [1, 2, 3, 4]])) == 6


def test_wrong_arrays_are_told() -> None:
    for arrays, said in [
        ((SQUARE, CELLS + 0.5), "cells: integers"),
        ((SQUARE[:, :1], CELLS), "points: an array"),
        ((SQUARE, CELLS.ravel()), "cells: an array"),
    ]:
        with pytest.raises(s.errors.MeshError, match=said):
            s.Mesh(*arrays)


def test_a_file_that_is_no_mesh_is_told(tmp_path: Path) -> None:
    path = tmp_path / "a.msh"
    path.write_text("nothing")
    with pytest.raises(s.errors.MeshError, match=r"a\.msh"):
        s.Mesh.read(path)


def test_a_mesh_comes_back_from_the_server(indent: s.Mesh) -> None:
    client = s.connect()
    client.upload(indent)
    back = client.read_mesh(indent.name)
    np.testing.assert_array_equal(back.points, indent.points)
    np.testing.assert_array_equal(back.cells, indent.cells)
    assert list(back.surfaces) == list(indent.surfaces)


def test_a_mesh_of_several_chunks_travels_whole() -> None:
    count = 400
    x, y = np.meshgrid(np.arange(count + 1.0), np.arange(count + 1.0), indexing="ij")
    corner = (np.arange(count)[:, None] * (count + 1) + np.arange(count)).ravel()
    lower = np.stack([corner, corner + count + 1, corner + 1], axis=1)
    upper = np.stack([corner + count + 1, corner + count + 2, corner + 1], axis=1)
    mesh = s.Mesh(np.stack([x.ravel(), y.ravel()], axis=1), np.concatenate([lower, upper]))
    assert mesh.points.nbytes > 3 << 20
    back = s.connect().read_mesh(s.connect().upload(mesh))
    np.testing.assert_array_equal(back.points, mesh.points)
    np.testing.assert_array_equal(back.cells, mesh.cells)
