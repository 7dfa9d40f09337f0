#!/usr/bin/env python3
"""NGSolve on cube-bend and A1m. usage: ngsolve_linear.py SCENE LEVEL two-level|pardiso
Needs: pip install ngsolve mkl numpy

two-level  MINRES, block-diagonal. Displacement: one sweep of node-block Gauss-Seidel, the exact P1 solve (the vertex
           functions of the hierarchical basis of NGSolve), one sweep back. Pressure: exact mass, 2 mu M^-1. Stopped
           at a relative preconditioned residual of 1e-8.
pardiso    A direct factor of the saddle point.
"""
import argparse

import ngsolve as ng
from ngsolve import CF, BilinearForm, GridFunction, InnerProduct, LinearForm, div, dx, ds
from ngsolve.krylovspace import MinResSolver

import report
from ngsolve_common import VERSION, mesh_of, strain
from scenes import A1M_NORMS, grid

TOLERANCE = 1e-8
# Beyond the order of the elements: the loads of A1m are not polynomials.
MORE_ORDER = 4


def exact():
    x, y, z = ng.x, ng.y, ng.z
    potential = CF((0, x**3 * y * z**2, x**3 * ng.sin(ng.pi * y) * ng.cos(z)))
    d = lambda f, i: f.Diff((x, y, z)[i])
    u = CF((d(potential[2], 1) - d(potential[1], 2), d(potential[0], 2) - d(potential[2], 0), d(potential[1], 0) - d(potential[0], 1)))
    p = ng.cos(ng.pi * x) * y * z
    gradient = CF(tuple(d(u[i], j) for i in range(3) for j in range(3)), dims=(3, 3))
    stress = gradient + gradient.trans - p * ng.Id(3)
    force = CF(tuple(-sum(d(stress[i, j], j) for j in range(3)) for i in range(3)))
    return u.Compile(), gradient.Compile(), p.Compile(), stress.Compile(), force.Compile()


class TwoLevel(ng.BaseMatrix):
    """Gauss-Seidel forward, P1, Gauss-Seidel backward."""

    def __init__(self, matrix, smoother, coarse):
        super().__init__()
        self.matrix, self.smoother, self.coarse = matrix, smoother, coarse
        self.residual, self.step = matrix.CreateColVector(), matrix.CreateColVector()

    def Mult(self, b, y):
        y[:] = 0
        self.smoother.Smooth(y, b)
        self.residual.data = b - self.matrix * y
        self.step.data = self.coarse * self.residual
        y.data += self.step
        self.smoother.SmoothBack(y, b)

    def IsComplex(self):
        return False

    def Height(self):
        return self.matrix.height

    def Width(self):
        return self.matrix.width

    def CreateColVector(self):
        return self.matrix.CreateColVector()

    def CreateRowVector(self):
        return self.matrix.CreateRowVector()


def node_blocks(space, mesh):
    """Free unknowns of each vertex and of each edge."""
    free = space.FreeDofs()
    entities = [*mesh.vertices, *mesh.edges]
    blocks = ([dof for dof in space.GetDofNrs(entity) if dof >= 0 and free[dof]] for entity in entities)
    return [block for block in blocks if block]


def vertex_unknowns(space, mesh):
    chosen = ng.BitArray(space.ndof)
    chosen.Clear()
    for vertex in mesh.vertices:
        for dof in space.GetDofNrs(vertex):
            chosen.Set(dof)
    return chosen & space.FreeDofs()


def loads(scene, mesh, space, field):
    v = space.TestFunction()
    load = LinearForm(space)
    if scene == "cube-bend":
        load += CF((0, 0, -1)) * v * ds("x1")
    else:
        _, _, _, stress, force = field
        normal = ng.specialcf.normal(3)
        load += force * v * dx(bonus_intorder=MORE_ORDER)
        load += (stress * normal) * v * ds("x1|y0|y1|z0|z1", bonus_intorder=MORE_ORDER)
    return load.Assemble()


def two_level(scene, mesh, field, clock):
    displacement = ng.VectorH1(mesh, order=2, dirichlet="x0")
    pressure = ng.H1(mesh, order=1)
    (u, v), (p, q) = displacement.TnT(), pressure.TnT()
    with clock.phase("assembly"):
        a = BilinearForm(2 * InnerProduct(strain(u), strain(v)) * dx).Assemble()
        b = BilinearForm(-div(u) * q * dx).Assemble()
        mass = BilinearForm(0.5 * p * q * dx).Assemble()
        load = loads(scene, mesh, displacement, field)
    with clock.phase("setup"):
        smoother = a.mat.CreateBlockSmoother(node_blocks(displacement, mesh))
        coarse = a.mat.Inverse(vertex_unknowns(displacement, mesh), inverse="sparsecholesky")
        inverse_mass = mass.mat.Inverse(pressure.FreeDofs(), inverse="sparsecholesky")
    solution = GridFunction(displacement), GridFunction(pressure)
    with clock.phase("solve"):
        free = ng.Projector(displacement.FreeDofs(), True)
        system = ng.BlockMatrix([[free @ a.mat @ free, free @ b.mat.T], [b.mat @ free, None]])
        inverse = ng.BlockMatrix([[TwoLevel(a.mat, smoother, coarse), None], [None, inverse_mass]])
        right = load.vec.CreateVector()
        right.data = free * load.vec
        zero = solution[1].vec.CreateVector()
        zero[:] = 0
        solver = MinResSolver(mat=system, pre=inverse, maxiter=1000, tol=TOLERANCE, printrates=False)
        both = ng.BlockVector([solution[0].vec, solution[1].vec])
        solver.Solve(rhs=ng.BlockVector([right, zero]), sol=both)
    unknowns = displacement.ndof + pressure.ndof
    return solution, unknowns, solver.iterations


def pardiso(scene, mesh, field, clock):
    displacement = ng.VectorH1(mesh, order=2, dirichlet="x0")
    pressure = ng.H1(mesh, order=1)
    space = displacement * pressure
    (u, p), (v, q) = space.TnT()
    with clock.phase("assembly"):
        form = 2 * InnerProduct(strain(u), strain(v)) - p * div(v) - q * div(u)
        a = BilinearForm(form * dx).Assemble()
        load = loads(scene, mesh, displacement, field)
    with clock.phase("setup"):
        factor = a.mat.Inverse(space.FreeDofs(), inverse="pardiso")
    both = GridFunction(space)
    with clock.phase("solve"):
        right = both.vec.CreateVector()
        right[:] = 0
        right[0 : displacement.ndof] = load.vec
        both.vec.data = factor * right
        # One refinement: the factor of an indefinite matrix is pivoted statically.
        residual = both.vec.CreateVector()
        residual.data = right - a.mat * both.vec
        both.vec.data += factor * residual
    return both.components, space.ndof, None


def results(scene, mesh, field, solution):
    u, p = solution
    if scene == "cube-bend":
        energy = ng.Integrate(InnerProduct(strain(u), strain(u)), mesh, order=4)
        return {"value_strain_energy": energy}
    exact_u, gradient, exact_p, _, _ = field
    norm = lambda error: ng.sqrt(ng.Integrate(InnerProduct(error, error), mesh, order=10))
    errors = {
        "displacement_l2": norm(u - exact_u),
        "displacement_h1": norm(ng.Grad(u) - gradient),
        "pressure_l2": norm(p - exact_p),
    }
    return {f"error_{name}": error / A1M_NORMS[name] for name, error in errors.items()}


SOLVERS = {"two-level": two_level, "pardiso": pardiso}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene", choices=["cube-bend", "A1m"])
    parser.add_argument("level", help="n6, n10, ..")
    parser.add_argument("solver", choices=sorted(SOLVERS))
    arguments = parser.parse_args()
    used = report.threads()
    ng.SetNumThreads(used)
    clock = report.Clock()
    with ng.TaskManager():
        mesh = mesh_of(grid(arguments.scene, arguments.level))
        field = exact() if arguments.scene == "A1m" else None
        solution, unknowns, iterations = SOLVERS[arguments.solver](arguments.scene, mesh, field, clock)
        memory = report.peak_memory_mb()
        found = results(arguments.scene, mesh, field, solution)
    names = {"two-level": "NGSolve two-level", "pardiso": "NGSolve Pardiso"}
    report.emit(arguments.scene, arguments.level, names[arguments.solver], unknowns, clock, used, VERSION,
                iterations=iterations, peak_memory_mb=memory, **found)


if __name__ == "__main__":
    main()
