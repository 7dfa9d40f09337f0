#!/usr/bin/env python3
"""NGSolve on hertz-plane and hertz-sphere. usage: ngsolve_contact.py SCENE LEVEL [--meshes DIR]
Needs: pip install ngsolve mkl numpy gmsh

A primal-dual active set, which is a semismooth Newton method, with the exact P1 multiplier: the stationary point of
the energy minus int l d(x + u) dS on the reference surface, l_i >= 0, g_i = int phi_i d >= 0, l_i g_i = 0. Each
iteration assembles the tangent, the curvature of the obstacle included, and factorises it (Pardiso). Ends when the
set repeats and the residual has fallen to 1e-10 of the first contact force.
"""
import argparse
import sys

import ngsolve as ng
from ngsolve import CF, BilinearForm, GridFunction, InnerProduct, div, dx, ds

import report
from ngsolve_common import VERSION, mesh_of, strain
from scenes import DEPTH, WHOLE_BODY, grid

TOLERANCE = 1e-10
MOST_ITERATIONS = 40
# Beyond the order of the elements: the distance of a sphere is no polynomial.
MORE_ORDER = 4


class Plane:
    """Half space that rises: d(x) = z - (-1 + depth)."""

    contact, held, symmetric = "contact", "top", ("x0", "y0", "")
    upwards = 1.0

    def distance(self, place):
        return place[2] - (-1.0 + DEPTH)


class Sphere:
    """Sphere of radius 1 that sinks: d(x) = |x - c| - 1."""

    contact, held, symmetric = "z1", "z0", ("x0", "y0", "")
    upwards = -1.0

    def distance(self, place):
        centre = CF((0, 0, 1 - DEPTH))
        return ng.sqrt(InnerProduct(place - centre, place - centre)) - 1.0


def spaces(mesh, obstacle):
    # Sides that hold all components, and the one that holds each.
    x, y, z = ("|".join(side for side in (obstacle.held, own) if side) for own in obstacle.symmetric)
    displacement = ng.VectorH1(mesh, order=2, dirichletx=x, dirichlety=y, dirichletz=z)
    pressure = ng.H1(mesh, order=1)
    multiplier = ng.H1(mesh, order=1, definedon=mesh.Boundaries(obstacle.contact))
    return ng.FESpace([displacement, pressure, multiplier])


def energy_form(space, obstacle):
    """The Lagrangian, whose derivatives NGSolve takes."""
    u, p, l = space.TrialFunction()
    place = CF((ng.x, ng.y, ng.z)) + u
    form = BilinearForm(space)
    form += ng.Variation((InnerProduct(strain(u), strain(u)) - p * div(u)) * dx)
    form += ng.Variation(
        -l * obstacle.distance(place) * ds(obstacle.contact, bonus_intorder=MORE_ORDER)
    )
    return form


def solve(mesh, space, obstacle, clock):
    with clock.phase("assembly"):
        form = energy_form(space, obstacle)
    both = GridFunction(space)
    both.vec[:] = 0
    return both, equilibrium(mesh, form, both, obstacle, clock)


def equilibrium(mesh, form, both, obstacle, clock):
    """Newton's method on the active set from the state `both`; gives its iterations."""
    space = both.space
    offset = space.components[0].ndof + space.components[1].ndof
    candidates = contact_dofs(mesh, space, obstacle)
    with clock.phase("assembly"):
        test = space.components[2].TestFunction()
        weights = ng.LinearForm(space.components[2])
        weights += test * ds(obstacle.contact)
        weights.Assemble()
    residual, step = both.vec.CreateVector(), both.vec.CreateVector()
    active, first, iterations = None, None, 0
    while iterations < MOST_ITERATIONS:
        with clock.phase("assembly"):
            form.Apply(both.vec, residual)
        # The derivative by l_i is -g_i. In contact: l_i - c g_i / w_i > 0, any c > 0.
        chosen = set()
        for dof in candidates:
            gap = -residual[offset + dof] / weights.vec[dof]
            if both.vec[offset + dof] - 10.0 * gap > 0:
                chosen.add(dof)
        for dof in candidates:
            if dof not in chosen:
                both.vec[offset + dof] = 0.0
        free = ng.BitArray(space.FreeDofs())
        for dof in range(space.components[2].ndof):
            free.Clear(offset + dof)
        for dof in chosen:
            free.Set(offset + dof)
        with clock.phase("assembly"):
            form.Apply(both.vec, residual)
        projected = residual.CreateVector()
        projected.data = ng.Projector(free, True) * residual
        size = projected.Norm()
        if chosen == active and size <= TOLERANCE * first:
            break
        with clock.phase("assembly"):
            form.AssembleLinearization(both.vec)
        with clock.phase("setup"):
            factor = form.mat.Inverse(free, inverse="pardiso")
        with clock.phase("solve"):
            step.data = factor * residual
            # One refinement: the factor of an indefinite matrix is pivoted statically.
            again = residual.CreateVector()
            again.data = residual - form.mat * step
            step.data += factor * again
            both.vec.data -= step
        first = size if first is None else max(first, size)
        active, iterations = chosen, iterations + 1
    return iterations


def contact_dofs(mesh, space, obstacle):
    """Unknowns of the multiplier on the contact surface."""
    found = set()
    for element in space.components[2].Elements(ng.BND):
        if element.mat == obstacle.contact:
            found.update(dof for dof in element.dofs if dof >= 0)
    return sorted(found)


def results(mesh, obstacle, both, whole_body):
    u, _, l = both.components
    place = CF((ng.x, ng.y, ng.z)) + u
    distance = obstacle.distance(place)
    # The obstacle's force on the body is l times the gradient of d; its z component along the motion.
    if isinstance(obstacle, Plane):
        slope = CF(1.0)
    else:
        slope = (place[2] - (1 - DEPTH)) / (distance + 1.0)
    surface = mesh.Boundaries(obstacle.contact)
    force = ng.Integrate(l * slope * obstacle.upwards, mesh, ng.BND, definedon=surface, order=8)
    energy = ng.Integrate(InnerProduct(strain(u), strain(u)), mesh, order=4)
    return {
        "value_force": whole_body * abs(force),
        "value_strain_energy": whole_body * energy,
        "value_contact_pressure": max(l.vec),
    }


SCENES = {"hertz-plane": Plane, "hertz-sphere": Sphere}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene", choices=sorted(SCENES))
    parser.add_argument("level", help="l1, l2, ..")
    parser.add_argument("--meshes", help="folder of finer meshes")
    arguments = parser.parse_args()
    used = report.threads()
    ng.SetNumThreads(used)
    obstacle = SCENES[arguments.scene]()
    clock = report.Clock()
    with ng.TaskManager():
        mesh = mesh_of(grid(arguments.scene, arguments.level, arguments.meshes))
        with clock.phase("setup"):
            space = spaces(mesh, obstacle)
        both, iterations = solve(mesh, space, obstacle, clock)
        memory = report.peak_memory_mb()
        found = results(mesh, obstacle, both, WHOLE_BODY[arguments.scene])
    unknowns = sum(space.components[k].ndof for k in (0, 1)) + len(contact_dofs(mesh, space, obstacle))
    print(f"{arguments.scene} {arguments.level}: {iterations} iterations of the active set", file=sys.stderr)
    report.emit(arguments.scene, arguments.level, "NGSolve active set", unknowns, clock, used, VERSION,
                peak_memory_mb=memory, **found)


if __name__ == "__main__":
    main()
