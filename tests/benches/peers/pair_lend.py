"""Which functions of a carrier lend their pressure to neighbours (decision 67, "Ends").

    share_m = max over the faces of m's own function of   int psi da over what has a partner / int psi da

From the largest share down, a multiplier with a share below SMALL lends where one beside it (with a function on a
common face) has enough by then; others with a share have enough. One without a partner lends where one of those that
could take its function over presses. The nearest of those that have enough, at rest, take it over in equal parts: of
those beside it, or where none of them has, of those beside its neighbours that have too little.
"""
import numpy as np

SMALL, EQUAL = 0.33, 1e-6
NOTHING, LITTLE, ENOUGH = 0, 1, 2


class Lending:
    """Of T [multipliers, functions], numbers of functions [f, 3] and places of their nodes [functions, i]."""

    def __init__(self, merge, numbers, places):
        # The function that each multiplier was made of: no other one is given away to it as a whole.
        self.merge, self.own = merge, own_functions(merge)
        self.numbers, self.places = numbers, places[self.own]
        self.beside = self.neighbours()

    def neighbours(self):
        beside = [set() for _ in self.merge]
        for face in self.numbers:
            on_face = np.flatnonzero(self.merge[:, face].any(axis=1)).tolist()
            for m in on_face:
                beside[m].update(set(on_face) - {m})
        return beside

    def shares(self, covered, whole):
        """From integrals of faces [f, 3]."""
        found = np.zeros(self.merge.shape[1])
        np.maximum.at(found, self.numbers.ravel(), (covered / whole).ravel())
        return found[self.own]

    def lent(self, shares, pressures):
        """T where those lend that have too little to press on, which `pressures` press on at the start."""
        support = np.full(len(shares), NOTHING)
        for m in np.argsort(-shares, kind="stable"):
            if shares[m] > 0.0:
                is_small = shares[m] < SMALL and any(support[k] == ENOUGH for k in self.beside[m])
                support[m] = LITTLE if is_small else ENOUGH
        takers = {m: self.takers(m, support) for m in np.flatnonzero(support != ENOUGH).tolist()}
        merge = self.merge.copy()
        for m, others in takers.items():
            if support[m] == LITTLE or any(pressures[k] > 0.0 for k in others):
                merge[m] = 0.0
                near = self.nearest(m, others)
                merge[near] += self.merge[m] / len(near)
        return merge

    def takers(self, m, support):
        """Those that may take over the function of m."""
        around = self.beside[m]
        direct = {k for k in around if support[k] == ENOUGH}
        if direct:
            return sorted(direct)
        beyond = set().union(*(self.beside[k] for k in around if support[k] == LITTLE))
        return sorted(k for k in beyond if support[k] == ENOUGH)

    def nearest(self, m, others):
        away = np.linalg.norm(self.places[others] - self.places[m], axis=1)
        return np.array(others)[away <= (1 + EQUAL) * away.min()]

    def carried(self, before, values):
        """Values of multipliers from those of before: what their own function had."""
        return (values @ before)[self.own]


def own_functions(merge):
    """Functions that supports leave alone have a multiplier each, in their order."""
    columns, left = [], set(range(merge.shape[1]))
    for row in merge:
        first = min(k for k in np.flatnonzero(row == 1.0).tolist() if k in left)
        left.discard(first)
        columns.append(first)
    return np.array(columns, dtype=int)
