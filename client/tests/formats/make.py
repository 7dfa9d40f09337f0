"""Wrote the files of this folder, with pyvista (VTK 9), meshio and gmsh: two tetrahedra in every
encoding of VTK, and a ball and a ring of second order as Abaqus and Gmsh files."""

import gmsh
import meshio
import numpy
import pyvista
import vtk

POINTS = numpy.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1]], float)
TETRAHEDRA = numpy.array([[0, 1, 2, 3], [1, 2, 3, 4]])
TRIANGLES = numpy.array([[0, 2, 1]])


def grid():
    made = pyvista.UnstructuredGrid({10: TETRAHEDRA, 5: TRIANGLES}, POINTS)
    made.cell_data["group"] = numpy.array([1, 1, 7], numpy.int32)
    made.cell_data["other"] = numpy.array([0.5, 0.25, 0.0])
    made.point_data["v"] = numpy.arange(15.0).reshape(5, 3)
    made.point_data["n"] = numpy.arange(5)
    made.field_data["body"] = numpy.array([1, 3])
    made.field_data["floor"] = numpy.array([7, 2])
    return made


def xml(name, mode, zlib=False, base64=False, header=32, big=False):
    writer = vtk.vtkXMLUnstructuredGridWriter()
    writer.SetInputData(grid())
    writer.SetFileName(name)
    getattr(writer, f"SetDataModeTo{mode}")()
    if zlib:
        writer.SetCompressorTypeToZLib()
    else:
        writer.SetCompressorTypeToNone()
    writer.SetEncodeAppendedData(base64)
    getattr(writer, f"SetHeaderTypeToUInt{header}")()
    if big:
        writer.SetByteOrderToBigEndian()
    writer.Write()


def legacy(name, version, mode):
    writer = vtk.vtkUnstructuredGridWriter()
    writer.SetInputData(grid())
    writer.SetFileName(name)
    writer.SetFileVersion(version)
    getattr(writer, f"SetFileTypeTo{mode}")()
    writer.Write()


def of_meshio():
    made = meshio.Mesh(
        POINTS,
        [("tetra", TETRAHEDRA), ("triangle", TRIANGLES)],
        cell_data={"gmsh:physical": [numpy.array([1, 1]), numpy.array([7])]},
    )
    made.write("meshio.vtu")
    made.write("meshio.vtk")
    made.write("meshio_ascii.vtk", binary=False)
    made.write("meshio_ascii.vtu", binary=False)
    made.write("meshio.inp")


def second_order(name, dimension, size):
    entities = [tag for _, tag in gmsh.model.getEntities(dimension)]
    sides = [tag for _, tag in gmsh.model.getEntities(dimension - 1)]
    gmsh.model.addPhysicalGroup(dimension, entities, 1, "rubber")
    gmsh.model.addPhysicalGroup(dimension - 1, sides, 2, "skin")
    gmsh.option.setNumber("Mesh.MeshSizeMin", size)
    gmsh.option.setNumber("Mesh.MeshSizeMax", size)
    gmsh.model.mesh.generate(dimension)
    gmsh.model.mesh.setOrder(2)
    gmsh.write(f"{name}.inp")
    gmsh.write(f"{name}.msh")


def of_gmsh():
    gmsh.initialize()
    gmsh.option.setNumber("Mesh.SaveGroupsOfNodes", 1)
    gmsh.option.setNumber("Mesh.SaveGroupsOfElements", 1)
    gmsh.model.add("sphere")
    gmsh.model.occ.addSphere(0, 0, 0, 1)
    gmsh.model.occ.synchronize()
    second_order("sphere2", 3, 1.2)
    gmsh.model.add("ring")
    gmsh.model.occ.addDisk(27.665, 0, 0, 2.665, 2.665)
    gmsh.model.occ.synchronize()
    second_order("ring2", 2, 0.8)


xml("text.vtu", "Ascii")
xml("base64.vtu", "Binary", header=64)
xml("zlib.vtu", "Binary", zlib=True)
xml("raw.vtu", "Appended", header=64)
xml("appended64.vtu", "Appended", base64=True)
xml("appendedzlib.vtu", "Appended", zlib=True, base64=True)
xml("rawzlib.vtu", "Appended", zlib=True, header=64)
xml("big.vtu", "Appended", big=True)
for version in (42, 51):
    legacy(f"legacy{version}a.vtk", version, "ASCII")
    legacy(f"legacy{version}b.vtk", version, "Binary")
of_meshio()
of_gmsh()
