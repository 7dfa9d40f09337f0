#!/usr/bin/env python3
"""Condensed problems of friction by an interior point method, against the solutions they were written with. usage:
    CONDENSED=DIR cargo test -p signorini --lib -- --ignored export_for_another_solver
    condensed_oracle.py DIR/*.txt                       needs: pip install numpy scipy clarabel

A file: points and coefficient; q and x, a pair a line; K row by row; pressures first, then two tractions a point. The
oracle iterates on the thresholds r = mu n: min 1/2 x.Kx + q.x with n >= 0 and |t| <= r, a second-order cone programme
each. It prints the largest difference over the largest multiplier.
"""
import sys

import clarabel
import numpy as np
from scipy import sparse


def read(path):
    with open(path) as lines:
        count, friction = lines.readline().split()
        size = 3 * int(count)
        pairs = np.array([lines.readline().split() for _ in range(size)], dtype=float)
        matrix = np.array([lines.readline().split() for _ in range(size)], dtype=float)
    return int(count), float(friction), matrix, pairs[:, 0], pairs[:, 1]


def tresca(matrix, linear, radii):
    """The convex problem of given thresholds."""
    count, size = len(radii), len(linear)
    rows, columns = list(range(count)), list(range(count))
    values = [-1.0] * count
    right = [0.0] * count
    cones = [clarabel.NonnegativeConeT(count)]
    for i in range(count):
        right += [radii[i], 0.0, 0.0]
        first = count + 3 * i
        rows += [first + 1, first + 2]
        columns += [count + 2 * i, count + 2 * i + 1]
        values += [-1.0, -1.0]
        cones.append(clarabel.SecondOrderConeT(3))
    constraints = sparse.csc_matrix((values, (rows, columns)), shape=(4 * count, size))
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = 1e-13
    # Numbers of order one, which absolute tolerances are meant for.
    stiff, far = np.abs(matrix).max(), np.abs(linear).max()
    upper = sparse.csc_matrix(np.triu(matrix / stiff))
    right = np.array(right) * stiff / far
    solver = clarabel.DefaultSolver(upper, linear / far, constraints, right, cones, settings)
    return np.array(solver.solve().x) * far / stiff


def main():
    for path in sys.argv[1:]:
        count, friction, matrix, linear, ours = read(path)
        radii = np.zeros(count)
        for passes in range(1, 60):
            x = tresca(matrix, linear, radii)
            new = friction * np.maximum(x[:count], 0.0)
            change = np.abs(new - radii).max()
            radii = new
            if change < 1e-10 * new.max():
                break
        error = np.abs(x - ours).max() / np.abs(ours).max()
        print(f"{path}: {count} points, {passes} passes, difference {error:.1e}")


if __name__ == "__main__":
    main()
