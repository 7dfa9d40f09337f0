"""Boxes of triangles or tetrahedra with named sides, written as MSH 2.2."""
import itertools

import numpy as np

AXES = "xyz"


class Box:
    """Cells of a box [0, sizes] of `counts` cells an axis, two triangles or six Kuhn tetrahedra each; inner vertices
    moved by up to `jitter` of a cell. `halves` cuts the last upper side in two groups at the middle of axis x."""

    def __init__(self, sizes, counts, jitter, halves, random):
        self.dim = len(sizes)
        self.sizes, self.counts = np.array(sizes, dtype=float), np.array(counts)
        lines = [np.arange(n + 1) for n in counts]
        grid = np.stack([g.ravel(order="F") for g in np.meshgrid(*lines, indexing="ij")], axis=1)
        self.grid = grid
        spacing = self.sizes / self.counts
        inside = ((grid > 0) & (grid < self.counts)).all(axis=1)
        moves = jitter * random.uniform(-1.0, 1.0, grid.shape) * inside[:, None]
        # Eight digits in the file, so that every reader has the same bits.
        self.points = np.round((grid + moves) * spacing, 8)
        self.cells = self.make_cells()
        # Cells of each material; a second one takes its cells out of the first.
        self.regions = {"body": np.arange(len(self.cells))}
        self.facets = self.make_facets(halves)

    def number(self, place):
        strides = np.concatenate([[1], np.cumprod(self.counts + 1)[:-1]])
        return place @ strides

    def make_cells(self):
        corners = self.grid[(self.grid < self.counts).all(axis=1)]
        cells = []
        for walk in itertools.permutations(range(self.dim)):
            place, path = corners.copy(), [self.number(corners)]
            for axis in walk:
                place[:, axis] += 1
                path.append(self.number(place))
            if np.linalg.det(np.eye(self.dim)[list(walk)]) < 0:
                path[-1], path[-2] = path[-2], path[-1]
            cells.append(np.stack(path, axis=1))
        return np.stack(cells, axis=1).reshape(-1, self.dim + 1)

    def make_facets(self, halves):
        facets = {}
        for skipped in range(self.dim + 1):
            corners = np.delete(self.cells, skipped, axis=1)
            for axis in range(self.dim):
                for end in (0, 1):
                    on = (self.grid[corners][:, :, axis] == end * self.counts[axis]).all(axis=1)
                    name = f"{AXES[axis]}{end}"
                    facets.setdefault(name, []).append(corners[on])
        facets = {name: np.concatenate(parts) for name, parts in facets.items()}
        if halves:
            name = f"{AXES[self.dim - 1]}1"
            top = facets.pop(name)
            left = self.grid[top][:, :, 0].mean(axis=1) < self.counts[0] // 2
            facets[name + "a"], facets[name + "b"] = top[left], top[~left]
        return facets

    def split(self, axis, line):
        """Cells beyond a grid line become the material `other`."""
        beyond = self.grid[self.cells][:, :, axis].mean(axis=1) > line
        self.regions = {"body": np.flatnonzero(~beyond), "other": np.flatnonzero(beyond)}

    def place(self, where):
        """Moves every point by a map; eight digits in the file as before."""
        self.points = np.round(where(self.points), 8)

    def write(self, path):
        kinds = {2: (1, 2), 3: (2, 4)}[self.dim]
        names, regions = list(self.facets), list(self.regions)
        lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$PhysicalNames", str(len(names) + len(regions))]
        lines += [f'{self.dim} {i} "{n}"' for i, n in enumerate(regions, 1)]
        lines += [f'{self.dim - 1} {10 + i} "{n}"' for i, n in enumerate(names)]
        lines += ["$EndPhysicalNames", "$Nodes", str(len(self.points))]
        for number, point in enumerate(self.points, 1):
            lines.append(" ".join([str(number)] + [f"{x:.10g}" for x in (*point, 0.0)[:3]]))
        rows = [(kinds[0], 10 + i, f) for i, n in enumerate(names) for f in self.facets[n]]
        rows += [(kinds[1], i, self.cells[c]) for i, n in enumerate(regions, 1) for c in self.regions[n]]
        lines += ["$EndNodes", "$Elements", str(len(rows))]
        for number, (kind, tag, corners) in enumerate(rows, 1):
            lines.append(f"{number} {kind} 2 {tag} {tag} " + " ".join(str(c + 1) for c in corners))
        path.write_text("\n".join(lines + ["$EndElements", ""]))
