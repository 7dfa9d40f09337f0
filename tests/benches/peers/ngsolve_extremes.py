#!/usr/bin/env python3
"""NGSolve on the bent bodies of `signorini bench --study extremes`. usage: ngsolve_extremes.py FOLDER > peers.csv
Needs: pip install ngsolve mkl numpy

FOLDER is the folder `extremes` that the bench leaves beside its page: scene and mesh of every row. Each row that is listed
here is solved on the same mesh by a direct factor of the saddle point, which the bench compares with, and by the two-level
MINRES of ngsolve_linear.py, to a relative preconditioned residual of 1e-8 within 1000 iterations. The value is the strain
energy, half of the work of the loads; seconds are wall time without reading the mesh.
"""
import argparse
import pathlib
import sys
import tomllib

import netgen.meshing as netgen
import ngsolve as ng
import numpy as np
from ngsolve import CF, BilinearForm, GridFunction, InnerProduct, LinearForm, div, dx, ds
from ngsolve.krylovspace import MinResSolver

import report
from ngsolve_common import VERSION, strain
from ngsolve_linear import TOLERANCE, TwoLevel, node_blocks, vertex_unknowns

ROWS = (
    "nu-half nu-bent-3 nu-bent-6 nu-bent-9 nu-bent-12 ball-1e6 ball-1e-6 ball-1e12 bent-10-1 bent-100-1 bent-1-10 "
    "bent-slivers"
).split()
MOST_ITERATIONS = 1000


def mesh_of(path):
    """The mesh of a MSH 2.2 file, with its groups as boundary conditions and materials."""
    lines = iter(path.read_text().splitlines())
    names, points, elements = {}, [], []
    for line in lines:
        if line == "$PhysicalNames":
            for _ in range(int(next(lines))):
                dimension, tag, name = next(lines).split()
                names[int(dimension), int(tag)] = name.strip('"')
        elif line == "$Nodes":
            points = [next(lines).split()[1:] for _ in range(int(next(lines)))]
        elif line == "$Elements":
            elements = [[int(word) for word in next(lines).split()] for _ in range(int(next(lines)))]
    mesh = netgen.Mesh(3)
    mesh.AddPoints(np.array(points, dtype=float))
    for dimension, kind in ((2, 2), (3, 4)):
        groups = [(tag, name) for (of, tag), name in names.items() if of == dimension]
        for index, (tag, name) in enumerate(groups, start=1):
            if dimension == 2:
                mesh.Add(netgen.FaceDescriptor(surfnr=index, domin=1, bc=index))
            corners = np.array([row[5:] for row in elements if row[1] == kind and row[3] == tag], dtype=np.int32)
            mesh.AddElements(dim=dimension, index=index, data=corners - 1, base=0)
            if dimension == 2:
                mesh.SetBCName(index - 1, name)
            else:
                mesh.SetMaterial(index, name)
    return ng.Mesh(mesh)


def coefficients(mesh, scene):
    """Shear modulus and inverse Lame modulus, group by group."""
    laws = scene["material"]
    mu = {name: law["shear_modulus"] for name, law in laws.items()}
    soft = {name: (1 - 2 * law["poisson_ratio"]) / (2 * mu[name] * law["poisson_ratio"]) for name, law in laws.items()}
    return mesh.MaterialCF(mu), mesh.MaterialCF(soft)


def loads(scene, space):
    load = LinearForm(space)
    for traction in scene["traction"]:
        load += CF(tuple(traction["value"])) * space.TestFunction() * ds(traction["on"])
    return load.Assemble()


def direct(mesh, scene, clock):
    displacement = ng.VectorH1(mesh, order=2, dirichlet=scene["support"][0]["on"])
    pressure = ng.H1(mesh, order=1)
    space = displacement * pressure
    (u, p), (v, q) = space.TnT()
    mu, soft = coefficients(mesh, scene)
    with clock.phase("assembly"):
        form = 2 * mu * InnerProduct(strain(u), strain(v)) - p * div(v) - q * div(u) - soft * p * q
        a = BilinearForm(form * dx).Assemble()
        load = loads(scene, displacement)
    with clock.phase("setup"):
        factor = a.mat.Inverse(space.FreeDofs(), inverse="pardiso")
    both = GridFunction(space)
    with clock.phase("solve"):
        right = both.vec.CreateVector()
        right[:] = 0
        right[0 : displacement.ndof] = load.vec
        both.vec.data = factor * right
        # The factor of an indefinite matrix is pivoted statically.
        residual = both.vec.CreateVector()
        for _ in range(3):
            residual.data = right - a.mat * both.vec
            both.vec.data += factor * residual
    return InnerProduct(load.vec, both.components[0].vec), None


def two_level(mesh, scene, clock):
    displacement = ng.VectorH1(mesh, order=2, dirichlet=scene["support"][0]["on"])
    pressure = ng.H1(mesh, order=1)
    (u, v), (p, q) = displacement.TnT(), pressure.TnT()
    mu, soft = coefficients(mesh, scene)
    with clock.phase("assembly"):
        a = BilinearForm(2 * mu * InnerProduct(strain(u), strain(v)) * dx).Assemble()
        b = BilinearForm(-div(u) * q * dx).Assemble()
        is_soft = any(law["poisson_ratio"] < 0.5 for law in scene["material"].values())
        c = BilinearForm(-soft * p * q * dx).Assemble().mat if is_soft else None
        mass = BilinearForm((0.5 / mu + soft) * p * q * dx).Assemble()
        load = loads(scene, displacement)
    with clock.phase("setup"):
        smoother = a.mat.CreateBlockSmoother(node_blocks(displacement, mesh))
        coarse = a.mat.Inverse(vertex_unknowns(displacement, mesh), inverse="sparsecholesky")
        inverse_mass = mass.mat.Inverse(pressure.FreeDofs(), inverse="sparsecholesky")
    solution = GridFunction(displacement), GridFunction(pressure)
    with clock.phase("solve"):
        free = ng.Projector(displacement.FreeDofs(), True)
        system = ng.BlockMatrix([[free @ a.mat @ free, free @ b.mat.T], [b.mat @ free, c]])
        inverse = ng.BlockMatrix([[TwoLevel(a.mat, smoother, coarse), None], [None, inverse_mass]])
        right = load.vec.CreateVector()
        right.data = free * load.vec
        zero = solution[1].vec.CreateVector()
        zero[:] = 0
        solver = MinResSolver(mat=system, pre=inverse, maxiter=MOST_ITERATIONS, tol=TOLERANCE, printrates=False)
        solver.Solve(rhs=ng.BlockVector([right, zero]), sol=ng.BlockVector([solution[0].vec, solution[1].vec]))
    return InnerProduct(load.vec, solution[0].vec), solver.iterations


SOLVERS = {"NGSolve Pardiso": direct, "NGSolve two-level MINRES": two_level}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=pathlib.Path)
    folder = parser.parse_args().folder
    used = report.threads()
    ng.SetNumThreads(used)
    print("# Other programs on rows of the study of extreme cases. Written by tests/benches/peers/ngsolve_extremes.py.")
    print(f"# Machine: {report.processor()}, threads: {used}; {VERSION}; one run each, wall seconds without reading the mesh.")
    print(f"# Strain energy. Pardiso: direct, three refinements. Two-level MINRES: to 1e-8 or {MOST_ITERATIONS} iterations.")
    print("row,solver,value,seconds,iterations")
    for row in ROWS:
        scene = tomllib.loads((folder / f"{row}.toml").read_text())
        mesh = mesh_of(folder / f"{row}.msh")
        for name, solve in SOLVERS.items():
            clock = report.Clock()
            with ng.TaskManager():
                work, iterations = solve(mesh, scene, clock)
            steps = "" if iterations is None else iterations
            print(f"{row},{name},{0.5 * work:.12g},{sum(clock.seconds.values()):.3f},{steps}")
            print(row, name, file=sys.stderr, flush=True)


if __name__ == "__main__":
    main()
