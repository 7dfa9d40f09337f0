"""Bodies of triangles from grids, bent by maps and written together as one MSH 2.2 file with groups BODY-SIDE."""
import numpy as np


class Grid:
    """[0, 1] x [0, 1] of `counts` squares, two triangles each, bent by `where(s, t)`; inner vertices moved by up to
    `jitter` of a square. `closed` joins x0 to x1. Sides: x0, x1, y0, y1."""

    def __init__(self, name, counts, where, random, jitter=0.0, closed=False):
        self.name = name
        nx, ny = counts
        place = np.stack(np.meshgrid(np.arange(nx + 1), np.arange(ny + 1), indexing="ij"), axis=-1).reshape(-1, 2)
        inside = ((place > 0) & (place < [nx, ny])).all(axis=1)
        moved = place + jitter * random.uniform(-1.0, 1.0, place.shape) * inside[:, None]
        points = np.stack(where(moved[:, 0] / nx, moved[:, 1] / ny), axis=1)
        grid = np.arange(len(place)).reshape(nx + 1, ny + 1)
        number = grid.copy()
        if closed:
            number[nx] = number[0]
        a, b = number[:-1, :-1].ravel(), number[1:, :-1].ravel()
        c, d = number[1:, 1:].ravel(), number[:-1, 1:].ravel()
        flip = (np.add.outer(np.arange(nx), np.arange(ny)) % 2).ravel().astype(bool)[:, None]
        first = np.where(flip, np.stack([a, b, d], axis=1), np.stack([a, b, c], axis=1))
        second = np.where(flip, np.stack([b, c, d], axis=1), np.stack([a, c, d], axis=1))
        cells = np.concatenate([first, second])
        sides = around(number)
        middles = {side: place[facets].mean(axis=1) for side, facets in around(grid).items()}
        # Middles of the edges of each side, where that is curved.
        self.middles = {side: np.round(np.stack(where(*(m / counts).T), axis=1), 8) for side, m in middles.items()}
        if closed:
            sides.pop("x0"), sides.pop("x1")
        used, inverse = np.unique(cells, return_inverse=True)
        back = np.full(len(place), -1)
        back[used] = np.arange(len(used))
        # Eight digits in the file, so that every reader has the same bits.
        self.points = np.round(points[used], 8)
        self.size = float(np.ptp(self.points, axis=0).max())
        self.cells = inverse.reshape(cells.shape)
        self.sides = {side: back[facets] for side, facets in sides.items()}
        corners = self.points[self.cells]
        edges = corners[:, 1:] - corners[:, :1]
        turned = np.linalg.det(edges) < 0
        self.cells[turned] = self.cells[turned][:, [0, 2, 1]]

    def turn(self, angle):
        """Turns it about the origin."""
        c, s = np.cos(angle), np.sin(angle)
        turn = np.array([[c, s], [-s, c]])
        self.points = np.round(self.points @ turn, 8)
        self.middles = {side: np.round(middles @ turn, 8) for side, middles in self.middles.items()}

    def join(self, name, sides):
        """One group in the place of some sides."""
        self.sides[name] = np.concatenate([self.sides.pop(side) for side in sides])
        self.middles[name] = np.concatenate([self.middles.pop(side) for side in sides])

    def nearest(self, place):
        """The vertex inside that is nearest."""
        inside = np.setdiff1d(np.arange(len(self.points)), np.concatenate(list(self.sides.values())))
        points = self.points[inside]
        return points[np.linalg.norm(points - np.array(place), axis=1).argmin()]


def around(number):
    """Edges of each side of a grid of numbers, the body on their left."""
    lines = {"y0": number[:, 0], "x1": number[-1], "y1": number[::-1, -1], "x0": number[0, ::-1]}
    return {side: np.stack([line[:-1], line[1:]], axis=1) for side, line in lines.items()}


def second_order(body):
    """Middles of all edges [edges, 2] with their numbers by the ends: those of the sides where they are, others between
    the ends."""
    numbers, middles = {}, []
    for side, facets in body.sides.items():
        for ends, middle in zip(facets.tolist(), body.middles[side]):
            numbers[frozenset(ends)] = len(middles)
            middles.append(middle)
    for cell in body.cells.tolist():
        for ends in ((cell[0], cell[1]), (cell[1], cell[2]), (cell[2], cell[0])):
            if frozenset(ends) not in numbers:
                numbers[frozenset(ends)] = len(middles)
                middles.append(body.points[list(ends)].mean(axis=0))
    return np.array(middles), numbers


def write(path, bodies, curved=False):
    """Of second order where `curved`."""
    lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$PhysicalNames"]
    facets = [(body, side) for body in bodies for side in body.sides]
    lines.append(str(len(bodies) + len(facets)))
    lines += [f'2 {i} "{body.name}"' for i, body in enumerate(bodies, 1)]
    lines += [f'1 {10 + i} "{body.name}-{side}"' for i, (body, side) in enumerate(facets)]
    nodes, rows, first = [], [], 0
    for tag, body in enumerate(bodies, 1):
        middles, numbers = second_order(body) if curved else (np.zeros((0, 2)), {})
        own = [(1, 10 + i, f.tolist()) for i, (b, side) in enumerate(facets) if b is body for f in b.sides[side]]
        own += [(2, tag, cell.tolist()) for cell in body.cells]
        if curved:
            own = [with_middles(row, numbers, len(body.points)) for row in own]
        rows += [(kind, group, np.array(corners) + first) for kind, group, corners in own]
        nodes += [*body.points, *middles]
        first += len(body.points) + len(middles)
    lines += ["$EndPhysicalNames", "$Nodes", str(len(nodes))]
    lines += [f"{number} {x:.17g} {y:.17g} 0" for number, (x, y) in enumerate(nodes, 1)]
    lines += ["$EndNodes", "$Elements", str(len(rows))]
    for number, (kind, tag, corners) in enumerate(rows, 1):
        lines.append(f"{number} {kind} 2 {tag} {tag} " + " ".join(str(c + 1) for c in corners))
    path.write_text("\n".join([*lines, "$EndElements", ""]))


def with_middles(row, numbers, first):
    """The element of second order."""
    kind, group, corners = row
    edges = [corners] if kind == 1 else [(corners[k], corners[(k + 1) % 3]) for k in range(3)]
    return {1: 8, 2: 9}[kind], group, corners + [first + numbers[frozenset(ends)] for ends in edges]
