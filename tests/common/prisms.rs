//! Meshes of the plane that are drawn out into space: prisms, each of three tetrahedra.

use std::cmp::Ordering;

use signorini::{CellKind, Group, GroupKind, MeshParts};

/// `parts` of the plane drawn out to `height` in `layers` layers, groups `z0` and `z1` beside those of
/// `parts`, whose facets become the sides of prisms. Halves that are mirror images across y = 0 stay so.
pub(crate) fn drawn_out(parts: &MeshParts, layers: usize, height: f64) -> MeshParts {
    let plane = Plane { parts, layers };
    let corners: Vec<[u32; 3]> = parts
        .cells
        .chunks(3)
        .map(|one| [one[0], one[1], one[2]])
        .collect();
    let cells: Vec<u32> = corners.iter().flat_map(|&one| plane.prisms(one)).collect();
    let mut facets: Vec<u32> = Vec::new();
    for side in parts.facets.chunks(2) {
        facets.extend(plane.sides([side[0], side[1]]));
    }
    let lids = facets.len() / 3;
    for layer in [0, layers] {
        let lid = corners.iter().flatten();
        facets.extend(lid.map(|&vertex| plane.number(vertex, layer)));
    }
    let mut groups: Vec<Group> = parts
        .groups
        .iter()
        .map(|group| {
            let each = match group.kind {
                GroupKind::Cells => 3 * layers,
                GroupKind::Facets => 2 * layers,
            } as u32;
            let members = group.members.iter();
            Group {
                members: members
                    .flat_map(|&one| each * one..each * (one + 1))
                    .collect(),
                ..group.clone()
            }
        })
        .collect();
    for (k, name) in ["z0", "z1"].into_iter().enumerate() {
        let first = lids + k * corners.len();
        groups.push(Group {
            name: name.to_owned(),
            kind: GroupKind::Facets,
            members: (first as u32..(first + corners.len()) as u32).collect(),
        });
    }
    let level = |layer: usize| height * layer as f64 / layers as f64;
    let all = (0..=layers).flat_map(|layer| {
        let plane = parts.coordinates.iter();
        plane.map(move |&[x, y, _]| [x, y, level(layer)])
    });
    MeshParts {
        cell_kind: CellKind::Tetrahedron,
        coordinates: all.collect(),
        cells,
        facets,
        groups,
    }
}

struct Plane<'a> {
    parts: &'a MeshParts,
    layers: usize,
}

impl Plane<'_> {
    fn number(&self, vertex: u32, layer: usize) -> u32 {
        (layer * self.parts.coordinates.len()) as u32 + vertex
    }

    /// The order in which prisms are cut: by places, the same in a mirror image.
    fn order(&self, a: u32, b: u32) -> Ordering {
        let [[ax, ay, _], [bx, by, _]] = [a, b].map(|k| self.parts.coordinates[k as usize]);
        ax.total_cmp(&bx)
            .then(ay.abs().total_cmp(&by.abs()))
            .then(ay.total_cmp(&by))
    }

    fn prisms(&self, mut corners: [u32; 3]) -> Vec<u32> {
        let counter = corners;
        corners.sort_by(|&a, &b| self.order(a, b));
        let turns =
            (0..3).any(|k| corners == [counter[k], counter[(k + 1) % 3], counter[(k + 2) % 3]]);
        let [a, b, c] = corners;
        let layers = 0..self.layers;
        layers
            .flat_map(|layer| {
                let [low, high] = [layer, layer + 1];
                let at = |vertex: u32, layer: usize| self.number(vertex, layer);
                [
                    [at(a, low), at(b, low), at(c, low), at(c, high)],
                    [at(a, low), at(b, low), at(c, high), at(b, high)],
                    [at(a, low), at(a, high), at(b, high), at(c, high)],
                ]
            })
            .flat_map(|mut cell| {
                if !turns {
                    cell.swap(2, 3);
                }
                cell
            })
            .collect()
    }

    fn sides(&self, mut ends: [u32; 2]) -> Vec<u32> {
        ends.sort_by(|&a, &b| self.order(a, b));
        let [a, b] = ends;
        let layers = 0..self.layers;
        layers
            .flat_map(|layer| {
                let [low, high] = [layer, layer + 1];
                let at = |vertex: u32, layer: usize| self.number(vertex, layer);
                [
                    [at(a, low), at(b, low), at(b, high)],
                    [at(a, low), at(a, high), at(b, high)],
                ]
            })
            .flatten()
            .collect()
    }
}
