"""Area of faces by the points of a rule: of the undeformed facets, or of the deformed ones with derivatives

    da = |t_1 x t_2| (space), |t_1| (plane),   t_s = sum_a N_a,s x_a,   by the nodes' places x_a.

With c = t_1 x t_2 and m = c / |c|, for displacements v, w with tangents v_s, w_s:

    d|c|(v) = m . dc(v),   dc(v) = v_1 x t_2 + t_1 x v_2
    d2|c|(v, w) = m . (v_1 x w_2 + w_1 x v_2) + dc(v) . (I - m m') dc(w) / |c|

Shapes: facets f, points q, nodes a, tangents s, axes i. Weights of the rule, with sum one, are in the areas.
"""
from dataclasses import dataclass

import numpy as np

from saddle_rule import p2_slopes

# e[k, i, j]: (a x b)_k = e_kij a_i b_j.
CROSS = np.zeros((3, 3, 3))
CROSS[[0, 1, 2], [1, 2, 0], [2, 0, 1]] = 1.0
CROSS[[0, 1, 2], [2, 0, 1], [1, 2, 0]] = -1.0


@dataclass
class Area:
    """Area [f, q], its slope [f, q, a, i] and curvature by tangents [f, q, s, i, t, j], with the N_a,s [q, s, a]."""

    value: np.ndarray
    slope: np.ndarray
    tangents: np.ndarray
    gradients: np.ndarray

    def curvature(self, factor):
        """sum_q factor[f, q] d2(da) by places [f, a, i, b, j]."""
        scaled = factor[:, :, None, None, None, None] * self.tangents
        return np.einsum("qsa,qtb,fqsitj->faibj", self.gradients, self.gradients, scaled, optimize=True)


class Undeformed:
    """dS, that of the facets at rest."""

    def __init__(self, points, weights):
        self.weights = weights

    def area(self, measure, _places):
        return Area(np.outer(measure, self.weights), None, None, None)


class Deformed:
    """da, that of the facets where they are."""

    def __init__(self, points, weights):
        self.weights = weights
        slopes = p2_slopes(points)
        # Along the sides from the first corner.
        self.gradients = np.stack([slopes[..., s] - slopes[..., 0] for s in range(1, points.shape[1])], axis=1)

    def area(self, _measure, places):
        """At places of the nodes [f, a, i]."""
        t = np.einsum("qsa,fai->fqsi", self.gradients, places)
        length, by_tangents, second = segment(t[:, :, 0]) if t.shape[2] == 1 else triangle(t[:, :, 0], t[:, :, 1])
        weights = self.weights[:, None, None]
        slope = weights * np.einsum("qsa,fqsi->fqai", self.gradients, by_tangents)
        return Area(self.weights * length, slope, weights[..., None, None] * second, self.gradients)


def segment(t):
    """|t| with derivatives [f, q, 1, i] and [f, q, 1, i, 1, j]."""
    length = np.linalg.norm(t, axis=-1)
    m = t / length[..., None]
    second = across(m, length)
    return length, m[:, :, None], second[:, :, None, :, None, :]


def triangle(t1, t2):
    """|t1 x t2| / 2 with derivatives [f, q, s, i] and [f, q, s, i, t, j]."""
    c = np.cross(t1, t2)
    length = np.linalg.norm(c, axis=-1)
    m = c / length[..., None]
    # dc_k = turns[k, s, i] v_s,i.
    turns = np.stack(
        [np.einsum("kij,fqj->fqki", CROSS, t2), np.einsum("kji,fqj->fqki", CROSS, t1)], axis=3
    )
    first = np.einsum("fqk,fqksi->fqsi", m, turns)
    second = np.einsum("fqksi,fqkl,fqltj->fqsitj", turns, across(m, length), turns, optimize=True)
    mixed = np.einsum("fqk,kij->fqij", m, CROSS)
    second[:, :, 0, :, 1, :] += mixed
    second[:, :, 1, :, 0, :] += np.swapaxes(mixed, 2, 3)
    return 0.5 * length, 0.5 * first, 0.5 * second


def across(m, length):
    """(I - m m') / length."""
    return (np.eye(m.shape[-1]) - m[..., :, None] * m[..., None, :]) / length[..., None, None]
