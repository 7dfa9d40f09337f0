"""Bodies of triangles from grids, bent by maps and written together as one MSH 2.2 file with groups BODY-SIDE."""
import numpy as np

SIDES = ("y0", "x1", "y1", "x0")


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
        number = np.arange(len(place)).reshape(nx + 1, ny + 1)
        if closed:
            number[nx] = number[0]
        a, b = number[:-1, :-1].ravel(), number[1:, :-1].ravel()
        c, d = number[1:, 1:].ravel(), number[:-1, 1:].ravel()
        flip = (np.add.outer(np.arange(nx), np.arange(ny)) % 2).ravel().astype(bool)[:, None]
        first = np.where(flip, np.stack([a, b, d], axis=1), np.stack([a, b, c], axis=1))
        second = np.where(flip, np.stack([b, c, d], axis=1), np.stack([a, c, d], axis=1))
        cells = np.concatenate([first, second])
        lines = {"y0": number[:, 0], "x1": number[nx], "y1": number[::-1, ny], "x0": number[0, ::-1]}
        sides = {side: np.stack([line[:-1], line[1:]], axis=1) for side, line in lines.items()}
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
        self.points = np.round(self.points @ np.array([[c, s], [-s, c]]), 8)

    def join(self, name, sides):
        """One group in the place of some sides."""
        self.sides[name] = np.concatenate([self.sides.pop(side) for side in sides])

    def nearest(self, place):
        """The vertex inside that is nearest."""
        inside = np.setdiff1d(np.arange(len(self.points)), np.concatenate(list(self.sides.values())))
        points = self.points[inside]
        return points[np.linalg.norm(points - np.array(place), axis=1).argmin()]


def write(path, bodies):
    lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$PhysicalNames"]
    facets = [(body, side) for body in bodies for side in body.sides]
    lines.append(str(len(bodies) + len(facets)))
    lines += [f'2 {i} "{body.name}"' for i, body in enumerate(bodies, 1)]
    lines += [f'1 {10 + i} "{body.name}-{side}"' for i, (body, side) in enumerate(facets)]
    first = np.cumsum([0] + [len(body.points) for body in bodies])
    lines += ["$EndPhysicalNames", "$Nodes", str(first[-1])]
    for number, (x, y) in enumerate(np.concatenate([body.points for body in bodies]), 1):
        lines.append(f"{number} {x:.10g} {y:.10g} 0")
    offset = {id(body): start for body, start in zip(bodies, first)}
    rows = [(1, 10 + i, f + offset[id(b)]) for i, (b, side) in enumerate(facets) for f in b.sides[side]]
    rows += [(2, i, cell + offset[id(body)]) for i, body in enumerate(bodies, 1) for cell in body.cells]
    lines += ["$EndNodes", "$Elements", str(len(rows))]
    for number, (kind, tag, corners) in enumerate(rows, 1):
        lines.append(f"{number} {kind} 2 {tag} {tag} " + " ".join(str(c + 1) for c in corners))
    path.write_text("\n".join([*lines, "$EndElements", ""]))
