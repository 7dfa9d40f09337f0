"""Laws of materials, many points at a time: energy W(H) of the displacement gradient H [n, 3, 3] without its
volumetric part, its slope and its tangent [n, 3, 3, 3, 3]; and the volume measure j(H) that the pressure works on,

    density = W(H) - p j(H) - p^2 / (2 K)

with j = J - 1 of rubber, div u of a linear body (1/K is then 1/lambda).
"""
from dataclasses import dataclass

import numpy as np

LEVI = np.zeros((3, 3, 3))
for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
    LEVI[i, j, k], LEVI[i, k, j] = 1.0, -1.0
# (A x B)_ij = CROSS_ij,kl,mn A_kl B_mn, so that cof F = F x F / 2.
CROSS = np.einsum("ikm,jln->ijklmn", LEVI, LEVI)
UNIT = np.eye(3)


@dataclass
class Linear:
    """mu eps : eps, in the displacement form lambda / 2 (div u)^2 besides."""

    shear: float
    inverse_bulk: float
    lame: float = 0.0
    is_rubber = False

    def response(self, h):
        strain = 0.5 * (h + np.swapaxes(h, 1, 2))
        trace = np.einsum("nii->n", h)
        energy = self.shear * np.einsum("nij,nij->n", strain, strain) + 0.5 * self.lame * trace**2
        slope = 2.0 * self.shear * strain + self.lame * trace[:, None, None] * UNIT
        symmetric = np.einsum("ik,jl->ijkl", UNIT, UNIT) + np.einsum("il,jk->ijkl", UNIT, UNIT)
        tangent = self.shear * symmetric + self.lame * np.einsum("ij,kl->ijkl", UNIT, UNIT)
        return energy, slope, np.broadcast_to(tangent, (len(h), 3, 3, 3, 3))

    def volume(self, h):
        """j, its slope and its second derivative."""
        return (
            np.einsum("nii->n", h),
            np.broadcast_to(UNIT, h.shape),
            np.zeros((1, 3, 3, 3, 3)),
        )


@dataclass
class MooneyRivlin:
    """c10 (J^(-2/3) F:F - 3) + c01 (J^(-4/3) cof F : cof F - 3)."""

    c10: float
    c01: float
    inverse_bulk: float
    is_rubber = True

    @property
    def shear(self):
        return 2.0 * (self.c10 + self.c01)

    def response(self, h):
        f = h + UNIT
        turn = np.einsum("ijklmn,pmn->pijkl", CROSS, f)
        cofactor = 0.5 * np.einsum("pijkl,pkl->pij", turn, f)
        j = np.einsum("pij,pij->p", f, cofactor) / 3.0
        first = scaled(
            2.0 / 3.0, j, cofactor, turn, np.einsum("pij,pij->p", f, f), 2.0 * f,
            2.0 * np.einsum("ik,jl->ijkl", UNIT, UNIT),
        )
        slope = 2.0 * np.einsum("pijkl,pkl->pij", turn, cofactor)
        second = 2.0 * np.einsum("pmnij,pmnkl->pijkl", turn, turn)
        second += 2.0 * np.einsum("ijklmn,pmn->pijkl", CROSS, cofactor)
        second = scaled(
            4.0 / 3.0, j, cofactor, turn, np.einsum("pij,pij->p", cofactor, cofactor), slope, second
        )
        energy = self.c10 * (first[0] - 3.0) + self.c01 * (second[0] - 3.0)
        return energy, self.c10 * first[1] + self.c01 * second[1], self.c10 * first[2] + self.c01 * second[2]

    def volume(self, h):
        f = h + UNIT
        turn = np.einsum("ijklmn,pmn->pijkl", CROSS, f)
        minors = 0.5 * np.einsum("ijklmn,pkl,pmn->pij", CROSS, h, h)
        # J - 1 without the difference of large numbers.
        change = np.einsum("pii->p", h) + np.einsum("pii->p", minors) + np.einsum("pij,pij->p", h, minors) / 3.0
        return change, 0.5 * np.einsum("pijkl,pkl->pij", turn, f), turn


def scaled(a, j, cofactor, turn, invariant, slope, second):
    """J^-a I with its first and second derivative."""
    factor = j**-a
    ratio = invariant / j
    one = factor[:, None, None] * (slope - a * ratio[:, None, None] * cofactor)
    mixed = np.einsum("pij,pkl->pijkl", slope, cofactor)
    both = np.einsum("pij,pkl->pijkl", cofactor, cofactor)
    wide = lambda x: x[:, None, None, None, None]
    two = second - wide(a / j) * (mixed + np.transpose(mixed, (0, 3, 4, 1, 2)))
    two = two + wide(a * (a + 1.0) * ratio / j) * both - wide(a * ratio) * turn
    return factor * invariant, one, wide(factor) * two


def of(table):
    """The law of a scene's material, with the displacement form for a Poisson ratio below 0.45 left to the caller."""
    model = table["model"]
    bulk = table.get("bulk_modulus", float("inf"))
    inverse = 0.0 if bulk == float("inf") else 1.0 / bulk
    if model == "neo-hookean":
        return MooneyRivlin(0.5 * table["shear_modulus"], 0.0, inverse)
    if model == "mooney-rivlin":
        return MooneyRivlin(table["c10"], table["c01"], inverse)
    if model != "linear-elastic":
        raise ValueError(f"material model {model}")
    ratio = table["poisson_ratio"]
    shear = table.get("shear_modulus") or 0.5 * table["young_modulus"] / (1.0 + ratio)
    return Linear(shear, (1.0 - 2.0 * ratio) / (2.0 * shear * ratio) if ratio else float("inf"))


# Least Poisson ratio of a linear part beside rubber.
LEAST_RATIO = 0.01


def of_all(tables):
    """The laws of all materials by group: beside rubber linear parts are neo-Hookean, K = lambda + 2 mu / 3."""
    laws = {name: of(table) for name, table in tables.items()}
    if not any(law.is_rubber for law in laws.values()):
        return laws
    for name, law in laws.items():
        if not law.is_rubber:
            ratio = max(tables[name]["poisson_ratio"], LEAST_RATIO)
            bulk = 2.0 * law.shear * (1.0 + ratio) / (3.0 * (1.0 - 2.0 * ratio)) if ratio < 0.5 else float("inf")
            laws[name] = MooneyRivlin(0.5 * law.shear, 0.0, 1.0 / bulk)
    return laws
