#!/usr/bin/env python3
"""GetFEM on cube-drag and hertz-press. usage: /usr/bin/python3 getfem_friction.py SCENE LEVEL [--meshes DIR]
Needs: apt install python3-getfem python3-gmsh

GetFEM's brick of integral contact with a rigid obstacle and Coulomb friction: the augmented Lagrangian of Alart and Curnier, unsymmetric,
P2 displacement, P1 multiplier, solved by Newton's method with MUMPS, a factor each iteration. Contact and friction hold at quadrature
points, so that the discrete problem differs slightly from Signorini's. Nothing is regularised. The augmentation r is the one of 1, 10 and 100 that takes
fewest iterations: 4 or 5 an increment; 10 takes 17 and changes the forces by 1e-4 to 6e-4, 100 does not converge.
"""
import argparse
import sys

import getfem
import numpy as np

import report
from friction_scenes import FRICTION, LAME, SCENES, SHEAR, values_of
from getfem_contact import CONTACT, HELD, debian_version, mesh_of
from scenes import WHOLE_BODY, grid

AUGMENTATION = 1.0
TOLERANCE = 1e-9
MOST_ITERATIONS = 60
REGIONS = {"x0": 3, "y0": 4}


class Problem:
    """A GetFEM model and what moves in it."""

    def __init__(self, mesh, scene):
        self.scene = scene
        self.rule = getfem.MeshIm(mesh, getfem.Integ("IM_TETRAHEDRON(6)"))
        self.spaces = [getfem.MeshFem(mesh, count) for count in (3, 3, 1)]
        for space, degree in zip(self.spaces, (2, 1, 1)):
            space.set_fem(getfem.Fem(f"FEM_PK(3,{degree})"))
        self.displacement, multiplier, self.distance = self.spaces
        self.heights = self.distance.basic_dof_nodes()[2]
        self.model = model = getfem.Model("real")
        model.add_fem_variable("u", self.displacement)
        model.add_filtered_fem_variable("l", multiplier, CONTACT)
        for name, value in (("r", AUGMENTATION), ("friction", FRICTION), ("one", 1.0)):
            model.add_initialized_data(name, [value])
        model.add_initialized_fem_data("obstacle", self.distance, self.gap((0.0, 0.0, 0.0)))
        model.add_initialized_fem_data("before", self.displacement, np.zeros(self.displacement.nbdof()))
        model.add_linear_term(self.rule, f"{2.0 * SHEAR}*Sym(Grad_u):Grad_Test_u + {LAME}*Div_u*Div_Test_u")
        model.add_integral_contact_with_rigid_obstacle_brick(
            self.rule, "u", "l", "obstacle", "r", "friction", CONTACT, 1, "one", "before"
        )
        model.add_Dirichlet_condition_with_simplification("u", HELD)
        for side, axis in scene.symmetric:
            self.hold(REGIONS[side], axis)

    def hold(self, region, axis):
        projector = np.zeros((3, 3))
        projector[axis, axis] = 1.0
        self.model.add_initialized_data(f"values{axis}", np.zeros(3))
        self.model.add_initialized_data(f"axis{axis}", projector.ravel(), [3, 3])
        self.model.add_generalized_Dirichlet_condition_with_multipliers(
            self.rule, "u", self.displacement, region, f"values{axis}", f"axis{axis}"
        )

    def gap(self, place):
        """Signed distance to the tool, at the vertices."""
        return self.scene.above * (self.scene.height + place[2] - self.heights)

    def increment(self, start, end):
        """Solves for the tool at `end`; gives Newton's iterations, none where it does not converge."""
        moved = np.tile(np.subtract(end, start), self.displacement.nbdof() // 3)
        self.model.set_variable("obstacle", self.gap(end))
        # Slip is the displacement beyond that of the tool's material point.
        self.model.set_variable("before", self.model.variable("u") + moved)
        count, converged = self.model.solve("max_res", TOLERANCE, "max_iter", MOST_ITERATIONS, "lsolver", "mumps")
        return count if converged else None

    def force(self):
        return getfem.asm_generic(self.rule, 0, "-l", CONTACT, self.model)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene", choices=sorted(SCENES))
    parser.add_argument("level", help="n6, l1, ..")
    parser.add_argument("--meshes", help="folder of finer meshes")
    arguments = parser.parse_args()
    scene = SCENES[arguments.scene]
    getfem.util_trace_level(1)
    mesh = mesh_of(grid(arguments.scene, arguments.level, arguments.meshes), scene.held, scene.contact)
    clock = report.Clock()
    with clock.phase("setup"):
        problem = Problem(mesh, scene)
    iterations, place = [], (0.0, 0.0, 0.0)
    for end in scene.path:
        # GetFEM assembles and factorises inside one call.
        with clock.phase("solve"):
            iterations.append(problem.increment(place, end))
        if iterations[-1] is None:
            sys.exit(f"increment {len(iterations)} did not converge in {MOST_ITERATIONS} iterations")
        place = end
    memory = report.peak_memory_mb()
    print(f"{arguments.scene} {arguments.level}: {iterations} iterations of Newton's method", file=sys.stderr)
    unknowns = problem.displacement.nbdof() + len(problem.model.variable("l"))
    version = "GetFEM " + debian_version("python3-getfem")
    report.emit(arguments.scene, arguments.level, "GetFEM augmented Lagrangian", unknowns, clock, 1, version,
                peak_memory_mb=memory, **values_of(problem.force(), WHOLE_BODY[arguments.scene]))


if __name__ == "__main__":
    main()
