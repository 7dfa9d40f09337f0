"""Input decks of CalculiX: C3D10 tetrahedra under a rigid plate, face-to-face contact with friction."""
import numpy as np

from friction_scenes import FRICTION, POISSON, YOUNG

# Pairs of corners that the nodes 5 to 10 of a C3D10 lie between, and the corners of its faces S1 to S4.
EDGES = ((0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3))
FACES = ((0, 1, 2), (0, 1, 3), (1, 2, 3), (0, 2, 3))
# One increment a step, not to be cut.
DIRECT = ("*STATIC, DIRECT", "1., 1.")
# The plate reaches that far beyond the origin, and is that thick.
REACH, THICKNESS = 2.0, 0.5


class Body:
    """Quadratic tetrahedra with straight edges: nodes, elements, sides by name."""

    def __init__(self, grid):
        self.ends, inverse = np.unique(
            np.sort(np.concatenate([grid.cells[:, edge] for edge in EDGES]), axis=1), axis=0, return_inverse=True
        )
        corners = len(grid.points)
        middles = inverse.reshape(len(EDGES), -1).T + corners
        self.nodes = np.concatenate([grid.points, grid.points[self.ends].mean(axis=1)])
        self.cells = np.concatenate([grid.cells, middles], axis=1)
        self.grid = grid
        self.face_of = {
            tuple(sorted(cell[corner] for corner in face)): (number, place)
            for number, cell in enumerate(grid.cells.tolist(), start=1)
            for place, face in enumerate(FACES, start=1)
        }

    def facets(self, side):
        return [tuple(sorted(facet)) for facet, name in zip(self.grid.facets.tolist(), self.grid.sides) if name == side]

    def faces(self, side):
        """Elements, counted from one, and the number of their face."""
        return [self.face_of[facet] for facet in self.facets(side)]

    def nodes_of(self, side):
        """Corners and midside nodes of a side, counted from one."""
        facets = self.facets(side)
        corners = {corner for facet in facets for corner in facet}
        edges = {(facet[a], facet[b]) for facet in facets for a, b in ((0, 1), (0, 2), (1, 2))}
        place = len(self.grid.points)
        middles = {place + k for k, ends in enumerate(map(tuple, self.ends.tolist())) if ends in edges}
        return sorted(node + 1 for node in corners | middles)


def numbers(values):
    """A list in lines of sixteen."""
    values = [str(value) for value in values]
    return [", ".join(values[k : k + 16]) for k in range(0, len(values), 16)]


def plate(scene, first):
    """Nodes of one brick whose face S1 or S2 touches the body."""
    heights = sorted((scene.height, scene.height + scene.above * THICKNESS))
    corners = ((-1, -1), (1, -1), (1, 1), (-1, 1))
    places = [(x * REACH, y * REACH, z) for z in heights for x, y in corners]
    return [f"{first + k}, {x}, {y}, {z!r}" for k, (x, y, z) in enumerate(places)]


def model(body, scene, contact):
    """All but the steps; `contact` holds the lines of the interaction and the type of the pair."""
    lines = ["*NODE, NSET=BODY"]
    lines += [f"{k}, {x:.13g}, {y:.13g}, {z:.13g}" for k, (x, y, z) in enumerate(body.nodes.tolist(), start=1)]
    first = len(body.nodes) + 1
    lines += ["*NODE, NSET=TOOL", *plate(scene, first), "*ELEMENT, TYPE=C3D10, ELSET=BODY"]
    lines += [", ".join(map(str, (k, *cell))) for k, cell in enumerate((body.cells + 1).tolist(), start=1)]
    brick = len(body.cells) + 1
    lines += ["*ELEMENT, TYPE=C3D8, ELSET=TOOL", ", ".join(map(str, (brick, *range(first, first + 8))))]
    for name, nodes in (("HELD", body.nodes_of(scene.held)), *((side, body.nodes_of(side)) for side, _ in scene.symmetric)):
        lines += [f"*NSET, NSET={name}", *numbers(nodes)]
    supported = set(body.nodes_of(scene.held)).union(*(body.nodes_of(side) for side, _ in scene.symmetric))
    lines += ["*NSET, NSET=SUPPORT", *numbers(sorted(supported))]
    lines += ["*SURFACE, NAME=SLAVE"] + [f"{cell}, S{face}" for cell, face in body.faces(scene.contact)]
    lines += ["*SURFACE, NAME=MASTER", f"{brick}, S{1 if scene.above > 0 else 2}"]
    lines += ["*MATERIAL, NAME=ELASTIC", "*ELASTIC", f"{YOUNG!r}, {POISSON!r}"]
    lines += ["*SOLID SECTION, ELSET=BODY, MATERIAL=ELASTIC", "*SOLID SECTION, ELSET=TOOL, MATERIAL=ELASTIC"]
    behaviour, friction, kind = contact
    lines += ["*SURFACE INTERACTION, NAME=ROUGH", *behaviour, "*FRICTION", f"{FRICTION}, {friction!r}"]
    lines += [f"*CONTACT PAIR, INTERACTION=ROUGH, TYPE={kind}", "SLAVE, MASTER"]
    lines += ["*BOUNDARY", "HELD, 1, 3"]
    lines += [f"{side}, {axis + 1}, {axis + 1}" for side, axis in scene.symmetric]
    return lines


def steps(scene, procedure, controls):
    """One step for each place of the tool."""
    lines = []
    for place in scene.path:
        lines += ["*STEP, INC=1000", *procedure, *controls, "*BOUNDARY"]
        lines += [f"TOOL, {axis}, {axis}, {value!r}" for axis, value in enumerate(place, start=1)]
        # Reactions of the plate would lack the forces of mortar contact.
        lines += ["*NODE PRINT, NSET=SUPPORT, TOTALS=ONLY", "RF", "*END STEP"]
    return lines
