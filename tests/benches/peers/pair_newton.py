"""Newton's method of `saddle_newton` for bodies in contact: starts, rounding, and active sets by other weights.

Where surfaces touch at the start multipliers are closed, so that contact holds bodies that nothing else does; bodies of
rubber that begin inside each other are let in by less and less. Forces of a body that moves as a whole are rounded.
"""
import time
from dataclasses import replace

import numpy as np

from saddle_newton import LEAST_PART, SIGN, NotConverged, Solver

# Shear moduli of the softest body over the length of a face: what gaps and slips count for beside pressures.
WEIGHTS = (1.0, 0.1, 10.0)
# Forces of a displacement of one, over the shear modulus, that rounding leaves.
UNIT = 1e-14
# A multiplier that closes a contact without pressing; gaps over the length that are closed.
CLOSED, TOUCHING = 1e-200, 1e-9


class Rounding(Solver):
    """The same with the rounding of bodies that move as a whole, until `deadline`."""

    deadline = np.inf

    def __init__(self, problem):
        super().__init__(problem)
        self.base = self.rounded
        self.softest = min(law.shear for law in problem.laws.values())

    def error(self, state, drive, response):
        if time.process_time() > self.deadline:
            raise TimeoutError("no time left")
        scale = max(np.abs(response[0].forces).max(), 1e-9 * self.shear * self.length)
        self.rounded = max(self.base, UNIT * self.shear * np.abs(state.u).max(initial=0.0) / scale)
        return super().error(state, drive, response)


class PairSolver(Rounding):
    """Newton's method that, where its active sets do not settle, chooses them by pressures less weighted gaps."""

    weight = None

    def begun(self, state):
        """The state at the start of the next increment."""
        pressures, _ = self.surface.lend(state.u, state.multipliers)
        return replace(state, multipliers=pressures)

    def equilibrium(self, state, drive):
        for weight in (None, *WEIGHTS):
            self.weight = weight and weight * self.softest / np.maximum(self.surface.areas, 1e-300) ** 2
            try:
                return super().equilibrium(state, drive)
            except (NotConverged, np.linalg.LinAlgError) as fault:
                last = fault
        raise last

    def choose(self, state, gaps, seen):
        if self.weight is None:
            return super().choose(state, gaps, seen)
        largest = max(np.abs(state.multipliers).max(initial=0.0), 1e-300)
        return state.multipliers - self.weight * gaps > np.where(state.active, -SIGN, SIGN) * largest


def rest(solver):
    """The undeformed state, closed where surfaces touch; functions that meet next to nothing lend."""
    state, surface = solver.rest(), solver.surface
    surface.lend(state.u, state.multipliers)
    gaps, _, _ = surface.contact(state.u, None, state.multipliers)
    state.multipliers = np.where(gaps < TOUCHING * surface.areas * solver.length, CLOSED, 0.0)
    return state


def push_apart(solver, state, drive, parts):
    """Bodies that begin inside each other, let in by less and less."""
    surface = solver.surface
    gaps, _, _ = surface.contact(state.u, None, state.multipliers)
    depths, share = np.maximum(-gaps, 0.0), 1.0
    if not depths.any():
        return state
    part = 1.0 / parts
    while share > 0.0:
        surface.admitted = max(share - part, 0.0) * depths
        try:
            state = solver.equilibrium(state, drive)
        except (NotConverged, np.linalg.LinAlgError, FloatingPointError):
            part *= 0.5
            if part < LEAST_PART:
                raise NotConverged(f"inside by {share:.4f} of the start") from None
            continue
        share, part = max(share - part, 0.0), min(2.0 * part, 1.0 / parts)
    return state
