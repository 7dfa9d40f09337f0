"""Whether an equilibrium is a minimum: the inertia of the saddle point matrix, rows of multipliers above zero held,

    negative eigenvalues = pressures + held rows + unstable motions

and the lowest eigenvalue l of the tangent on the kernel of the constraints (finite 1/K: with the pressure condensed),

    K x + B' q + C' y = l M x,   M = I (plain) or M = int 2 mu eps : eps (relative)
"""
import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as spl

from saddle_linear import Factor

# Multipliers below this share of the largest do not hold.
STRONG = 1e-9


def matrix(solver, state, drive):
    """The saddle point matrix at an equilibrium and the number of its constraints."""
    obstacles = solver.problem.placed(drive)
    body = solver.body.respond(state.u, state.p)
    contact = solver.surface.contact(state.u, obstacles, state.multipliers)
    active = state.multipliers > STRONG * np.abs(state.multipliers).max(initial=0.0)
    return solver.system(active, (body, *contact)), solver.body.pressures + int(active.sum())


def unstable_motions(solver, state, drive):
    """Number of negative eigenvalues of the tangent on the kernel of the constraints."""
    system, constraints = matrix(solver, state, drive)
    factor = Factor(system)
    count = factor.negatives() - constraints
    factor.free()
    return count


def lowest(solver, state, drive, relative=True):
    """The lowest eigenvalue."""
    system, constraints = matrix(solver, state, drive)
    free = int(solver.free.sum())
    mass = sp.identity(free)
    if relative:
        rest = solver.rest()
        mass = solver.body.respond(rest.u, rest.p).stiffness[solver.free][:, solver.free]
    size = system.shape[0]
    mass = sp.bmat([[mass, None], [None, sp.csr_matrix((size - free, size - free))]], format="csr")
    shift = 0.0
    while True:
        factor = Factor((system - shift * mass).tocsr())
        if factor.negatives() <= constraints:
            break
        factor.free()
        shift = 4.0 * shift - 1e-3
    operator = spl.LinearOperator((size, size), matvec=factor.solve, dtype=float)
    start = factor.solve(mass @ np.random.default_rng(1).standard_normal(size))
    values = spl.eigsh(
        system, k=1, M=mass, sigma=shift, OPinv=operator, v0=start, return_eigenvectors=False, tol=1e-9
    )
    factor.free()
    return float(values[0])
