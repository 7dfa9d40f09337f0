#!/usr/bin/env python3
"""GetFEM on hertz-plane and hertz-sphere. usage: /usr/bin/python3 getfem_contact.py SCENE LEVEL [--meshes DIR]
Needs: apt install python3-getfem python3-gmsh

An integral augmented Lagrangian, r = 100, solved by Newton's method with MUMPS: the complementarity holds at the
quadrature points, so that the discrete problem differs slightly from that of the others.
"""
import argparse
import subprocess

import getfem
import numpy as np

import report
from scenes import DEPTH, WHOLE_BODY, grid

AUGMENTATION = 100.0
TOLERANCE = 1e-9
HELD, CONTACT, X0, Y0 = 1, 2, 3, 4

SCENES = {
    # Distance of the deformed place, its slope upwards, side that is held, side in contact.
    "hertz-plane": (f"((X+u)(3)-({DEPTH - 1}))", "1", "top", "contact"),
    "hertz-sphere": (
        f"(Norm(X+u-[0;0;{1 - DEPTH}])-1)",
        f"(((X+u)(3)-{1 - DEPTH})/Norm(X+u-[0;0;{1 - DEPTH}]))",
        "z0",
        "z1",
    ),
}


def mesh_of(made, held, contact):
    mesh = getfem.Mesh("empty", 3)
    corners = made.points[made.cells].transpose(2, 1, 0)
    mesh.add_convex(getfem.GeoTrans("GT_PK(3,1)"), np.ascontiguousarray(corners))
    # GetFEM numbers points anew: sides are found by the centre of each facet.
    key = lambda centre: tuple(np.round(centre, 9))
    sides = {key(made.points[facet].mean(axis=0)): side for facet, side in zip(made.facets, made.sides)}
    regions = {HELD: held, CONTACT: contact, X0: "x0", Y0: "y0"}
    outer, points = mesh.outer_faces(), mesh.pts()
    names = []
    for cell, face in outer.T:
        ids = mesh.pid_in_faces(np.array([[cell], [face]]))
        names.append(sides.get(key(points[:, np.unique(ids)].mean(axis=1))))
    names = np.array(names)
    for region, side in regions.items():
        mesh.set_region(region, outer[:, names == side])
    return mesh


def model_of(mesh, distance, slope):
    rule = getfem.MeshIm(mesh, getfem.Integ("IM_TETRAHEDRON(6)"))
    spaces = [getfem.MeshFem(mesh, count) for count in (3, 1, 1)]
    for space, degree in zip(spaces, (2, 1, 1)):
        space.set_fem(getfem.Fem(f"FEM_PK(3,{degree})"))
    model = getfem.Model("real")
    model.add_fem_variable("u", spaces[0])
    model.add_fem_variable("p", spaces[1])
    model.add_filtered_fem_variable("l", spaces[2], CONTACT)
    model.add_initialized_data("r", AUGMENTATION)
    model.add_linear_term(rule, "2*Sym(Grad_u):Grad_Test_u - p*Div_Test_u - Test_p*Div_u")
    pressure = f"pos_part(l-r*{distance})"
    gradient = "[0;0;1]" if slope == "1" else f"((X+u-[0;0;{1 - DEPTH}])/Norm(X+u-[0;0;{1 - DEPTH}]))"
    model.add_nonlinear_term(rule, f"-{pressure}*({gradient}.Test_u) + (1/r)*({pressure}-l)*Test_l", CONTACT)
    model.add_Dirichlet_condition_with_simplification("u", HELD)
    for region, axis, name in ((X0, 0, "hx"), (Y0, 1, "hy")):
        projector = np.zeros((3, 3))
        projector[axis, axis] = 1.0
        model.add_initialized_data(f"{name}v", np.zeros(3))
        model.add_initialized_data(f"{name}m", projector.ravel(), [3, 3])
        model.add_generalized_Dirichlet_condition_with_multipliers(rule, "u", spaces[0], region, f"{name}v", f"{name}m")
    return model, rule, spaces


def debian_version(package):
    """GetFEM does not tell its own."""
    asked = subprocess.run(["dpkg-query", "-W", "-f", "${Version}", package], capture_output=True, text=True, check=False)
    return asked.stdout or "unknown"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene", choices=sorted(SCENES))
    parser.add_argument("level", help="l1, l2, ..")
    parser.add_argument("--meshes", help="folder of finer meshes")
    arguments = parser.parse_args()
    distance, slope, held, contact = SCENES[arguments.scene]
    mesh = mesh_of(grid(arguments.scene, arguments.level, arguments.meshes), held, contact)
    clock = report.Clock()
    with clock.phase("setup"):
        model, rule, spaces = model_of(mesh, distance, slope)
    # GetFEM assembles and factorises inside one call.
    with clock.phase("solve"):
        model.solve("max_res", TOLERANCE, "max_iter", 60, "lsolver", "mumps")
    memory = report.peak_memory_mb()
    whole_body = WHOLE_BODY[arguments.scene]
    integral = lambda text, region: getfem.asm_generic(rule, 0, text, region, model)
    force = whole_body * abs(integral(f"l*{slope}", CONTACT))
    energy = whole_body * integral("Sym(Grad_u):Sym(Grad_u)", -1)
    multipliers = model.variable("l")
    unknowns = spaces[0].nbdof() + spaces[1].nbdof() + len(multipliers)
    version = "GetFEM " + debian_version("python3-getfem")
    report.emit(arguments.scene, arguments.level, "GetFEM augmented Lagrangian", unknowns, clock, 1, version,
                peak_memory_mb=memory, value_force=force, value_strain_energy=energy,
                value_contact_pressure=float(max(multipliers)))


if __name__ == "__main__":
    main()
