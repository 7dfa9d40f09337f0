"""A Grid as a mesh of NGSolve. Needs: pip install ngsolve mkl numpy gmsh"""
import netgen.meshing as netgen
import ngsolve
import numpy as np

from scenes import Grid


def mesh_of(grid: Grid):
    mesh = netgen.Mesh(dim=3)
    mesh.AddPoints(np.ascontiguousarray(grid.points, dtype=float))
    names = sorted(set(grid.sides))
    for index, name in enumerate(names, start=1):
        mesh.Add(netgen.FaceDescriptor(surfnr=index, domin=1, bc=index))
    sides = np.array([names.index(side) for side in grid.sides])
    mesh.AddElements(dim=3, index=1, data=grid.cells.astype(np.int32), base=0)
    for index, name in enumerate(names, start=1):
        facets = grid.facets[sides == index - 1]
        mesh.AddElements(dim=2, index=index, data=facets.astype(np.int32), base=0)
    for index, name in enumerate(names, start=1):
        mesh.SetBCName(index - 1, name)
    mesh.SetMaterial(1, "body")
    return ngsolve.Mesh(mesh)


def strain(u):
    return ngsolve.Sym(ngsolve.Grad(u))


VERSION = f"NGSolve {ngsolve.__version__}"
