"""Equilibria with contact by a semismooth Newton method (primal-dual active set) on the whole saddle point system

    K du + B' dp + C_A' Lam = -dE/du,   B du - S dp = -dE/dp,   C_A du = G_A,   Lam = 0 elsewhere

one factorisation an iteration, and by parts of an increment where an iteration fails.
"""
from dataclasses import dataclass, replace

import numpy as np
import scipy.sparse as sp

from saddle_linear import Factor

MOST_ITERATIONS = 30
TOLERANCE = 1e-11
# Residual at which an iteration that no longer improves ends.
ROUNDED = 1e-8
UNIT = 1e-13
# Least multiplier over the largest, and least mean penetration over the length, that have a sign.
SIGN = 1e-12
LEAST_PART = 1.0 / 128.0
# A step keeps this share of the least J.
KEPT_JACOBIAN = 0.2


@dataclass
class State:
    """Displacements, pressures, multipliers and the active set."""

    u: np.ndarray
    p: np.ndarray
    multipliers: np.ndarray
    active: np.ndarray


class NotConverged(Exception):
    """No equilibrium was found from that start."""


class Solver:
    """Newton's method for one problem."""

    def __init__(self, problem):
        self.problem, self.body, self.surface = problem, problem.body, problem.surface
        self.free = np.ones(self.body.displacements, dtype=bool)
        self.free[problem.held] = False
        span = np.ptp(problem.mesh.points, axis=0).max()
        self.shear = max(law.shear for law in problem.laws.values())
        self.length, self.iterations = span, 0
        # The forces of the stiffest body, rounded, over those of the softest.
        self.rounded = max(ROUNDED, UNIT * self.shear / min(law.shear for law in problem.laws.values()))

    def rest(self):
        count = self.surface.multipliers
        return State(
            np.zeros(self.body.displacements), np.zeros(self.body.pressures), np.zeros(count), np.zeros(count, bool)
        )

    def follow(self, state, start, end, least_parts, watch=None):
        """The state at drive `end` from that at `start`, in at least that many parts; `watch` sees each part."""
        done, part, drive = 0.0, 1.0 / least_parts, start
        while done < 1.0 - 1e-12:
            part = min(part, 1.0 - done)
            target = start.between(end, done + part)
            try:
                state = self.equilibrium(state, target)
            except (NotConverged, np.linalg.LinAlgError, FloatingPointError):
                part *= 0.5
                if part < LEAST_PART:
                    raise NotConverged(f"at {done:.4f} of the increment") from None
                continue
            drive, done = target, done + part
            if watch:
                watch(state, drive)
            part = min(2.0 * part, 1.0 / least_parts)
        return state

    def equilibrium(self, state, drive):
        """Newton's method at one drive."""
        obstacles = self.problem.placed(drive)
        state, seen, best = replace(state), set(), np.inf
        gaps, coupling, curvature = self.surface.contact(state.u, obstacles, state.multipliers)
        state.active = (state.multipliers > 0.0) | (gaps < 0.0)
        body = self.body.respond(state.u, state.p)
        for _ in range(MOST_ITERATIONS):
            self.iterations += 1
            step = self.step(state, drive, (body, gaps, coupling, curvature))
            state, body = self.move(state, step, body)
            gaps, coupling, curvature = self.surface.contact(state.u, obstacles, state.multipliers)
            chosen = self.choose(state, gaps, seen)
            error = self.error(state, drive, (body, gaps, coupling))
            is_same = (chosen == state.active).all()
            if is_same and (error <= TOLERANCE or (error <= self.rounded and error > 0.5 * best)):
                return state
            best = min(best, error) if is_same else np.inf
            state.active = chosen
            state.multipliers = np.where(chosen, state.multipliers, 0.0)
        raise NotConverged(f"{error:.1e} after {MOST_ITERATIONS} iterations")

    def choose(self, state, gaps, seen):
        """The next active set: what presses stays, what is entered joins; where sets return, only the worst index
        changes. Linearised gaps of active indices are zero, so that no weight between pressure and gap is needed."""
        pressing = state.multipliers / max(np.abs(state.multipliers).max(initial=0.0), 1e-300)
        entered = -gaps / np.maximum(self.surface.areas, 1e-300) / self.length
        # Up to rounding, what is at rest stays what it is.
        measure = np.where(state.active, pressing + SIGN, entered - SIGN)
        chosen = measure > 0.0
        if chosen.tobytes() in seen and (chosen != state.active).any():
            worst = np.argmax(np.where(chosen != state.active, np.abs(measure), -1.0))
            changed = state.active.copy()
            changed[worst] = chosen[worst]
            return changed
        seen.add(chosen.tobytes())
        return chosen

    def system(self, active, response):
        """The symmetric matrix on free displacements, pressures and active multipliers."""
        body, _, coupling, curvature = response
        k = (body.stiffness + curvature)[self.free][:, self.free]
        b, c = body.divergence[:, self.free], coupling[active][:, self.free]
        return sp.bmat(
            [[k, b.T, c.T], [b, -body.compressibility, None], [c, None, None]], format="csr"
        )

    def step(self, state, drive, response):
        """Changes of displacement and pressure, and the new multipliers."""
        body, gaps, coupling, curvature = response
        held = self.problem.held
        known = np.zeros(self.body.displacements)
        known[held] = drive.values - state.u[held]
        right = -(body.forces - drive.load * self.problem.load + (body.stiffness + curvature) @ known)
        of_pressure = -body.defects - body.divergence @ known
        of_contact = (gaps - coupling @ known)[state.active]
        factor = Factor(self.system(state.active, response))
        found = factor.solve(np.concatenate([right[self.free], of_pressure, of_contact]))
        factor.free()
        if not np.isfinite(found).all():
            raise NotConverged("singular system")
        count, pressures = int(self.free.sum()), self.body.pressures
        known[self.free] = found[:count]
        multipliers = np.zeros(len(gaps))
        multipliers[state.active] = found[count + pressures :]
        return known, found[count : count + pressures], multipliers

    def move(self, state, step, body):
        """The state after the longest part of the step that keeps J above zero, and the body there."""
        least, part = body.least_jacobian, 1.0
        while part > 1e-3:
            moved = State(
                state.u + part * step[0],
                state.p + part * step[1],
                state.multipliers + part * (step[2] - state.multipliers),
                state.active,
            )
            with np.errstate(all="ignore"):
                after = self.body.respond(moved.u, moved.p)
            if after.least_jacobian == np.inf or after.least_jacobian > KEPT_JACOBIAN * min(least, 1.0):
                return moved, after
            part *= 0.5
        raise NotConverged("cells turn inside out")

    def error(self, state, drive, response):
        """The largest residual over the scale of its forces or volumes."""
        body, gaps, coupling = response
        pressed = coupling.T @ state.multipliers
        rest = (body.forces - drive.load * self.problem.load + pressed)[self.free]
        floor = 1e-9 * self.shear * self.length ** (self.body.dim - 1)
        scale = max(np.abs(body.forces).max(), np.abs(pressed).max(initial=0.0), floor)
        volume = self.body.measure.max()
        gap = np.abs(gaps[state.active]).max(initial=0.0) / (self.surface.areas.max(initial=0.0) * self.length or 1.0)
        still = np.abs(state.u[self.problem.held] - drive.values).max(initial=0.0) / self.length
        return max(np.abs(rest).max(initial=0.0) / scale, np.abs(body.defects).max(initial=0.0) / volume, gap, still)
