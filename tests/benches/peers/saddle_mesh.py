"""Triangles and tetrahedra with the numbering of P2: vertices first, then the midpoints of edges.

Reads MSH 2.2 and 4.1 (ASCII) with named physical groups. Lengths are those of the file. In the plane segments of three
nodes bend the edges of cells; cells of six nodes are read by their corners.
"""
from dataclasses import dataclass, field

import numpy as np

# Vertices of Gmsh's element kinds: segment, triangle, tetrahedron; segment and triangle of second order.
CORNERS = {1: 2, 2: 3, 4: 4, 8: 2, 9: 3}
BENT = 8
EDGES = {2: [(0, 1)], 3: [(0, 1), (1, 2), (0, 2)], 4: [(0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3)]}


@dataclass
class Mesh:
    """points [vertices, dim], cells [cells, dim + 1]; groups of cells and of facets as index arrays by name; places of
    the middles of bent edges by their ends."""

    points: np.ndarray
    cells: np.ndarray
    cell_groups: dict
    facet_groups: dict
    middles: dict = field(default_factory=dict)
    edges: dict = field(default_factory=dict)

    def __post_init__(self):
        self.dim = self.points.shape[1]
        pairs = np.concatenate([np.sort(self.cells[:, e], axis=1) for e in map(list, EDGES[self.dim + 1])])
        unique = np.unique(pairs, axis=0)
        self.edge_ends = unique
        self.edges = {tuple(pair): len(self.points) + i for i, pair in enumerate(unique.tolist())}
        self.nodes = np.concatenate([self.points, self.points[unique].mean(axis=1)])
        for ends, place in self.middles.items():
            self.nodes[self.edges[ends]] = place
        self.cell_nodes = np.concatenate([self.cells, self.edge_nodes(self.cells)], axis=1)

    def edge_nodes(self, simplices):
        """Midpoint nodes of simplices [n, corners] in the order of EDGES."""
        local = EDGES[simplices.shape[1]]
        return np.array(
            [[self.edges[tuple(sorted((s[a], s[b])))] for a, b in local] for s in simplices.tolist()], dtype=int
        ).reshape(len(simplices), len(local))

    def facet_nodes(self, facets):
        """Corners, then midpoints [n, nodes]."""
        return np.concatenate([facets, self.edge_nodes(facets)], axis=1)

    def facets_of(self, names):
        return np.concatenate([self.facet_groups[name] for name in names])


def read(path, scale=1.0):
    """The mesh of a file, its lengths multiplied by `scale`."""
    sections = split(path)
    version = float(sections["MeshFormat"][0].split()[0])
    names = physical_names(sections.get("PhysicalNames", ["0"]))
    tags, points = (nodes_2 if version < 3 else nodes_4)(sections["Nodes"])
    if version < 3:
        elements = elements_2(sections["Elements"])
    else:
        elements = elements_4(sections["Elements"], entity_groups(sections["Entities"]))
    return build(tags, points * scale, elements, names)


def split(path):
    """Lines of each section by its name."""
    sections, name = {}, None
    with open(path) as file:
        for line in map(str.strip, file):
            if line.startswith("$End"):
                name = None
            elif line.startswith("$"):
                name = line[1:]
                sections[name] = []
            elif name:
                sections[name].append(line)
    return sections


def physical_names(lines):
    names = {}
    for line in lines[1:]:
        dim, tag, name = line.split(None, 2)
        names[int(dim), int(tag)] = name.strip('"')
    return names


def nodes_2(lines):
    rows = np.array([line.split() for line in lines[1:]], dtype=float)
    return rows[:, 0].astype(int), rows[:, 1:4]


def nodes_4(lines):
    tags, points, at = [], [], 1
    for _ in range(int(lines[0].split()[0])):
        count = int(lines[at].split()[3])
        tags += [int(line) for line in lines[at + 1 : at + 1 + count]]
        points += [line.split()[:3] for line in lines[at + 1 + count : at + 1 + 2 * count]]
        at += 1 + 2 * count
    return np.array(tags), np.array(points, dtype=float)


def elements_2(lines):
    """(kind, physical tags, node tags) of every element."""
    for line in lines[1:]:
        numbers = [int(n) for n in line.split()]
        yield numbers[1], [numbers[3]], numbers[3 + numbers[2] :]


def entity_groups(lines):
    """Physical tags of each entity (dim, tag)."""
    counts = [int(n) for n in lines[0].split()]
    groups, at = {}, 1
    for dim, count in enumerate(counts):
        first = 4 if dim == 0 else 7
        for line in lines[at : at + count]:
            words = line.split()
            number = int(words[first])
            groups[dim, int(words[0])] = [int(w) for w in words[first + 1 : first + 1 + number]]
        at += count
    return groups


def elements_4(lines, groups):
    at = 1
    for _ in range(int(lines[0].split()[0])):
        dim, entity, kind, count = (int(n) for n in lines[at].split())
        for line in lines[at + 1 : at + 1 + count]:
            yield kind, groups[dim, entity], [int(n) for n in line.split()[1:]]
        at += 1 + count


def build(tags, points, elements, names):
    """Cells are the simplices of the highest dimension; nodes that no cell has are left out."""
    elements = [e for e in elements if e[0] in CORNERS]
    top = max(CORNERS[kind] for kind, _, _ in elements)
    cells, facets, cell_groups, facet_groups = [], [], {}, {}
    bent = {}
    for kind, physical, nodes in elements:
        size = CORNERS[kind]
        corners = nodes[:size]
        if kind == BENT:
            bent[tuple(corners)] = nodes[size]
        if size == top:
            for tag in physical:
                cell_groups.setdefault(names[top - 1, tag], []).append(len(cells))
            cells.append(corners)
        elif size == top - 1:
            for tag in physical:
                facet_groups.setdefault(names[top - 2, tag], []).append(corners)
    used = np.unique(np.array(cells))
    where = np.full(tags.max() + 1, -1)
    where[used] = np.arange(len(used))
    order = np.full(tags.max() + 1, -1)
    order[tags] = np.arange(len(tags))
    places = points[:, : top - 1]
    middles = {tuple(sorted(where[list(ends)].tolist())): places[order[tag]] for ends, tag in bent.items()}
    return Mesh(
        points[order[used]][:, : top - 1],
        where[np.array(cells)],
        {name: np.array(group) for name, group in cell_groups.items()},
        {name: where[np.array(group)] for name, group in facet_groups.items()},
        middles,
    )
