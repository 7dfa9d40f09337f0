#!/usr/bin/env python3
"""A sphere dragged to and fro on an incompressible half-space: load, dissipation of a cycle. usage:
    half_space_friction.py [CELLS [SHARE]]

Constant tractions on squares of side h inside the circle of contact, Cerruti's displacements with both tangential
components (nu = 1/2, so that pressure is Hertz's throughout), Coulomb's law by an accelerated projected gradient
method in the energy of the tractions. Unlike Mindlin's closed form it keeps the slip across the load. It prints r =
Q / (mu P), delta G a / (mu P), the energy lost in the cycle over that of the closed form at the same r, for grids of CELLS
squares across the circle, extrapolate in 1 / CELLS.
"""
import sys

import numpy as np

NU = 0.5
GAUSS, WEIGHTS = np.polynomial.legendre.leggauss(6)


def compliance(cells):
    """Points, squares' area over the circle of radius one, C of all tractions along x, then y; G = 1."""
    h = 2.0 / cells
    line = -1.0 + h * (np.arange(cells) + 0.5)
    x, y = (g.ravel() for g in np.meshgrid(line, line, indexing="ij"))
    inside = np.hypot(x, y) < 1.0
    x, y = x[inside], y[inside]
    dx, dy = x[:, None] - x[None, :], y[:, None] - y[None, :]
    parts = np.zeros((3, *dx.shape))
    for a, wa in zip(GAUSS, WEIGHTS):
        for b, wb in zip(GAUSS, WEIGHTS):
            u, v = dx - 0.5 * h * a, dy - 0.5 * h * b
            rho = np.hypot(u, v)
            weight = 0.25 * h * h * wa * wb
            parts[0] += weight * ((1 - NU) / rho + NU * u * u / rho**3)
            parts[1] += weight * ((1 - NU) / rho + NU * v * v / rho**3)
            parts[2] += weight * NU * u * v / rho**3
    # Of a square on itself: int 1 / rho = 4 h ln(1 + sqrt 2), half of it for each of u^2 / rho^3 and v^2 / rho^3.
    own = 4.0 * h * np.log(1.0 + np.sqrt(2.0))
    for k in (0, 1):
        np.fill_diagonal(parts[k], own * ((1 - NU) + 0.5 * NU))
    np.fill_diagonal(parts[2], 0.0)
    xx, yy, xy = parts / (2.0 * np.pi)
    return x, y, h * h, np.block([[xx, xy], [xy, yy]])


def solve(matrix, wanted, bound, start):
    """Tractions |q| <= bound with slip (C q - wanted) against them."""
    n = len(bound)
    step = 1.0 / np.linalg.norm(matrix, 2)
    q, z, t = start.copy(), start.copy(), 1.0
    for _ in range(20000):
        new = z - step * (matrix @ z - wanted)
        size = np.hypot(new[:n], new[n:])
        new *= np.tile(np.minimum(1.0, bound / np.maximum(size, 1e-300)), 2)
        t_new = 0.5 * (1.0 + np.sqrt(1.0 + 4.0 * t * t))
        if (new - q) @ (z - new) > 0.0:
            t_new = 1.0
        z = new + (t - 1.0) / t_new * (new - q) if t_new > 1.0 else new.copy()
        change = np.abs(new - q).max()
        q, t = new, t_new
        if change < 1e-12:
            break
    return q


def cycle(cells, share):
    """r, delta, and the energy lost in units of (mu P)^2 / (G a)."""
    x, y, area, matrix = compliance(cells)
    n = len(x)
    pressure = np.sqrt(np.maximum(1.0 - x * x - y * y, 0.0))
    bound = pressure / (pressure.sum() * area)
    delta = 9.0 / 32.0 * (1.0 - (1.0 - share) ** (2.0 / 3.0))
    along = np.concatenate([np.ones(n), np.zeros(n)])
    q, slip, lost = np.zeros(2 * n), np.zeros(2 * n), 0.0
    before = np.zeros(2 * n)
    loads = []
    for end in (delta, -delta, delta):
        # C (q - before) = travel - slip: what is wanted is where the last equilibrium was, moved by the travel.
        wanted = matrix @ before + (end - (loads and loads[-1][1] or 0.0)) * along
        q = solve(matrix, wanted, bound, q)
        slip = wanted - matrix @ q
        loads.append((q[:n].sum() * area, end))
        if len(loads) > 1:
            lost += (q @ slip) * area
        before = q
    return loads[0][0], loads[-1][0], delta, lost


def closed(r):
    return 27.0 / 20.0 * (1.0 - (1.0 - r) ** (5 / 3) - 5.0 * r / 6.0 * (1.0 + (1.0 - r) ** (2 / 3)))


def main():
    sizes = [int(sys.argv[1])] if len(sys.argv) > 1 else [16, 24, 32, 48]
    share = float(sys.argv[2]) if len(sys.argv) > 2 else 0.9
    for cells in sizes:
        first, last, delta, lost = cycle(cells, share)
        print(f"{cells} cells: r {first:.5f} {last:.5f}, delta {delta:.6f}, lost {lost:.6e}, over closed form {lost / closed(last):.4f}", flush=True)


if __name__ == "__main__":
    main()
