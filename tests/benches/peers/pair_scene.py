"""Scene files with `[[contact]]` as problems of `saddle_newton`."""
import numpy as np

from pair_surface import Pair, Pairs
from saddle_scene import Problem, listed

# Ratio of moduli up to which bodies are alike.
ALIKE = 3.0
# Points on a piece.
POINTS = 5


class PairProblem(Problem):
    """A scene of bodies in contact with each other."""

    def __init__(self, path, points=POINTS):
        super().__init__(path)
        scene, mesh = self.scene, self.mesh
        if not scene.get("contact"):
            raise ValueError("contact between bodies is solved here")
        is_rough = any("friction" in table or "tresca" in table for table in scene["contact"])
        if scene.get("obstacle") and is_rough:
            raise ValueError("friction beside obstacles is not solved here")
        held = np.zeros(self.body.displacements, dtype=bool)
        held[self.held] = True
        options = (self.is_rubber, scene.get("kind") == "axisymmetric", points)
        self.contacts = [self.named(number, table) for number, table in enumerate(scene["contact"], 1)]
        pairs = []
        for table in self.contacts:
            sides = [mesh.facets_of(listed(name)) for name in table["between"]]
            table["carrier"] = self.carrier(table, sides)
            ordered = [sides[table["carrier"]], sides[1 - table["carrier"]]]
            pairs.append(Pair(table["name"], mesh, ordered, held, options))
        self.surface = Pairs(mesh, pairs, (self.surface, self.placed(self.start())))

    @staticmethod
    def named(number, table):
        return {"name": f"contact-{number}"} | table

    def carrier(self, table, sides):
        """Which of the two groups carries: the named one, the softer one, the finer one, the first one."""
        if "carries" in table:
            return listed(table["between"]).index(table["carries"])
        first, second = (self.modulus(facets) for facets in sides)
        if first > ALIKE * second or second > ALIKE * first:
            return int(first > second)
        points = self.mesh.points
        first, second = (np.linalg.norm(points[f[:, 1]] - points[f[:, 0]], axis=1).mean() for f in sides)
        return int(second < (1 - 1e-9) * first)

    def modulus(self, facets):
        """The least shear modulus beside facets."""
        ends = {frozenset(facet) for facet in facets.tolist()}
        least = np.inf
        for name, cells in self.mesh.cell_groups.items():
            for cell in self.mesh.cells[cells].tolist():
                if any(frozenset(cell[:k] + cell[k + 1 :]) in ends for k in range(3)):
                    least = min(least, self.laws[name].shear)
                    break
        return least

