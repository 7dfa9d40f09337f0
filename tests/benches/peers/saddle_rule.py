"""Quadrature on simplices in barycentric coordinates, and the P1, P2 and Bernstein functions of degree 2 there.

Degree 2 takes the symmetric rules of three and four points, degrees 4 and 5 on triangles Radon's, every other degree
Gauss-Jacobi products (exact to the degree named, unlike some tabulated rules of tetrahedra). Weights have sum one.
"""
import numpy as np
from scipy.special import roots_jacobi

from saddle_mesh import EDGES


def rule(corners, degree):
    """Points [n, corners] and weights [n]."""
    if degree == 2 and corners > 2:
        near = {3: 2.0 / 3.0, 4: (5.0 + 3.0 * 5.0**0.5) / 20.0}[corners]
        points = np.full((corners, corners), (1.0 - near) / (corners - 1))
        np.fill_diagonal(points, near)
        return points, np.full(corners, 1.0 / corners)
    if degree in (4, 5) and corners == 3:
        return radon()
    return product(corners, degree // 2 + 1)


def radon():
    """Seven points on the triangle, exact to degree 5: two orbits of three and the middle."""
    root, points, weights = 15.0**0.5, [], []
    for sign in (1.0, -1.0):
        orbit = np.full((3, 3), (6.0 - sign * root) / 21.0)
        np.fill_diagonal(orbit, (9.0 + 2.0 * sign * root) / 21.0)
        points.append(orbit)
        weights += [(155.0 - sign * root) / 1200.0] * 3
    return np.concatenate([*points, np.full((1, 3), 1.0 / 3.0)]), np.array([*weights, 9.0 / 40.0])


def product(corners, count):
    """Collapsed product of Gauss-Jacobi rules of `count` points: exact to degree 2 count - 1."""
    points, weights = np.ones((1, 1)), np.ones(1)
    for power in range(corners - 1):
        x, w = roots_jacobi(count, power, 0)
        x, w = 0.5 * (1.0 + x), w / w.sum()
        inner = np.einsum("a,pk->apk", 1.0 - x, points).reshape(-1, points.shape[1])
        points = np.concatenate([inner, np.repeat(x, len(points))[:, None]], axis=1)
        weights = np.outer(w, weights).ravel()
    return points, weights


def p2(points):
    """P2 values [n, nodes], corners first."""
    pairs = EDGES[points.shape[1]]
    corners = points * (2.0 * points - 1.0)
    return np.concatenate([corners] + [4.0 * points[:, [a]] * points[:, [b]] for a, b in pairs], axis=1)


def p2_slopes(points):
    """Derivatives of P2 by the barycentric coordinates [n, nodes, corners]."""
    count, corners = points.shape
    pairs = EDGES[corners]
    slopes = np.zeros((count, corners + len(pairs), corners))
    for a in range(corners):
        slopes[:, a, a] = 4.0 * points[:, a] - 1.0
    for k, (a, b) in enumerate(pairs):
        slopes[:, corners + k, a] = 4.0 * points[:, b]
        slopes[:, corners + k, b] = 4.0 * points[:, a]
    return slopes


def bernstein(points):
    """L^2 at corners, 2 La Lb at midpoints [n, nodes]: positive, with sum one."""
    pairs = EDGES[points.shape[1]]
    return np.concatenate([points**2] + [2.0 * points[:, [a]] * points[:, [b]] for a, b in pairs], axis=1)


def of_facets(corners, degree):
    """Signorini's rule of facets, points by the order of the vertices in the file: round tools leave 1e-7 of a force
    to the choice of points, here as there."""
    if corners == 2:
        return product(corners, degree // 2 + 1)
    (a, first), (b, second) = legendre((degree + 1) // 2 + 1), legendre(degree // 2 + 1)
    a, b = (grid.ravel() for grid in np.meshgrid(a, b, indexing="ij"))
    rest = 1.0 - a
    return np.stack([rest * (1.0 - b), a, rest * b], axis=1), 2.0 * rest * np.outer(first, second).ravel()


def legendre(count):
    """Gauss's points and weights on [0, 1]."""
    x, w = roots_jacobi(count, 0, 0)
    return 0.5 * (1.0 + x), w / w.sum()
