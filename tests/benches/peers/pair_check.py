"""Whether states that somebody else has found are equilibria here: no Newton's method, so that it takes no time.

At displacements u and pressures p of an increment, multipliers Lam and tractions q of the closed contacts are those of
least squares in

    dE/du - load + C' Lam - R' q = 0

and the rest is told over the largest contact force, with what the laws leave: defects of volume, gaps inside, Lam below
zero, |q| beyond its bound, slips where |q| is below it or along q.
"""
import numpy as np
from scipy.optimize import nnls

from pair_friction import RoughSolver
from pair_newton import PairSolver

# Mean gap over the length that is closed.
CLOSED = 1e-8
# What equations and laws may leave.
SMALL = 1e-6
# How many pressures and tractions of closed contacts the state leaves open: a wall that holds the end of an interface
# takes some whatever they are.
UNDECIDED = "undecided"
# Multipliers over the largest that press.
PRESSING = 1e-9


def states(folder):
    """(u, p) of the files that `solve --out` writes."""
    import meshio

    for path in sorted(folder.glob("*_[0-9][0-9][0-9][0-9].vtu")):
        data = meshio.read(path).point_data
        yield data["displacement"][:, :2].ravel().copy(), data.get("pressure", np.zeros(0)).ravel()


def rests(problem, found):
    """What each of the states leaves, a dictionary an increment."""
    is_rough = any("friction" in table or "tresca" in table for table in problem.contacts)
    solver = RoughSolver(problem) if is_rough else PairSolver(problem)
    before, drive, found = np.zeros(problem.body.displacements), problem.start(), iter(found)
    solver.surface.lend(before, np.zeros(solver.surface.multipliers))
    for increments, end in problem.steps():
        start = drive
        for increment in range(1, increments + 1):
            drive = start.between(end, increment / increments)
            state = next(found, None)
            if state is None:
                return
            u, p = state[0], state[1][: problem.body.pressures]
            u[problem.held] = drive.values
            left, multipliers = rest(solver, drive, (u, p), before if is_rough else None)
            yield left
            before = u
            solver.surface.lend(u, multipliers)


def rest(solver, drive, state, before):
    """What a state leaves, and which multipliers press by how much."""
    u, p = state
    problem, surface, free = solver.problem, solver.surface, solver.free
    none = np.zeros(surface.multipliers)
    gaps, coupling, _ = surface.contact(u, problem.placed(drive), none)
    body = solver.body.respond(u, p)
    forces = (body.forces - drive.load * problem.load)[free]
    closed = np.flatnonzero(np.abs(gaps) < CLOSED * surface.areas * solver.length)
    columns = coupling.toarray()[closed][:, free].T
    if before is not None:
        slips, rows, _, _ = solver.slides(u, before, none)
        columns = np.concatenate([columns, -rows[closed][:, free].T], axis=1)
    sizes = np.maximum(np.linalg.norm(columns, axis=0), 1e-300)
    values, _, rank, _ = np.linalg.lstsq(columns / sizes, -forces, rcond=1e-14)
    values = values / sizes
    pressed = columns @ values
    multipliers = none.copy()
    multipliers[closed] = values[: len(closed)]
    # Where nothing touches, forces of a body that moves as a whole.
    least = (1e-4 * solver.softest if len(closed) else solver.shear) * np.abs(u).max(initial=0.0)
    largest = max(multipliers.max(initial=0.0), least, 1e-300)
    left = {
        "force": np.abs(forces + pressed).max() / max(np.abs(pressed).max(initial=0.0), least, 1e-300),
        "volume": np.abs(body.defects).max(initial=0.0) / solver.body.measure.max(),
        "gap": -(gaps / np.maximum(surface.areas, 1e-300)).min(initial=0.0) / solver.length,
        "sign": -multipliers.min(initial=0.0) / largest,
        UNDECIDED: columns.shape[1] - rank,
    }
    pressing = np.where(multipliers > PRESSING * largest, multipliers, 0.0)
    if before is None:
        return left, pressing
    tractions = none.copy()
    tractions[closed] = values[len(closed) :]
    ways = slips / np.maximum(surface.areas, 1e-300) / solver.length
    # A steep bound multiplies what least squares leave of pressures that are next to none.
    noise = PRESSING * largest
    over = np.abs(tractions) - solver.limits(multipliers + noise)
    spare = np.maximum(solver.limits(multipliers - noise) - np.abs(tractions), 0.0)
    left |= {
        "bound": over.max(initial=0.0) / largest,
        "stuck": np.minimum(spare / largest, np.abs(ways)).max(initial=0.0),
        "against": np.minimum(ways * np.sign(tractions), np.abs(tractions) / largest).max(initial=0.0),
    }
    if max(value for what, value in left.items() if what != UNDECIDED) <= SMALL or (solver.bound > 0.0).any():
        return left, pressing
    # Where least squares are not unique: some within the laws.
    found = within_laws(columns, forces, solver.coefficient[closed], ways[closed])
    left = {name: left[name] for name in ("volume", "gap", UNDECIDED)}
    return left | {"force": found / max(np.abs(forces).max(), least)}, pressing


def within_laws(columns, forces, coefficient, ways):
    """What is left by some a, b >= 0, Lam = a + b, q = mu (b - a), a alone where S > 0, b alone where S < 0."""
    pressed, dragged = np.split(columns, 2, axis=1)
    a = (pressed - coefficient * dragged)[:, ways > -CLOSED]
    b = (pressed + coefficient * dragged)[:, ways < CLOSED]
    both = np.concatenate([a, b], axis=1)
    sizes = np.maximum(np.linalg.norm(both, axis=0), 1e-300)
    scale = max(np.abs(forces).max(initial=0.0), 1e-300)
    values, _ = nnls(both / sizes, -forces / scale, maxiter=10000)
    return scale * np.abs(both / sizes @ values + forces / scale).max()
