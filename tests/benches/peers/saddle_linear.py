"""Symmetric indefinite sparse systems by a direct factorisation with its inertia: Pardiso (package pypardiso), or
SuperLU with the inertia of a dense factorisation where that package is absent.
"""
import copy
import functools

import numpy as np
import scipy.linalg
import scipy.sparse as sp
import scipy.sparse.linalg as spl

try:
    from pypardiso import PyPardisoSolver
except ImportError:
    PyPardisoSolver = None

# Largest system whose inertia a dense factorisation gives.
DENSE = 1200
REFINEMENTS = 3


class Factor:
    """A factorisation of a symmetric matrix."""

    def __init__(self, matrix):
        self.matrix = matrix.tocsr()
        if PyPardisoSolver is None:
            try:
                self.own = spl.splu(self.matrix.tocsc())
            except RuntimeError as fault:
                raise np.linalg.LinAlgError(str(fault)) from None
            return
        self.own = new_solver()
        # Own parameters; scaling, matching and Bunch-Kaufman pivots for saddle points; refinement; inertia.
        for number, value in ((1, 1), (2, 2), (8, 4), (10, 10), (11, 1), (13, 1), (21, 1)):
            self.own.set_iparm(number, value)
        size = matrix.shape[0]
        self.upper = with_diagonal(sp.triu(self.matrix, format="csr"))
        self.own.set_phase(12)
        self.own._call_pardiso(self.upper, np.zeros((size, 1)))
        self.negative, self.perturbed = int(self.own.iparm[22]), int(self.own.iparm[13])

    def plain(self, right):
        if PyPardisoSolver is None:
            return self.own.solve(right)
        self.own.set_phase(33)
        return self.own._call_pardiso(self.upper, np.asfortranarray(right).reshape(-1, 1)).ravel()

    def solve(self, right):
        """With refinement against the matrix itself."""
        right = np.asarray(right, dtype=float)
        found = self.plain(right)
        for _ in range(REFINEMENTS):
            rest = right - self.matrix @ found
            if np.abs(rest).max(initial=0.0) <= 1e-15 * np.abs(right).max(initial=0.0):
                break
            better = found + self.plain(rest)
            if np.linalg.norm(right - self.matrix @ better) >= np.linalg.norm(rest):
                break
            found = better
        return found

    def negatives(self):
        """Number of negative eigenvalues."""
        size = self.matrix.shape[0]
        if PyPardisoSolver is not None and not (self.perturbed and size <= DENSE):
            return self.negative
        return dense_negatives(self.matrix.toarray())

    def free(self):
        if PyPardisoSolver is not None:
            self.own.free_memory(everything=True)


def general(matrix, right):
    """The solution of an unsymmetric system, refined."""
    matrix = matrix.tocsc()
    try:
        factor = spl.splu(matrix)
    except RuntimeError as fault:
        raise np.linalg.LinAlgError(str(fault)) from None
    found = factor.solve(right)
    for _ in range(REFINEMENTS):
        found = found + factor.solve(right - matrix @ found)
    return found


@functools.cache
def library():
    """The solver whose library all others share: looking for it takes longer than a small factorisation."""
    return PyPardisoSolver(mtype=-2)


def new_solver():
    own = copy.copy(library())
    own.pt, own.iparm = np.zeros_like(own.pt), np.zeros_like(own.iparm)
    return own


def with_diagonal(upper):
    """The matrix with every diagonal entry, zero ones too."""
    size = upper.shape[0]
    rows = np.concatenate([np.repeat(np.arange(size), np.diff(upper.indptr)), np.arange(size)])
    columns = np.concatenate([upper.indices, np.arange(size)])
    values = np.concatenate([upper.data, np.zeros(size)])
    order = np.lexsort((columns, rows))
    rows, columns, values = rows[order], columns[order], values[order]
    first = np.ones(len(rows), dtype=bool)
    first[1:] = (rows[1:] != rows[:-1]) | (columns[1:] != columns[:-1])
    sums = np.add.reduceat(values, np.flatnonzero(first))
    rows, columns = rows[first], columns[first]
    pointers = np.searchsorted(rows, np.arange(size + 1))
    return sp.csr_matrix((sums, columns.astype(np.int32), pointers.astype(np.int32)), shape=upper.shape)


def dense_negatives(matrix):
    """From the blocks of a Bunch-Kaufman factorisation."""
    scale = 1.0 / np.sqrt(np.maximum(np.abs(matrix).max(axis=1), 1e-300))
    _, blocks, _ = scipy.linalg.ldl(matrix * np.outer(scale, scale))
    values = scipy.linalg.eigvalsh_tridiagonal(np.diag(blocks).copy(), np.diag(blocks, 1).copy())
    return int((values < 0.0).sum())
