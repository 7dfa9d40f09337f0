"""An O-ring of one's own: a section meshed by Gmsh, a scene of classes, the force at every increment.

Needs `pip install gmsh`. Units: mm, N, MPa.
"""

import tempfile
from pathlib import Path

import gmsh

import signorini as s

RADIUS, CENTRE, SIZE, SQUEEZE = 2.665, 27.665, 0.3, 0.2


def mesh(path: Path) -> Path:
    """The section, with the groups `rubber` and `skin`."""
    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    disk = gmsh.model.occ.addDisk(CENTRE, 0, 0, RADIUS, RADIUS)
    gmsh.model.occ.synchronize()
    curves = [tag for _, tag in gmsh.model.getBoundary([(2, disk)])]
    gmsh.model.addPhysicalGroup(2, [disk], name="rubber")
    gmsh.model.addPhysicalGroup(1, [abs(tag) for tag in curves], name="skin")
    gmsh.option.setNumber("Mesh.MeshSizeMax", SIZE)
    gmsh.model.mesh.generate(2)
    gmsh.model.mesh.setOrder(2)  # curved sides, for the contact of a round body
    gmsh.write(str(path))
    gmsh.finalize()
    return path


def plate(name: str, side: int) -> s.Obstacle:
    """A plate at the top (1) or at the bottom (-1); its normal points to the free side."""
    shape = s.HalfSpace(point=(0, side * RADIUS, 0), normal=(0, -side, 0))
    return s.Obstacle(name=name, on="skin", shape=shape)


def main() -> None:
    """Meshes, solves, prints."""
    with tempfile.TemporaryDirectory() as folder:
        scene = s.Scene(
            name="own-o-ring",
            mesh=mesh(Path(folder) / "o-ring.msh"),
            kind="axisymmetric",
            materials={"rubber": s.MooneyRivlin(c10=0.8, c01=0.2)},
            obstacles=[plate("bottom", -1), plate("top", 1)],
            steps=[s.Step(increments=10, obstacles={"top": s.Move(translation=(0, -2 * RADIUS * SQUEEZE, 0))})],
        )
        result = s.solve(scene)
    moved = result.travel("top")
    if moved is not None:
        for travel, force in zip(*moved, strict=True):
            print(f"{100 * travel / (2 * RADIUS):5.1f} % squeeze  {force:8.2f} N")


if __name__ == "__main__":
    main()
