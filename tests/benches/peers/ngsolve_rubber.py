#!/usr/bin/env python3
"""NGSolve on mr-uniax, mr-block and mr-sphere. usage: ngsolve_rubber.py SCENE LEVEL [--meshes DIR]
Needs: pip install ngsolve mkl numpy gmsh

The increments of the scene, each from the state before by the Newton method of ngsolve_contact.py: the stationary
point of the isochoric energy of Mooney and Rivlin minus int p (J - 1) dx minus the term of contact. The energy is
integrated to degree 6, from where on the force changes by less than 1e-6.
"""
import argparse
import sys

import ngsolve as ng
from ngsolve import CF, BilinearForm, GridFunction, InnerProduct, ds, dx

import report
from ngsolve_common import VERSION, mesh_of
from ngsolve_contact import MORE_ORDER, contact_dofs, equilibrium, spaces
from scenes import C01, C10, TRAVEL, WHOLE_BODY, grid

# Beyond the order of the elements, 4.
MORE_DEGREE = 2


class Plane:
    """Half space that sinks on the cube: d(x) = 1 - travel - z."""

    contact, held, symmetric = "z1", "z0", ("", "", "")

    def __init__(self):
        self.travel = ng.Parameter(0.0)

    def distance(self, place):
        return 1.0 - self.travel - place[2]

    def slope(self, place):
        return CF(-1.0)


class PlaneOnSlidingCube(Plane):
    """The same on a cube that slides on its base."""

    held, symmetric = "", ("x0", "y0", "z0")


class Sphere:
    """Sphere of radius 1 that sinks: d(x) = |x - c| - 1."""

    contact, held, symmetric = "z1", "z0", ("x0", "y0", "")

    def __init__(self):
        self.travel = ng.Parameter(0.0)

    def from_centre(self, place):
        return place - CF((0, 0, 1 - self.travel))

    def distance(self, place):
        away = self.from_centre(place)
        return ng.sqrt(InnerProduct(away, away)) - 1.0

    def slope(self, place):
        return self.from_centre(place)[2] / (self.distance(place) + 1.0)


SCENES = {"mr-uniax": PlaneOnSlidingCube, "mr-block": Plane, "mr-sphere": Sphere}


def isochoric(gradient):
    """Energy and J of a deformation gradient."""
    jacobian = ng.Det(gradient)
    stretch = gradient.trans * gradient
    first = ng.Trace(stretch)
    second = 0.5 * (first * first - ng.Trace(stretch * stretch))
    energy = C10 * (jacobian ** (-2 / 3) * first - 3) + C01 * (jacobian ** (-4 / 3) * second - 3)
    return energy, jacobian


def energy_form(space, obstacle):
    """The Lagrangian, whose derivatives NGSolve takes."""
    u, p, l = space.TrialFunction()
    energy, jacobian = isochoric(ng.Id(3) + ng.Grad(u))
    place = CF((ng.x, ng.y, ng.z)) + u
    form = BilinearForm(space)
    form += ng.Variation((energy - p * (jacobian - 1)).Compile() * dx(bonus_intorder=MORE_DEGREE))
    form += ng.Variation(-l * obstacle.distance(place) * ds(obstacle.contact, bonus_intorder=MORE_ORDER))
    return form


def solve(mesh, space, obstacle, scene, clock):
    """The last state, and the Newton iterations of all increments."""
    travel, increments = TRAVEL[scene]
    with clock.phase("assembly"):
        form = energy_form(space, obstacle)
    both, iterations = GridFunction(space), 0
    both.vec[:] = 0
    for increment in range(1, increments + 1):
        obstacle.travel.Set(travel * increment / increments)
        iterations += equilibrium(mesh, form, both, obstacle, clock)
    return both, iterations


def results(mesh, obstacle, both, whole_body):
    u, _, l = both.components
    place = CF((ng.x, ng.y, ng.z)) + u
    surface = mesh.Boundaries(obstacle.contact)
    force = ng.Integrate(l * obstacle.slope(place), mesh, ng.BND, definedon=surface, order=8)
    energy, _ = isochoric(ng.Id(3) + ng.Grad(u))
    return {
        "value_force": whole_body * abs(force),
        "value_strain_energy": whole_body * ng.Integrate(energy, mesh, order=8),
        "value_contact_pressure": max(l.vec),
    }


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene", choices=sorted(SCENES))
    parser.add_argument("level", help="n6, n10, .. of the cubes, l1, l2, .. of mr-sphere")
    parser.add_argument("--meshes", help="folder of finer meshes")
    arguments = parser.parse_args()
    scene, used = arguments.scene, report.threads()
    ng.SetNumThreads(used)
    obstacle, clock = SCENES[scene](), report.Clock()
    with ng.TaskManager():
        mesh = mesh_of(grid(scene, arguments.level, arguments.meshes))
        with clock.phase("setup"):
            space = spaces(mesh, obstacle)
        both, iterations = solve(mesh, space, obstacle, scene, clock)
        memory = report.peak_memory_mb()
        found = results(mesh, obstacle, both, WHOLE_BODY[scene])
    unknowns = sum(space.components[k].ndof for k in (0, 1)) + len(contact_dofs(mesh, space, obstacle))
    print(f"{scene} {arguments.level}: {iterations} Newton iterations in all", file=sys.stderr)
    report.emit(scene, arguments.level, "NGSolve active set", unknowns, clock, used, VERSION,
                peak_memory_mb=memory, **found)


if __name__ == "__main__":
    main()
