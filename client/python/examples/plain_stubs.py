#!/usr/bin/env python3
"""Solves the scene of ../../examples/hertz-sphere.toml with grpcio and generated stubs only, no package.

Prints one line a result; see README.md for the stubs.
"""

import argparse
import hashlib
import pathlib
import queue
import struct
import sys

import grpc
import meshio
import numpy as np

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE / "stubs"))

from signorini.v1 import mesh_service_pb2 as mesh_pb  # noqa: E402
from signorini.v1 import mesh_service_pb2_grpc as mesh_grpc  # noqa: E402
from signorini.v1 import report_pb2 as report_pb  # noqa: E402
from signorini.v1 import scene_pb2 as scene_pb  # noqa: E402
from signorini.v1 import session_service_pb2 as session_pb  # noqa: E402
from signorini.v1 import session_service_pb2_grpc as session_grpc  # noqa: E402
from signorini.v1 import step_pb2 as step_pb  # noqa: E402

CHUNK_BYTES = 1 << 20


class Mesh:
    """Arrays of a tetrahedral mesh as the service takes them."""

    def __init__(self, path):
        source = meshio.read(path)
        blocks = [(block, tags) for block, tags in zip(source.cells, source.cell_data["gmsh:physical"], strict=True)]
        cells, cell_tags = joined(blocks, "tetra", 4)
        facets, facet_tags = joined(blocks, "triangle", 3)
        self.coordinates = source.points.astype("<f8")
        self.cells, self.facets = cells, facets
        named = sorted((dimension, tag, name) for name, (tag, dimension) in source.field_data.items())
        tags = {2: facet_tags, 3: cell_tags}
        # Facet groups, then cell groups: (name, dimension, members).
        self.groups = [
            (name, int(dimension), np.flatnonzero(tags[dimension] == tag).astype("<i4"))
            for dimension, tag, name in named
        ]

    def digest(self):
        """SHA-256 of the canonical bytes that mesh_service.proto defines."""
        digest = hashlib.sha256(b"signorini-mesh-v1\n")
        digest.update(
            struct.pack("<B4Q", 4, len(self.coordinates), len(self.cells), len(self.facets), len(self.groups))
        )
        for array in (self.coordinates, self.cells, self.facets):
            digest.update(array.tobytes())
        for name, dimension, members in self.groups:
            name = name.encode()
            digest.update(struct.pack("<Q", len(name)) + name + struct.pack("<BQ", dimension, len(members)))
            digest.update(members.tobytes())
        return digest.hexdigest()

    def header(self):
        """First message of an upload."""
        kinds = {2: mesh_pb.GROUP_KIND_FACETS, 3: mesh_pb.GROUP_KIND_CELLS}
        return mesh_pb.MeshHeader(
            digest=self.digest(),
            cell_kind=mesh_pb.CELL_KIND_TETRAHEDRON,
            vertex_count=len(self.coordinates),
            cell_count=len(self.cells),
            facet_count=len(self.facets),
            groups=[
                mesh_pb.MeshGroup(name=name, kind=kinds[dimension], member_count=len(members))
                for name, dimension, members in self.groups
            ],
        )

    def upload(self):
        """The messages of an upload."""
        yield mesh_pb.UploadMeshRequest(header=self.header())
        yield from chunks(mesh_pb.MESH_ARRAY_COORDINATES, 0, self.coordinates)
        yield from chunks(mesh_pb.MESH_ARRAY_CELLS, 0, self.cells)
        yield from chunks(mesh_pb.MESH_ARRAY_FACETS, 0, self.facets)
        for index, (_, _, members) in enumerate(self.groups):
            yield from chunks(mesh_pb.MESH_ARRAY_GROUP_MEMBERS, index, members)


def joined(blocks, kind, vertices):
    """Cells of one kind with their physical tags."""
    chosen = [(block.data, tags) for block, tags in blocks if block.type == kind]
    cells = np.concatenate([cells for cells, _ in chosen]) if chosen else np.zeros((0, vertices))
    tags = np.concatenate([tags for _, tags in chosen]) if chosen else np.zeros(0)
    return cells.astype("<i4"), tags


def chunks(array, group_index, values):
    """An array in messages of at most 1 MiB."""
    data, size = values.tobytes(), values.itemsize
    for start in range(0, len(data), CHUNK_BYTES):
        yield mesh_pb.UploadMeshRequest(
            chunk=mesh_pb.MeshChunk(
                array=array,
                group_index=group_index,
                offset_elements=start // size,
                data=data[start : start + CHUNK_BYTES],
            )
        )


def scene(mesh_name):
    """The scene of ../../examples/hertz-sphere.toml."""
    support = lambda name, on, **held: scene_pb.Support(  # noqa: E731
        name=name, on=[on], displacement=step_pb.Components(**held)
    )
    return scene_pb.Scene(
        name="hertz-sphere",
        mesh=mesh_name,
        materials=[
            scene_pb.Material(group="body", linear_elastic=scene_pb.LinearElastic(shear_modulus=1.0, poisson_ratio=0.5))
        ],
        supports=[
            support("base", "z0", x=0.0, y=0.0, z=0.0),
            support("symmetry-x", "x0", x=0.0),
            support("symmetry-y", "y0", y=0.0),
        ],
        obstacles=[
            scene_pb.Obstacle(
                name="ball",
                on=["z1"],
                shape=scene_pb.Shape(sphere=scene_pb.Sphere(centre=[0.0, 0.0, 1.0], radius=1.0)),
            )
        ],
        steps=[load_step()],
        probes=[scene_pb.Probe(name="pole", point=[0.0, 0.0, 0.0])],
        solver=scene_pb.SolverOptions(tolerance=1e-10),
    )


def load_step():
    """Presses the sphere into the block."""
    return step_pb.LoadStep(obstacles=[step_pb.ObstacleTarget(name="ball", translation=[0.0, 0.0, -0.05])])


def upload(channel, mesh):
    """Name of the mesh on the server; sends it only when it is not there."""
    meshes = mesh_grpc.MeshServiceStub(channel)
    name = f"meshes/{mesh.digest()}"
    try:
        return meshes.GetMesh(mesh_pb.GetMeshRequest(name=name)).mesh.name
    except grpc.RpcError as error:
        if error.code() is not grpc.StatusCode.NOT_FOUND:
            raise
    return meshes.UploadMesh(mesh.upload()).mesh.name


def solve(sessions, session, step):
    """Yields the result of each increment of one step, with its displacement."""
    # grpcio takes requests from this queue on a thread of its own.
    requests = queue.SimpleQueue()
    fields = [scene_pb.FIELD_NAME_DISPLACEMENT]
    requests.put(session_pb.SolveRequest(open=session_pb.SolveOpen(session=session, fields=fields)))
    requests.put(session_pb.SolveRequest(load_step=session_pb.LoadStepUpdate(sequence=1, step=step)))
    finished = None
    for response in sessions.Solve(iter(requests.get, None)):
        kind = response.WhichOneof("message")
        if kind == "update_rejected":
            sys.exit(f"rejected: {response.update_rejected.status.message}")
        if kind == "step_finished":
            finished, data = response.step_finished, b""
        elif kind == "field":
            data += response.field.data
            if response.field.last:
                yield finished.report, np.frombuffer(data, "<f8").reshape(response.field.shape)
                if finished.last:
                    requests.put(None)


def main():
    """Uploads, solves, prints, cleans up."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--server", default="127.0.0.1:50051")
    parser.add_argument("--mesh", default=HERE.parents[1] / "examples" / "meshes" / "indent_l3.msh")
    arguments = parser.parse_args()
    # The path of a Unix socket, which gRPC takes as the name of the host, is no name to the server.
    options = [("grpc.default_authority", "localhost")] if arguments.server.startswith("unix:") else None
    with grpc.insecure_channel(arguments.server, options=options) as channel:
        sessions = session_grpc.SessionServiceStub(channel)
        mesh_name = upload(channel, Mesh(arguments.mesh))
        request = session_pb.CreateSessionRequest(scene=scene(mesh_name))
        session = sessions.CreateSession(request).session.name
        for report, displacement in solve(sessions, session, load_step()):
            termination = report_pb.Termination.Name(report.termination)
            force = list(report.obstacles["ball"].force)
            print(f"{termination} force {force} largest displacement {abs(displacement).max()}")
        sessions.DeleteSession(session_pb.DeleteSessionRequest(name=session))


if __name__ == "__main__":
    main()
