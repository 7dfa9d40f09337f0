"""Makes the section of an O-ring with Gmsh (`pip install gmsh`): 50 x 5.33 mm, its own mesh in a minute."""

import sys

import gmsh

RADIUS, CENTRE, SIZE = 2.665, 27.665, 0.3

gmsh.initialize()
gmsh.option.setNumber("General.Terminal", 0)
disk = gmsh.model.occ.addDisk(CENTRE, 0, 0, RADIUS, RADIUS)
gmsh.model.occ.synchronize()
curves = [tag for _, tag in gmsh.model.getBoundary([(2, disk)])]
gmsh.model.addPhysicalGroup(2, [disk], name="rubber")
gmsh.model.addPhysicalGroup(1, [abs(tag) for tag in curves], name="skin")
gmsh.option.setNumber("Mesh.MeshSizeMax", SIZE)
gmsh.model.mesh.generate(2)
gmsh.model.mesh.setOrder(2)  # curved sides: the contact of a round body needs them
gmsh.write(sys.argv[1] if len(sys.argv) > 1 else "o-ring.msh")
gmsh.finalize()
