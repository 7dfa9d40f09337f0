#!/usr/bin/env python3
"""FEniCSx with PETSc on cube-bend and A1m. usage: /usr/bin/python3 fenicsx_linear.py SCENE LEVEL
Needs: apt install python3-dolfinx (Debian: dolfinx 0.5 with PETSc 3.18, one thread by build)

MINRES, block-diagonal. Displacement: smoothed aggregation (GAMG) with the six rigid modes. Pressure: exact mass,
2 mu M^-1 (MUMPS). Stopped at a relative preconditioned residual of 1e-8.
"""
import argparse

import dolfinx
import numpy as np
import ufl
from dolfinx import fem
from dolfinx.mesh import create_mesh, locate_entities_boundary, meshtags
from mpi4py import MPI
from petsc4py import PETSc

import report
from scenes import A1M_NORMS, grid

TOLERANCE = 1e-8
LOAD_DEGREE, ERROR_DEGREE = 6, 10
VERSION = f"FEniCSx {dolfinx.__version__}, PETSc {'.'.join(map(str, PETSc.Sys.getVersion()))}"


def mesh_of(level):
    made = grid("cube-bend", level)
    domain = ufl.Mesh(ufl.VectorElement("Lagrange", ufl.Cell("tetrahedron", geometric_dimension=3), 1))
    return create_mesh(MPI.COMM_WORLD, made.cells.astype(np.int64), made.points, domain)


def tagged_boundary(mesh):
    """Tag 1 on x0, 2 on x1, 3 on the other sides."""
    on = lambda axis, end: (lambda x: np.isclose(x[axis], end))
    found, tags = [], []
    for axis in range(3):
        for end in (0.0, 1.0):
            facets = locate_entities_boundary(mesh, 2, on(axis, end))
            tag = {(0, 0.0): 1, (0, 1.0): 2}.get((axis, end), 3)
            found.append(facets)
            tags.append(np.full(len(facets), tag, dtype=np.int32))
    found, tags = np.concatenate(found), np.concatenate(tags)
    order = np.argsort(found)
    return meshtags(mesh, 2, found[order], tags[order])


def exact(mesh):
    x = ufl.SpatialCoordinate(mesh)
    # The first component of the potential is zero.
    second = x[0] ** 3 * x[1] * x[2] ** 2
    third = x[0] ** 3 * ufl.sin(ufl.pi * x[1]) * ufl.cos(x[2])
    field = ufl.as_vector((third.dx(1) - second.dx(2), -third.dx(0), second.dx(0)))
    return field, ufl.cos(ufl.pi * x[0]) * x[1] * x[2]


def load_form(scene, mesh, sides, v, field):
    if scene == "cube-bend":
        ds = ufl.Measure("ds", domain=mesh, subdomain_data=sides)
        return ufl.inner(fem.Constant(mesh, (0.0, 0.0, -1.0)), v) * ds(2)
    degree = {"quadrature_degree": LOAD_DEGREE}
    ds = ufl.Measure("ds", domain=mesh, subdomain_data=sides, metadata=degree)
    u, p = field
    stress = 2 * ufl.sym(ufl.grad(u)) - p * ufl.Identity(3)
    normal = ufl.FacetNormal(mesh)
    traction = ufl.inner(ufl.dot(stress, normal), v)
    return ufl.inner(-ufl.div(stress), v) * ufl.dx(mesh, metadata=degree) + traction * ds(2) + traction * ds(3)


def rigid_modes(space):
    """Six orthonormal vectors: translations and rotations."""
    index, block = space.dofmap.index_map, space.dofmap.index_map_bs
    count = block * index.size_local
    places = space.tabulate_dof_coordinates()[: index.size_local]
    modes = np.zeros((6, count))
    for axis in range(3):
        modes[axis, axis::block] = 1.0
    x, y, z = places.T
    modes[3, 0::block], modes[3, 1::block] = -y, x
    modes[4, 0::block], modes[4, 2::block] = z, -x
    modes[5, 1::block], modes[5, 2::block] = -z, y
    vectors = [PETSc.Vec().createWithArray(mode, comm=space.mesh.comm) for mode in np.linalg.qr(modes.T)[0].T.copy()]
    return PETSc.NullSpace().create(vectors=vectors)


def solver_of(matrix, inverse, space):
    ksp = PETSc.KSP().create(matrix.comm)
    ksp.setOperators(matrix, inverse)
    ksp.setType("minres")
    ksp.setTolerances(rtol=TOLERANCE, max_it=1000)
    ksp.pc.setType("fieldsplit")
    ksp.pc.setFieldSplitType(PETSc.PC.CompositeType.ADDITIVE)
    rows = inverse.getNestISs()[0]
    ksp.pc.setFieldSplitIS(("u", rows[0]), ("p", rows[1]))
    displacement, pressure = ksp.pc.getFieldSplitSubKSP()
    displacement.setType("preonly")
    displacement.pc.setType("gamg")
    pressure.setType("preonly")
    pressure.pc.setType("cholesky")
    pressure.pc.setFactorSolverType("mumps")
    inverse.getNestSubMatrix(0, 0).setNearNullSpace(rigid_modes(space))
    ksp.pc.setUp()
    displacement.setUp()
    pressure.setUp()
    return ksp


def solve(scene, mesh, sides, field, clock):
    displacement = fem.VectorFunctionSpace(mesh, ("CG", 2))
    pressure = fem.FunctionSpace(mesh, ("CG", 1))
    u, v = ufl.TrialFunction(displacement), ufl.TestFunction(displacement)
    p, q = ufl.TrialFunction(pressure), ufl.TestFunction(pressure)
    held = fem.locate_dofs_topological(displacement, 2, sides.find(1))
    zero = fem.Function(displacement)
    conditions = [fem.dirichletbc(zero, held)]
    # Compiling the forms is not counted: it is cached.
    a = fem.form([[2 * ufl.inner(ufl.sym(ufl.grad(u)), ufl.sym(ufl.grad(v))) * ufl.dx, -p * ufl.div(v) * ufl.dx], [-q * ufl.div(u) * ufl.dx, None]])
    mass = fem.form(0.5 * p * q * ufl.dx)
    load = fem.form([load_form(scene, mesh, sides, v, field), fem.Constant(mesh, 0.0) * q * ufl.dx])
    with clock.phase("assembly"):
        matrix = fem.petsc.assemble_matrix_nest(a, bcs=conditions)
        matrix.assemble()
        metric = fem.petsc.assemble_matrix(mass)
        metric.assemble()
        right = fem.petsc.assemble_vector_nest(load)
        fem.petsc.apply_lifting_nest(right, a, bcs=conditions)
        for part in right.getNestSubVecs():
            part.ghostUpdate(addv=PETSc.InsertMode.ADD, mode=PETSc.ScatterMode.REVERSE)
        fem.petsc.set_bc_nest(right, fem.bcs_by_block(fem.extract_function_spaces(load), conditions))
    with clock.phase("setup"):
        inverse = PETSc.Mat().createNest([[matrix.getNestSubMatrix(0, 0), None], [None, metric]])
        inverse.assemble()
        ksp = solver_of(matrix, inverse, displacement)
    found = fem.Function(displacement), fem.Function(pressure)
    with clock.phase("solve"):
        both = PETSc.Vec().createNest([part.vector for part in found])
        ksp.solve(right, both)
    assert ksp.getConvergedReason() > 0, ksp.getConvergedReason()
    unknowns = displacement.dofmap.index_map.size_global * 3 + pressure.dofmap.index_map.size_global
    return found, unknowns, ksp.getIterationNumber()


def results(scene, mesh, field, solution):
    u, p = solution
    measure = ufl.dx(mesh, metadata={"quadrature_degree": ERROR_DEGREE})
    integral = lambda density: fem.assemble_scalar(fem.form(density * measure))
    if scene == "cube-bend":
        strain = ufl.sym(ufl.grad(u))
        return {"value_strain_energy": integral(ufl.inner(strain, strain))}
    norm = lambda error: integral(ufl.inner(error, error)) ** 0.5
    exact_u, exact_p = field
    errors = {
        "displacement_l2": norm(u - exact_u),
        "displacement_h1": norm(ufl.grad(u) - ufl.grad(exact_u)),
        "pressure_l2": norm(p - exact_p),
    }
    return {f"error_{name}": error / A1M_NORMS[name] for name, error in errors.items()}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene", choices=["cube-bend", "A1m"])
    parser.add_argument("level", help="n6, n10, ..")
    arguments = parser.parse_args()
    mesh = mesh_of(arguments.level)
    mesh.topology.create_connectivity(2, 3)
    sides = tagged_boundary(mesh)
    field = exact(mesh) if arguments.scene == "A1m" else None
    clock = report.Clock()
    solution, unknowns, iterations = solve(arguments.scene, mesh, sides, field, clock)
    memory = report.peak_memory_mb()
    found = results(arguments.scene, mesh, field, solution)
    report.emit(arguments.scene, arguments.level, "PETSc GAMG", unknowns, clock, 1, VERSION,
                iterations=iterations, peak_memory_mb=memory, **found)


if __name__ == "__main__":
    main()
