"""Equilibria of bodies in contact with friction by a semismooth Newton method on the whole system:

    dE/du - load + C' Lam - R' q = 0,   |q_j| <= mu Lam_j, or min(b, k Lam_j) of a bound b with k = 1e9,
    S_j = 0 where less, else q_j = -mu Lam_j sign S_j, or that of the bound

Slips S and their start as in `pair_slip`: of a whole increment, implicit. What an increment is solved in parts for is
a first guess only. Linear bodies have R where they first touch and S = R (u - u0). A multiplier is open, sticks, or
slips one way; where no such states are an equilibrium, one of a bound may rest between open and pressed, slipping with
next to no Lam = |q| / k.
"""
from dataclasses import dataclass, replace

import numpy as np
import scipy.sparse as sp

from pair_newton import WEIGHTS, Rounding
from pair_slip import Slip
from pair_surface import dofs
from saddle_linear import general
from saddle_newton import SIGN, TOLERANCE, NotConverged
from saddle_surface import matrix

MOST_ITERATIONS = 30
OPEN, STICK, SLIP, BETWEEN = 0, 1, 2, 3
# k, without unit.
STEEP = 1e9


@dataclass
class State:
    """Displacements, pressures, multipliers, tractions and what each of them does: OPEN, STICK, SLIP or BETWEEN,
    or less these by the sign of S."""

    u: np.ndarray
    p: np.ndarray
    multipliers: np.ndarray
    tractions: np.ndarray
    status: np.ndarray


class Slides:
    """Slips of a contact since places `before` of the nodes."""

    def __init__(self, pair, u, before, tractions):
        self.pair = pair
        at_rest = pair.rest is not None
        places = pair.places(pair.touch if at_rest else u)
        meetings, nodes, volume = pair.volume(places)
        pieces = meetings.pieces
        self.faces, self.nodes = pieces.face, nodes
        self.far, _ = pair.uncovered(places, meetings)
        self.turning = []
        if at_rest:
            self.rows = self.slope = self.gathered(volume.dragged().transpose(2, 0, 1))
            self.slips = self.rows @ (u - before)
            return
        slip = Slip(pieces, places[nodes], pair.revolved, pair.points)
        self.rows = self.gathered(slip.rows())
        start = pair.places(before)[nodes]
        self.slips = pair.merge @ pair.gathered(slip.slips(start), pieces.face)
        self.slope = self.gathered(slip.slips_slopes(start))
        factors = (tractions @ pair.merge)[pair.functions[pieces.face]]
        loaded = np.abs(factors).max(axis=1, initial=0.0) > 0.0
        if loaded.any():
            own, nodes = pieces.some(loaded), nodes[loaded]
            slip = Slip(own, places[nodes], pair.revolved, pair.points)
            self.turning = [(dofs(nodes), dofs(nodes), slip.turning(factors[loaded]))]

    def gathered(self, slopes):
        """Rows of the multipliers from [20, m, 3]."""
        pair = self.pair
        entries = (pair.functions[self.faces], dofs(self.nodes), slopes.transpose(1, 2, 0))
        rows = pair.merge @ matrix([entries], (pair.merge.shape[1], pair.unknowns)).toarray()
        rows[self.far] = 0.0
        return rows


class RoughSolver(Rounding):
    """Newton's method for one problem with friction."""

    def __init__(self, problem):
        super().__init__(problem)
        count = [pair.multipliers for pair in self.surface.pairs]
        self.coefficient = np.repeat([table.get("friction", 0.0) for table in problem.contacts], count)
        self.bound = np.repeat([table.get("tresca", 0.0) for table in problem.contacts], count)
        # Whether Newton's method looks for states between open and pressed.
        self.rests_between = False

    def rest(self):
        plain = super().rest()
        count = self.surface.multipliers
        return State(plain.u, plain.p, plain.multipliers, np.zeros(count), np.zeros(count, int))

    def begun(self, state):
        """The state at the start of the next increment."""
        pressures, before = self.surface.lend(state.u, state.multipliers)
        is_pressed = pressures > 0.0
        tractions = self.surface.carried(before, state.tractions) * is_pressed
        status = np.where(is_pressed, np.where(state.status == OPEN, STICK, state.status), OPEN)
        return State(state.u, state.p, pressures, tractions, status)

    def slides(self, u, before, tractions):
        """Slips, R, dS and the derivative of R' q, of all contacts."""
        own = [Slides(pair, u, before, q) for pair, q in zip(self.surface.pairs, self.surface.own(tractions))]
        turning = matrix([entry for one in own for entry in one.turning], (len(u), len(u)))
        rows, slope = (np.concatenate([getattr(one, name) for one in own]) for name in ("rows", "slope"))
        return np.concatenate([one.slips for one in own]), rows, slope, turning

    def increment(self, state, start, end, least_parts):
        """The state at the end of an increment."""
        self.before = state.u.copy()
        return self.follow(state, start, end, least_parts)

    def limits(self, multipliers):
        """Largest tractions."""
        return np.where(self.bound > 0.0, np.minimum(self.bound, STEEP * multipliers), self.coefficient * multipliers)

    def equilibrium(self, state, drive):
        """With one weight of gaps and slips beside pressures after the other, then with states between."""
        has_bound = (self.bound > 0.0).any()
        ways = [(weight, between) for between in (False, True)[: 1 + has_bound] for weight in WEIGHTS]
        for weight, self.rests_between in ways[:-1]:
            try:
                return self.by_weight(state, drive, weight)
            except (NotConverged, np.linalg.LinAlgError):
                continue
        weight, self.rests_between = ways[-1]
        return self.by_weight(state, drive, weight)

    def by_weight(self, state, drive, weight):
        """Newton's method at one drive."""
        state, error = replace(state), np.inf
        response = self.respond(state)
        closing = (response[1][0] < 0.0) | (state.multipliers > 0.0)
        state.status = np.where(closing & (state.status == OPEN), STICK, state.status)
        best = np.inf
        for _ in range(MOST_ITERATIONS):
            self.iterations += 1
            state = self.moved(state, self.solved(state, drive, response), response[0])
            response = self.respond(state)
            chosen = self.choose_status(state, response, weight)
            is_same = (chosen == state.status).all()
            error = self.misfit(state, drive, response)
            if is_same and (error <= TOLERANCE or (error <= self.rounded and error > 0.5 * best)):
                return state
            best = min(best, error) if is_same else np.inf
            state.status = chosen
            closed = chosen != OPEN
            state.multipliers, state.tractions = closed * state.multipliers, closed * state.tractions
        raise NotConverged(f"{error:.1e} after {MOST_ITERATIONS} iterations")

    def respond(self, state):
        return (
            self.body.respond(state.u, state.p),
            self.surface.contact(state.u, None, state.multipliers),
            self.slides(state.u, self.before, state.tractions),
        )

    def solved(self, state, drive, response):
        """Changes of displacement and pressure, new multipliers and tractions."""
        body, (gaps, coupling, curvature), (slips, rows, slope, turning) = response
        held, status = self.problem.held, state.status
        closed, sticks = status != OPEN, status == STICK
        known = np.zeros(self.body.displacements)
        known[held] = drive.values - state.u[held]
        stiffness = body.stiffness + curvature - turning
        free = self.free
        k, b = stiffness[free][:, free], body.divergence[:, free]
        c, r = coupling[closed][:, free], sp.csr_matrix(rows[closed][:, free])
        is_between = np.abs(status) == BETWEEN
        way = np.sign(status) * (np.abs(status) >= SLIP)
        coulomb = np.where(is_between, 1.0, np.where(self.bound > 0.0, 0.0, self.coefficient)) * way
        is_stuck = sp.diags(sticks[closed].astype(float))
        law = [
            is_stuck @ sp.csr_matrix(slope[closed][:, free]), None, sp.diags(np.where(sticks, 0.0, coulomb)[closed]),
            sp.diags(np.where(sticks, 0.0, np.where(is_between, 1.0 / STEEP, 1.0))[closed]),
        ]
        system = sp.bmat([[k, b.T, c.T, -r.T], [b, -body.compressibility, None, None], [c, None, None, None], law])
        right = np.concatenate([
            -(body.forces - drive.load * self.problem.load + stiffness @ known)[free],
            -body.defects - body.divergence @ known,
            (gaps - coupling @ known)[closed],
            np.where(sticks, -slips - slope @ known, -way * self.bound * ~is_between)[closed],
        ])
        found = general(system, right)
        if not np.isfinite(found).all():
            raise NotConverged("singular system")
        ends = np.cumsum([free.sum(), self.body.pressures, closed.sum()])
        known[free], pressures, pressed, dragged = np.split(found, ends)
        multipliers, tractions = np.zeros(len(gaps)), np.zeros(len(gaps))
        multipliers[closed], tractions[closed] = pressed, dragged
        return known, pressures, multipliers, tractions

    def moved(self, state, step, body):
        """Along the longest part of a step that keeps J above zero."""
        plain, _ = self.move(Plain(state), step, body)
        part = self.part_taken(state, plain, step)
        tractions = state.tractions + part * (step[3] - state.tractions)
        return State(plain.u, plain.p, plain.multipliers, tractions, state.status)

    @staticmethod
    def part_taken(state, plain, step):
        largest = np.abs(step[0]).argmax()
        return (plain.u[largest] - state.u[largest]) / step[0][largest] if step[0][largest] else 1.0

    def choose_status(self, state, response, weight):
        """What each multiplier does next: projections of Lam - r G and q - r S per area, r = weight mu / h."""
        areas = np.maximum(self.surface.areas, 1e-300)
        factor = weight * self.softest / areas**2
        largest = max(np.abs(state.multipliers).max(initial=0.0), 1e-300)
        closed = state.status != OPEN
        pressing = state.multipliers - factor * response[1][0]
        trial = state.tractions - factor * response[2][0]
        limits = self.limits(np.maximum(pressing, 0.0))
        sign = SIGN * largest
        chosen = np.where(np.abs(trial) > limits + sign, -SLIP * np.sign(trial), STICK)
        # Up to rounding what slips goes on.
        goes_on = (np.abs(state.status) == SLIP) & (np.abs(trial) > limits - sign) & (trial * state.status < 0.0)
        chosen = np.where(goes_on, state.status, chosen)
        chosen = np.where(pressing > np.where(closed, -sign, sign), chosen, OPEN)
        return self.between(state, chosen).astype(int) if self.rests_between else chosen.astype(int)

    def between(self, state, chosen):
        """What slips by a bound and would open rests between, until its traction is the bound or turns."""
        against = -state.tractions * np.sign(state.status)
        opens = (np.abs(state.status) == SLIP) & (chosen == OPEN) & (self.bound > 0.0)
        rests = np.abs(state.status) == BETWEEN
        chosen = np.where(rests, np.where(against > 0.0, state.status, OPEN), chosen)
        chosen = np.where(rests & (against > self.bound), SLIP * np.sign(state.status), chosen)
        return np.where(opens, BETWEEN * np.sign(state.status), chosen)

    def friction(self, state):
        """Of each contact: force on the carrier and on the other body, and what slips have dissipated."""
        slips, rows, _, _ = self.slides(state.u, self.before, state.tractions)
        own = zip(self.surface.pairs, *map(self.surface.own, (slips, rows, state.tractions)))
        return [(*pair.parted(q @ r, state.u), float(-q @ s)) for pair, s, r, q in own]

    def misfit(self, state, drive, response):
        """The largest residual over the scale of its forces, volumes or gaps."""
        body, (gaps, coupling, _), (slips, rows, _, _) = response
        dragged = rows.T @ state.tractions
        own = replace(body, forces=body.forces - dragged)
        error = self.error(Plain(state), drive, (own, gaps, coupling))
        stuck = np.abs(slips[state.status == STICK]).max(initial=0.0)
        return max(error, stuck / (self.surface.areas.max() * self.length))


class Plain:
    """A state as `saddle_newton` takes it."""

    def __init__(self, state):
        self.u, self.p, self.multipliers = state.u, state.p, state.multipliers
        self.active = state.status != OPEN
