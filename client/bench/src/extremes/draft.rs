//! Meshes of the trials: boxes, rectangles and discs of simplices, as MSH 2.2 text.
//!
//! A [`Draft`] is made in unit coordinates, which name its sides: x0 is the side of
//! the least first coordinate, and so on; a disc has one side, its skin. Bodies give
//! its vertices their places and its cells their groups.

use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::fmt::{self, Write as _};

type Point = [f64; 3];

/// Orders of the axes along which the six tetrahedra of a cell of a box walk from its
/// first corner to its last, the last three turning the other way.
const WALKS: [[usize; 3]; 6] = [
    [0, 1, 2],
    [1, 2, 0],
    [2, 0, 1],
    [0, 2, 1],
    [2, 1, 0],
    [1, 0, 2],
];

/// Simplices over vertices in unit coordinates.
#[derive(Clone, Debug, Default)]
pub(super) struct Draft {
    /// Vertices, in the order of their numbers.
    pub(super) points: Vec<Point>,
    /// Corners of each cell: three, or four, of positive volume.
    pub(super) cells: Vec<Vec<u32>>,
}

/// The unit cube of `counts` cells of six tetrahedra each.
pub(super) fn cuboid(counts: [u32; 3]) -> Draft {
    let sides = counts.map(|count| count + 1);
    let number = |[x, y, z]: [u32; 3]| x + sides[0] * (y + sides[1] * z);
    let tetrahedron = |corner: [u32; 3], walk: usize| {
        let mut place = corner;
        let mut cell = vec![number(place)];
        for &axis in WALKS.get(walk).into_iter().flatten() {
            if let Some(step) = place.get_mut(axis) {
                *step += 1;
            }
            cell.push(number(place));
        }
        if walk >= 3 {
            cell.swap(2, 3);
        }
        cell
    };
    let corners = lattice(counts);
    let cells = corners.flat_map(|corner| (0..6).map(move |walk| tetrahedron(corner, walk)));
    Draft {
        cells: cells.collect(),
        points: lattice(sides).map(|place| unit(place, counts)).collect(),
    }
}

/// The unit square of `counts` cells of two triangles each.
pub(super) fn square(counts: [u32; 2]) -> Draft {
    let [across, up] = counts;
    let triangles = |[x, y, _]: [u32; 3]| {
        let below = x + (across + 1) * y;
        let above = below + across + 1;
        [
            vec![below, below + 1, above + 1],
            vec![below, above + 1, above],
        ]
    };
    let points = lattice([across + 1, up + 1, 1]);
    Draft {
        cells: lattice([across, up, 1]).flat_map(triangles).collect(),
        points: points.map(|place| unit(place, [across, up, 1])).collect(),
    }
}

/// The unit disc of rings of triangles, six more in each: the first of a ring are at
/// `start` radians, so that nothing need be symmetric about the axes.
pub(super) fn disc(rings: u32, start: f64) -> Draft {
    let first = |ring: u32| {
        if ring == 0 {
            0
        } else {
            1 + 3 * ring * (ring - 1)
        }
    };
    let number = |ring: u32, step: u32| first(ring) + step % (6 * ring).max(1);
    let mut draft = Draft {
        points: vec![[0.0; 3]],
        cells: Vec::new(),
    };
    for ring in 1..=rings {
        let radius = f64::from(ring) / f64::from(rings);
        for step in 0..6 * ring {
            let angle = start + TAU * f64::from(step) / f64::from(6 * ring);
            draft
                .points
                .push([radius * angle.cos(), radius * angle.sin(), 0.0]);
            let (sector, inner) = (step / ring, step - step / ring);
            let out = [number(ring, step), number(ring, step + 1)];
            draft
                .cells
                .push(vec![number(ring - 1, inner), out[0], out[1]]);
            if step - sector * ring != 0 {
                let behind = number(ring - 1, inner - 1);
                draft
                    .cells
                    .push(vec![behind, out[0], number(ring - 1, inner)]);
            }
        }
    }
    draft
}

fn lattice(counts: [u32; 3]) -> impl Iterator<Item = [u32; 3]> {
    let [across, up, deep] = counts;
    let place = move |i: u32| [i % across, i / across % up, i / (across * up)];
    (0..across * up * deep).map(place)
}

fn unit(place: [u32; 3], counts: [u32; 3]) -> Point {
    let [x, y, z] = place;
    let [across, up, deep] = counts;
    [(x, across), (y, up), (z, deep)].map(|(step, count)| f64::from(step) / f64::from(count))
}

impl Draft {
    /// The middle of some vertices.
    pub(super) fn middle(&self, corners: &[u32]) -> Point {
        let points = corners
            .iter()
            .filter_map(|&one| self.points.get(one as usize));
        let mut sum = [0.0; 3];
        for point in points {
            for (sum, part) in sum.iter_mut().zip(point) {
                *sum += part / corners.len() as f64;
            }
        }
        sum
    }

    /// Facets of one cell only, turned outwards.
    pub(super) fn skin(&self) -> Vec<Vec<u32>> {
        let mut found: BTreeMap<Vec<u32>, (u32, Vec<u32>)> = BTreeMap::new();
        for facet in self.cells.iter().flat_map(|cell| facets(cell)) {
            let mut key = facet.clone();
            key.sort_unstable();
            found.entry(key).or_insert((0, facet)).0 += 1;
        }
        let once = found.into_values().filter(|(count, _)| *count == 1);
        once.map(|(_, facet)| facet).collect()
    }
}

/// Facets of a triangle or a tetrahedron, turned outwards.
fn facets(cell: &[u32]) -> Vec<Vec<u32>> {
    match *cell {
        [a, b, c] => vec![vec![a, b], vec![b, c], vec![c, a]],
        [a, b, c, d] => vec![vec![a, c, b], vec![a, b, d], vec![a, d, c], vec![b, c, d]],
        _ => Vec::new(),
    }
}

/// A mesh with the names of its groups.
#[derive(Clone, Debug)]
pub(super) struct Named {
    /// Vertices at their places.
    pub(super) points: Vec<Point>,
    /// Cells and facets: the name of the group, and the corners.
    pub(super) elements: Vec<(&'static str, Vec<u32>)>,
    /// Corners of a cell.
    pub(super) corners: usize,
}

impl Named {
    /// As MSH 2.2 text.
    pub(super) fn msh(&self) -> String {
        let mut text = String::new();
        // Writing to a string cannot fail.
        let _infallible = self.write(&mut text);
        text
    }

    fn write(&self, out: &mut String) -> fmt::Result {
        let groups = self.groups();
        writeln!(out, "$MeshFormat\n2.2 0 8\n$EndMeshFormat")?;
        writeln!(out, "$PhysicalNames\n{}", groups.len())?;
        for (tag, (name, corners)) in groups.iter().enumerate() {
            writeln!(out, "{} {} \"{name}\"", corners - 1, tag + 1)?;
        }
        writeln!(out, "$EndPhysicalNames\n$Nodes\n{}", self.points.len())?;
        for (index, [x, y, z]) in self.points.iter().enumerate() {
            writeln!(out, "{} {x} {y} {z}", index + 1)?;
        }
        writeln!(out, "$EndNodes\n$Elements\n{}", self.elements.len())?;
        for (index, (name, corners)) in self.elements.iter().enumerate() {
            let tag = groups.iter().position(|group| group.0 == *name);
            let (tag, kind) = (tag.unwrap_or_default() + 1, [0, 15, 1, 2, 4]);
            let kind = kind.get(corners.len()).copied().unwrap_or_default();
            write!(out, "{} {kind} 2 {tag} {tag}", index + 1)?;
            for corner in corners {
                write!(out, " {}", corner + 1)?;
            }
            writeln!(out)?;
        }
        writeln!(out, "$EndElements")
    }

    /// Names with the corners of their elements, in the order of their first ones.
    fn groups(&self) -> Vec<(&'static str, usize)> {
        let mut groups: Vec<(&'static str, usize)> = Vec::new();
        for (name, corners) in &self.elements {
            if !groups.iter().any(|group| group.0 == *name) {
                groups.push((*name, corners.len()));
            }
        }
        groups
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(draft: &Draft, cell: &[u32]) -> f64 {
        let [a, b, c] = [0, 1, 2].map(|local| draft.points[cell[local] as usize]);
        0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))
    }

    #[test]
    fn a_disc_is_covered_once_and_has_its_skin() {
        for rings in [1, 2, 5] {
            let draft = disc(rings, 0.3);
            let areas: Vec<f64> = draft.cells.iter().map(|cell| area(&draft, cell)).collect();
            assert!(areas.iter().all(|area| *area > 0.0));
            let sides = f64::from(6 * rings);
            let polygon = 0.5 * sides * (TAU / sides).sin();
            let all: f64 = areas.iter().sum();
            assert!((all - polygon).abs() < 1e-12, "{all} {polygon}");
            assert_eq!(draft.skin().len() as u32, 6 * rings);
            assert_eq!(draft.cells.len() as u32, 6 * rings * rings);
        }
    }

    #[test]
    fn boxes_and_squares_have_their_cells_and_sides() {
        let draft = cuboid([2, 3, 4]);
        assert_eq!((draft.points.len(), draft.cells.len()), (60, 144));
        assert_eq!(draft.skin().len(), 4 * (6 + 8 + 12));
        let draft = square([3, 2]);
        assert_eq!((draft.points.len(), draft.cells.len()), (12, 12));
        assert!(draft.cells.iter().all(|cell| area(&draft, cell) > 0.0));
        assert_eq!(draft.skin().len(), 10);
    }
}
