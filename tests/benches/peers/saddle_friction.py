#!/usr/bin/env python3
"""A body on one rough plane by an independent solver. usage: saddle_friction.py SCENE.toml

Linear contact space, no supports on the rough surface. Beside the equations of `saddle_newton`, tractions
t = sum t_i psi_i in the plane and weighted slips of an increment over the area da of `saddle_area` at its end,

    S_i = int psi_i P (x - x_0 - c) da,   virtual work int t . v da,   P: on the plane, c: how far it moved,
    t_i = proj(t_i - r S_i / m_i),   proj on the disc of radius mu Lam_i,   Lam_i = max(0, Lam_i - r G_i / m_i),

by Newton's method on all unknowns with the derivative of the projection, one unsymmetric factorisation an iteration.
One JSON line an increment: energy, force, moment about the plane's point, counts and margins (1 - |t| / mu Lam of what
sticks, |S_i| / int psi_i da of what slips); m_i: undeformed area.
"""
import argparse
import json

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as spl

from saddle_newton import KEPT_JACOBIAN, NotConverged
from saddle_scene import Problem
from saddle_surface import matrix

MOST_ITERATIONS = 60
TOLERANCE = 1e-12
# Shear moduli over the length of a facet: weights of slip beside traction, tried in turn.
WEIGHTS = (0.6, 2.0, 0.2, 6.0)


class Rough:
    """A problem with its rough plane; a state is (u, p, Lam [n], t [n, tangents])."""

    def __init__(self, path):
        self.problem = Problem(path)
        self.surface = self.problem.surface
        (self.obstacle,) = self.problem.obstacles
        if self.obstacle.kind != "half-space" or self.surface.space != "linear":
            raise ValueError("a plane and the linear contact space only")
        (self.faces,) = self.surface.faces
        (scene,) = self.problem.scene["obstacle"]
        self.friction, self.dim = scene["friction"], self.problem.mesh.dim
        self.count = self.surface.multipliers
        # Rows: tangents of the plane.
        normal = self.obstacle.direction[: self.dim]
        self.tangents = np.linalg.svd(normal[None])[2][1:]
        self.free = np.ones(self.problem.body.displacements, dtype=bool)
        self.free[self.problem.held] = False

    def rest(self):
        body = self.problem.body
        unknowns = (body.displacements, body.pressures, self.count, (self.count, self.dim - 1))
        return tuple(np.zeros(size) for size in unknowns)

    def places(self, u):
        return self.problem.mesh.nodes[self.faces.nodes] + u.reshape(-1, self.dim)[self.faces.nodes]

    def slips(self, u, before, tractions):
        """S [n, tangents], dS/du, the work of unit tractions, and sum t_i d(work)/du."""
        surface, faces, places = self.surface, self.faces, self.places(u)
        area = surface.measure.area(faces.measure, places)
        move = np.einsum("qa,fai,ti->fqt", surface.shapes, places - before, self.tangents)
        slips = np.zeros((self.count, self.dim - 1))
        of_faces = np.einsum("fq,qk,fqt->fkt", area.value, surface.psi, move)
        np.add.at(slips, faces.functions.ravel(), of_faces.reshape(-1, self.dim - 1))
        weighted = np.einsum("fq,qk,qa->fka", area.value, surface.psi, surface.shapes)
        work = np.einsum("fka,ti->fktai", weighted, self.tangents)
        slope, turn = work, np.zeros((len(faces.nodes), places.shape[1], self.dim, places.shape[1], self.dim))
        if area.slope is not None:
            slope = work + np.einsum("fqt,qk,fqbj->fktbj", move, surface.psi, area.slope, optimize=True)
            traction = np.einsum("fkt,qk,ti->fqi", tractions[faces.functions], surface.psi, self.tangents)
            turn = np.einsum("fqi,qa,fqbj->faibj", traction, surface.shapes, area.slope, optimize=True)
        return slips, self.rows(slope), self.rows(work), self.square(turn)

    def dofs(self):
        dofs = self.dim * self.faces.nodes[..., None] + np.arange(self.dim)
        return dofs.reshape(len(self.faces.nodes), -1)

    def rows(self, values):
        tangents, dofs = self.dim - 1, self.dofs()
        rows = tangents * self.faces.functions[..., None] + np.arange(tangents)
        rows = rows.reshape(len(dofs), -1)
        shape = (tangents * self.count, len(self.free))
        return matrix([(rows, dofs, values.reshape(*rows.shape, dofs.shape[1]))], shape)

    def square(self, values):
        dofs = self.dofs()
        return matrix([(dofs, dofs, values.reshape(*dofs.shape, dofs.shape[1]))], (len(self.free),) * 2)

    def increment(self, state, drive, before, weight):
        """The state and what it is at the end of an increment from places `before` of the nodes, the plane's move
        included."""
        obstacles, body = self.problem.placed(drive), self.problem.body
        u, p, pressed, tractions = (part.copy() for part in state)
        u[self.problem.held] = drive.values
        response = body.respond(u, p)
        for _ in range(MOST_ITERATIONS):
            contact = self.surface.contact(u, obstacles, pressed)
            slips = self.slips(u, before, tractions)
            law = Law(self, (pressed, tractions), (contact[0], slips[0]), weight)
            force = response.forces + contact[1].T @ pressed - slips[2].T @ tractions.ravel()
            residual = np.concatenate([force[self.free], response.defects, law.normal, law.tangential.ravel()])
            if np.abs(residual).max() <= TOLERANCE:
                return (u, p, pressed, tractions), law
            step = spl.splu(self.jacobian(response, contact, slips, law)).solve(-residual)
            ends = np.cumsum([self.free.sum(), body.pressures, self.count])
            of_u, of_p, of_pressed, of_tractions = np.split(step, ends)
            u, p, response = self.move((u, p), (of_u, of_p), response)
            pressed, tractions = pressed + of_pressed, tractions + of_tractions.reshape(tractions.shape)
        raise NotConverged(f"{np.abs(residual).max():.1e}")

    def jacobian(self, response, contact, slips, law):
        free = self.free
        k = (response.stiffness + contact[2] - slips[3])[free][:, free]
        b, c, work = response.divergence[:, free], contact[1][:, free], slips[2][:, free]
        closed = sp.diags(law.active.astype(float))
        return sp.bmat(
            [
                [k, b.T, c.T, -work.T],
                [b, -response.compressibility, None, None],
                [-closed @ c, None, sp.diags((~law.active).astype(float)), None],
                [law.by_slip @ slips[1][:, free], None, law.by_pressure, law.by_traction],
            ],
            format="csc",
        )

    def move(self, start, step, response):
        part = 1.0
        while part > 1e-3:
            u = start[0].copy()
            u[self.free] += part * step[0]
            p = start[1] + part * step[1]
            with np.errstate(all="ignore"):
                after = self.problem.body.respond(u, p)
            if after.least_jacobian > KEPT_JACOBIAN * min(response.least_jacobian, 1.0):
                return u, p, after
            part *= 0.5
        raise NotConverged("cells turn inside out")

    def solve(self):
        """A record an increment."""
        state, drive = self.rest(), self.problem.start()
        for step, (increments, end) in enumerate(self.problem.steps(), 1):
            start = drive
            for increment in range(1, increments + 1):
                target = start.between(end, increment / increments)
                moved = (target.poses[0][0] - drive.poses[0][0])[: self.dim]
                state, law = self.found(state, target, self.places(state[0]) + moved)
                drive = target
                yield {"step": step, "increment": increment} | self.record(state, drive, law)

    def found(self, state, drive, before):
        for weight in WEIGHTS:
            try:
                return self.increment(state, drive, before, weight)
            except NotConverged:
                continue
        raise NotConverged("no weight of the slip leads to an equilibrium")

    def record(self, state, drive, law):
        u, p, pressed, tractions = state
        (obstacle,) = self.problem.placed(drive)
        body, surface, faces = self.problem.body.respond(u, p), self.surface, self.faces
        area = surface.measure.area(faces.measure, self.places(u)).value
        values = pressed[:, None] * obstacle.direction[: self.dim] + tractions @ self.tangents
        on_body = np.zeros((*area.shape, 3))
        on_body[..., : self.dim] = area[..., None] * np.einsum("fki,qk->fqi", values[faces.functions], surface.psi)
        arm = np.zeros_like(on_body)
        arm[..., : self.dim] = np.einsum("qa,fai->fqi", surface.shapes, self.places(u))
        arm = arm - obstacle.point
        return {
            "strain_energy": float(body.energy - p @ body.defects),
            "force": on_body.sum(axis=(0, 1)).tolist(),
            "moment": np.cross(arm, on_body).sum(axis=(0, 1)).tolist(),
            "max_pressure": float(pressed.max()),
            "min_jacobian": float(body.least_jacobian),
        } | law.record(self.weighed(area))

    def weighed(self, area):
        """int psi_i da [n]."""
        of_faces = area @ self.surface.psi
        return np.bincount(self.faces.functions.ravel(), of_faces.ravel(), self.count)


class Law:
    """Residuals and derivatives of the laws of contact and friction, index by index."""

    def __init__(self, rough, multipliers, gaps, weight):
        (pressed, tractions), (gap, slip) = multipliers, gaps
        self.rough, self.pressed, self.tractions, self.slip = rough, pressed, tractions, slip
        self.areas = rough.surface.areas
        weights = weight / self.areas
        self.active = pressed - weights * gap > 0.0
        self.normal = np.where(self.active, gap, pressed)
        trial = tractions - weights[:, None] * slip
        length = np.linalg.norm(trial, axis=1)
        bound = rough.friction * np.maximum(pressed, 0.0)
        self.slides = self.active & (length > bound)
        self.sticks = self.active & ~self.slides
        along = trial / np.maximum(length, 1e-300)[:, None]
        on_disc = tractions - bound[:, None] * along
        self.tangential = np.where(self.slides[:, None], on_disc, np.where(self.sticks[:, None], slip, tractions))
        across = np.eye(slip.shape[1]) - along[:, :, None] * along[:, None, :]
        across = (bound / np.maximum(length, 1e-300))[:, None, None] * across
        one = np.broadcast_to(np.eye(slip.shape[1]), across.shape)
        slides, sticks = self.slides[:, None, None], self.sticks[:, None, None]
        by_slip = np.where(slides, across * weights[:, None, None], np.where(sticks, one, 0.0))
        by_traction = np.where(slides, one - across, np.where(sticks, 0.0, one))
        by_pressure = np.where(slides, -rough.friction * along[:, :, None], 0.0)
        self.by_slip, self.by_traction, self.by_pressure = map(sp.block_diag, (by_slip, by_traction, by_pressure))

    def record(self, areas):
        size = np.linalg.norm(self.slip, axis=1) / areas
        share = np.linalg.norm(self.tractions, axis=1) / np.maximum(self.rough.friction * self.pressed, 1e-300)
        return {
            "stick_vertices": int(self.sticks.sum()),
            "slip_vertices": int(self.slides.sum()),
            "open_vertices": int((~self.active).sum()),
            "max_slip": float(size[self.active].max(initial=0.0)),
            "dissipated_energy": float(-(self.tractions * self.slip).sum()),
            "pressure_margin": float(self.pressed[self.active].min(initial=np.inf) / max(self.pressed.max(), 1e-300)),
            "stick_margin": float((1.0 - share)[self.sticks].min(initial=1.0)),
            "slip_margin": float(size[self.slides].min(initial=np.inf)),
        }


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene")
    for line in Rough(parser.parse_args().scene).solve():
        print(json.dumps(line), flush=True)


if __name__ == "__main__":
    main()
