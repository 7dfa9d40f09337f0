#!/usr/bin/env python3
"""Figures of the quadratic contact space. usage: contact_space_digits.py boxes|infsup|metric|block|strip

boxes   roller box in space: force, energy and lowest eigenvalue under a lid
infsup  inf-sup values of multipliers alone and with pressures, against a mesh refined four (plane) or two (space) times
metric  condition of the compliance against the metric C Y C' with its volume mode, five faces clamped
block   mr-block on coarse meshes to 40 %
strip   bonded strip 32 : 1, incompressible, to 10 %
"""
import argparse
import math
import os
import tempfile
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("MKL_NUM_THREADS", "1")

import numpy as np
import scipy.linalg
import scipy.sparse as sp
from scipy.sparse.linalg import splu

import saddle_contact
import saddle_stability
from family_mesh import AXES, Box
from family_scenes import value_of
from saddle_body import spread
from saddle_newton import NotConverged, Solver
from saddle_rule import bernstein
from saddle_scene import Problem

RUBBER = 'model = "neo-hookean"\nshear_modulus = 1.0\n'


def problem(sizes, counts, law, supports, lid=None, increments=1, space="quadratic", degree=2):
    """A box with supports {side: axes} under a lid that comes down by `lid`."""
    up = len(sizes) - 1
    text = f'mesh = "box.msh"\n[material.body]\n{law}\n[solver]\nquadrature_degree = {degree}\n'
    for side, axes in supports.items():
        held = ", ".join(f"{axis} = 0.0" for axis in axes)
        text += f'[[support]]\nname = "{side}"\non = "{side}"\ndisplacement = {{ {held} }}\n'
    point, normal, travel = [0.0] * 3, [0.0] * 3, [0.0] * 3
    point[up], normal[up], travel[up] = float(sizes[-1]), -1.0, -(lid or 0.0)
    shape = f'{{ kind = "half-space", point = {value_of(point)}, normal = {value_of(normal)} }}'
    text += f'[[obstacle]]\nname = "lid"\non = "{AXES[up]}1"\nshape = {shape}\n'
    text += f"[[step]]\nincrements = {increments}\nobstacle.lid = {{ translation = {value_of(travel)} }}\n"
    with tempfile.TemporaryDirectory() as folder:
        Box(sizes, counts, 0.0, False, np.random.default_rng(0)).write(Path(folder) / "box.msh")
        (Path(folder) / "box.toml").write_text(text)
        return Problem(Path(folder) / "box.toml", space)


def rollers(dim):
    return {f"{AXES[a]}{end}": AXES[a] for a in range(dim) for end in (0, 1) if (a, end) != (dim - 1, 1)}


def clamped(dim):
    return {side: AXES[:dim] for side in rollers(dim)}


def final(body):
    """Solver, state and drive at the end of a problem's steps, by increments; None where one fails."""
    solver = Solver(body)
    state, drive = solver.rest(), body.start()
    for increments, end in body.steps():
        start = drive
        for increment in range(1, increments + 1):
            target = start.between(end, increment / increments)
            try:
                state = solver.follow(state, drive, target, 1)
            except NotConverged:
                return
            drive = target
            yield solver, state, drive


def describe(solver, state, drive):
    """Force of the lid along the last axis, energy, active multipliers, lowest eigenvalues."""
    found = saddle_contact.record(solver, state, drive, {})
    force = -found["obstacles"]["lid"][solver.body.dim - 1]
    plain = saddle_stability.lowest(solver, state, drive, relative=False)
    relative = saddle_stability.lowest(solver, state, drive)
    return (
        f"{force:.12g} | {found['strain_energy']:.12g} | {found['active']} / {found['multipliers']} | {plain:.6g} | "
        f"{relative:.6g} | {found['largest_pressure']:.6g}"
    )


HEAD = "force | energy | active | lowest, plain | lowest over int 2 mu eps:eps | largest p |"


def boxes():
    print(f"| space | n | K / mu | squeeze | {HEAD}\n|---|---|---|---|---|---|---|---|---|---|")
    for space in ("quadratic", "linear"):
        for n in (2, 4):
            for bulk in (1e2, 1e3, 1e6):
                for squeeze in (0.05, 0.2):
                    law = RUBBER + f"bulk_modulus = {bulk!r}"
                    body = problem([1.0] * 3, [n] * 3, law, rollers(3), squeeze, 1, space)
                    words = "none"
                    for each in final(body):
                        words = describe(*each)
                    print(f"| {space} | {n} | {bulk:g} | {squeeze} | {words} |", flush=True)
    for bulk in (1e2, 1e3, 1e6):
        for squeeze in (0.05, 0.2):
            force, energy = homogeneous(bulk, squeeze)
            print(f"exact K {bulk:g} squeeze {squeeze}: force {force:.12g} energy {energy:.12g}")


def homogeneous(bulk, squeeze):
    """Neo-Hookean uniaxial strain with stretch s: W = (s^(-2/3) (2 + s^2) - 3) / 2 + K (1 - s)^2 / 2."""
    s = 1.0 - squeeze
    energy = 0.5 * (s ** (-2.0 / 3.0) * (2.0 + s**2) - 3.0) + 0.5 * bulk * squeeze**2
    slope = 0.5 * (-2.0 / 3.0 * s ** (-5.0 / 3.0) * (2.0 + s**2) + 2.0 * s ** (1.0 / 3.0))
    return bulk * squeeze - slope, energy


def block():
    print(f"| n | degree | travel | {HEAD}\n|---|---|---|---|---|---|---|---|---|")
    law = 'model = "mooney-rivlin"\nc10 = 0.4\nc01 = 0.1'
    for n in (3, 4):
        for degree in (2, 8):
            body = problem([1.0] * 3, [n] * 3, law, {"z0": "xyz"}, 0.4, 16, "quadratic", degree)
            for number, each in enumerate(final(body), 1):
                print(f"| {n} | {degree} | {0.025 * number:.3f} | {describe(*each)} |", flush=True)


def strip():
    print(f"| degree | squeeze | {HEAD}\n|---|---|---|---|---|---|---|---|")
    for degree in (2, 8):
        body = problem([32.0, 1.0], [48, 3], RUBBER, {"y0": "xy"}, 0.1, 20, "quadratic", degree)
        for number, each in enumerate(final(body), 1):
            print(f"| {degree} | {0.005 * number:.3f} | {describe(*each)} |", flush=True)


class Matrices:
    """Dense A (int 2 mu eps : eps or int grad : grad), B, C and the mass M of a linear body at rest."""

    def __init__(self, body, gradients=False):
        self.solver = Solver(body)
        free, rest = self.solver.free, self.solver.rest()
        response = body.body.respond(rest.u, rest.p)
        _, coupling, _ = body.surface.contact(rest.u, body.placed(body.start()), rest.multipliers)
        self.a = response.stiffness if not gradients else laplacian(body.body)
        self.a = self.a[free][:, free]
        self.b, self.c = response.divergence[:, free], coupling[:, free]
        self.mass = response.compressibility


def laplacian(body):
    """int grad u : grad v."""
    gradients = np.einsum("qak,ekd->eqad", body.table, body.slopes)
    scalar = np.einsum("e,q,eqad,eqbd->eab", body.measure, body.weights, gradients, gradients, optimize=True)
    nodes = body.mesh.cell_nodes
    rows, columns, values = spread(nodes, nodes, scalar)
    size = len(body.mesh.nodes)
    return sp.kron(sp.coo_matrix((values, (rows, columns)), shape=(size, size)), sp.identity(body.dim)).tocsr()


def linear_law(lame):
    ratio = 0.5 if math.isinf(lame) else lame / (2.0 * (lame + 1.0))
    return f'model = "linear-elastic"\nshear_modulus = 1.0\npoisson_ratio = {ratio!r}'


def compliance(a, rows):
    """rows A^-1 rows' [dense]."""
    return rows @ splu(a.tocsc()).solve(rows.T.toarray())


def infsup():
    for gradients in (False, True):
        for dim, cases, refine in ((2, (4, 8), 4), (3, (2, 3), 2)):
            for n in cases:
                for name, supports in (("rollers", rollers(dim)), ("clamped", clamped(dim))):
                    for space in ("linear", "quadratic"):
                        print(infsup_case(dim, n, refine, (name, supports), space, gradients), flush=True)


def infsup_case(dim, n, refine, supports, space, gradients):
    """The least ratios of the norms on the own mesh and on the finer one."""
    name, supports = supports
    law = linear_law(1e3)
    coarse = problem([1.0] * dim, [n] * dim, law, supports, 0.0, 1, space)
    fine = problem([1.0] * dim, [n * refine] * dim, law, supports, 0.0, 1, space)
    own, finer = Matrices(coarse, gradients), Matrices(fine, gradients)
    inject = injection(coarse, fine)
    fine_rows = injected_rows(coarse, fine)[:, finer.solver.free]
    true = compliance(finer.a, fine_rows)
    values = scipy.linalg.eigh(compliance(own.a, own.c), true, eigvals_only=True)
    both = sp.vstack([own.b, own.c]).tocsr()
    # Pressures in L2 and multipliers in the dual norm; and both in the dual norm of the finer mesh.
    unit_mass = own.mass.toarray() * 1e3
    separate = scipy.linalg.block_diag(unit_mass, true)
    values_joint = scipy.linalg.eigh(compliance(own.a, both), separate, eigvals_only=True)
    both_fine = sp.vstack([(inject.T @ finer.b).tocsr(), sp.csr_matrix(fine_rows)]).tocsr()
    joint_true = compliance(finer.a, both_fine)
    return (
        f"| {'grad' if gradients else 'eps'} | {dim}D n = {n} | {name} | {space} | {math.sqrt(max(values[0], 0)):.4f} | "
        f"{roots(values_joint)} | {quotient(compliance(own.a, both), joint_true)} |"
    )


def roots(values):
    return " ".join(f"{math.sqrt(max(v, 0.0)):.4f}" for v in values[:3])


def quotient(small, large):
    """Least ratios where the larger form does not vanish."""
    w, v = scipy.linalg.eigh(large)
    keep = w > 1e-10 * w[-1]
    v = v[:, keep] / np.sqrt(w[keep])
    return roots(scipy.linalg.eigvalsh(v.T @ small @ v)) + f" (kernel {int((~keep).sum())})"


def injection(coarse, fine):
    """P1 values on the finer mesh of P1 functions of the coarse one [fine vertices, coarse vertices]."""
    return barycentric(coarse.mesh, fine.mesh.points)


def barycentric(mesh, points):
    rows, columns, values = [], [], []
    corners = mesh.points[mesh.cells]
    inverse = np.linalg.inv(np.swapaxes(corners[:, 1:] - corners[:, :1], 1, 2))
    for number, point in enumerate(points):
        local = np.einsum("eij,ej->ei", inverse, point - corners[:, 0])
        local = np.concatenate([1.0 - local.sum(axis=1, keepdims=True), local], axis=1)
        cell = np.argmax(local.min(axis=1))
        rows += [number] * len(local[cell])
        columns += mesh.cells[cell].tolist()
        values += np.where(np.abs(local[cell]) < 1e-12, 0.0, local[cell]).tolist()
    return sp.coo_matrix((values, (rows, columns)), shape=(len(points), len(mesh.points))).tocsr()


def injected_rows(coarse, fine):
    """-int psi_j v_n with psi_j of the coarse surface and v of the finer body [coarse multipliers, fine unknowns]."""
    surface, faces = fine.surface, fine.surface.faces[0]
    x = np.einsum("qa,fai->fqi", surface.shapes, fine.mesh.nodes[faces.nodes])
    psi = coarse_functions(coarse, x.reshape(-1, fine.mesh.dim)).reshape(*x.shape[:2], -1)
    weights = np.outer(faces.measure, surface.weights)
    # The lid's normal is -e_last, C = -dG/du.
    values = np.einsum("fq,fqj,qa->jfa", weights, psi, surface.shapes, optimize=True)
    rows = np.zeros((values.shape[0], fine.body.displacements))
    dofs = fine.mesh.dim * faces.nodes + fine.mesh.dim - 1
    for j in range(len(rows)):
        np.add.at(rows[j], dofs.ravel(), values[j].ravel())
    return sp.csr_matrix(rows)


def coarse_functions(coarse, x):
    """psi_j at points of the lid [points, multipliers]."""
    surface, faces, dim = coarse.surface, coarse.surface.faces[0], coarse.mesh.dim
    corners = coarse.mesh.points[faces.nodes[:, :dim]][:, :, : dim - 1]
    inverse = np.linalg.inv(np.swapaxes(corners[:, 1:] - corners[:, :1], 1, 2))
    raw = np.zeros((len(x), len(surface.raw)))
    for number, point in enumerate(x[:, : dim - 1]):
        local = np.einsum("eij,ej->ei", inverse, point - corners[:, 0])
        local = np.concatenate([1.0 - local.sum(axis=1, keepdims=True), local], axis=1)
        face = np.argmax(local.min(axis=1))
        at = local[face : face + 1]
        raw[number, faces.functions[face]] = (at if surface.space == "linear" else bernstein(at))[0]
    return raw @ surface.merge.T.toarray()


def metric():
    print("| body | lambda / mu | without | with the volume mode |\n|---|---|---|---|")
    for dim, n in ((2, 16), (2, 8), (3, 4), (3, 6)):
        for name, supports in (("five clamped", clamped(dim)), ("rollers", rollers(dim))):
            for lame in (1.5, 100.0, 1e5):
                body = problem([1.0] * dim, [n] * dim, linear_law(lame), supports, 0.0)
                words = " | ".join(metric_case(body, lame))
                print(f"| {name}, {dim}D n = {n} | {lame:g} | {words} |", flush=True)


def metric_case(body, lame):
    """Conditions of the exact compliance against the metric without and with its volume mode."""
    body.body.mixed, body.body.pressures = True, len(body.mesh.points)
    for law in body.laws.values():
        law.inverse_bulk, law.lame = 1.0 / lame, 0.0
    m = Matrices(body)
    y = inverse(m, body)
    c, b = m.c.toarray(), np.asarray(m.b.sum(axis=0)).ravel()
    plain = c @ y @ c.T
    volume = body.body.measure.sum()
    w = c @ (y @ b)
    full = plain - np.outer(w, w) / (volume / lame + b @ y @ b)
    saddle = sp.bmat([[m.a, m.b.T], [m.b, -m.mass]], format="csc")
    padded = sp.hstack([m.c, sp.csr_matrix((c.shape[0], m.b.shape[0]))]).tocsr()
    exact = compliance(saddle, padded)
    exact = 0.5 * (exact + exact.T)
    for each in (plain, full):
        values = scipy.linalg.eigh(exact, each, eigvals_only=True)
        yield f"{values[-1] / values[0]:.4g}"


def inverse(m, body):
    """Y = P A11^-1 P' + D^-1 on free unknowns [dense]: P1 part and node blocks."""
    dim, mesh = body.mesh.dim, body.mesh
    free = m.solver.free
    vertices = len(mesh.points)
    p = sp.lil_matrix((len(mesh.nodes), vertices))
    p[:vertices] = sp.identity(vertices)
    for edge, (a, b) in enumerate(mesh.edge_ends):
        p[vertices + edge, a] = p[vertices + edge, b] = 0.5
    p = sp.kron(p, sp.identity(dim)).tocsr()[free][:, free[: dim * vertices]]
    a11 = (p.T @ m.a @ p).toarray()
    dense = m.a.toarray()
    nodes = np.repeat(np.arange(len(mesh.nodes)), dim)[free]
    block = np.where(nodes[:, None] == nodes[None, :], dense, 0.0)
    return p @ np.linalg.inv(a11) @ p.T.toarray() + np.linalg.inv(block)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=("boxes", "infsup", "metric", "block", "strip"))
    {"boxes": boxes, "infsup": infsup, "metric": metric, "block": block, "strip": strip}[parser.parse_args().what]()


if __name__ == "__main__":
    main()
