//! What tools from files look like: triangulations as they are, heights by their nodes, the zero
//! set of distances by tetrahedra in the cells.
//!
//! Of large grids some of the nodes are drawn, 65 an axis at most. Cost: linear in what is drawn.

use crate::formats::grid::GridFile;
use crate::formats::stl::SurfaceFile;
use crate::formats::vtp::{
    BoundingBox, Outline, Pose, Triangulation, Vector, add, cross, dot, scale, subtract,
};

/// Cells of a grid along an axis that are drawn.
const MOST_CELLS: usize = 64;

/// The six tetrahedra of a cube, by corners whose bits are their places along the axes.
const TETRAHEDRA: [[usize; 4]; 6] = [
    [0, 1, 3, 7],
    [0, 1, 5, 7],
    [0, 2, 3, 7],
    [0, 2, 6, 7],
    [0, 4, 5, 7],
    [0, 4, 6, 7],
];

/// What of a moved tool from a file is in a box; its reference point is the origin.
pub fn file_drawn_near(surface: &Triangulation, pose: &Pose, near: &BoundingBox) -> Triangulation {
    let outline = Outline {
        surface: surface.clone(),
        reference: [0.0; 3],
    };
    outline.posed(pose).within(near)
}

/// The facets of a triangulation times `factor`.
pub fn facets(surface: &SurfaceFile, factor: f64) -> Triangulation {
    let points = surface.vertices.iter().map(|point| scale(*point, factor));
    let triangles = surface.facets.iter().map(|facet| facet.map(i64::from));
    Triangulation {
        points: points.collect(),
        triangles: triangles.collect(),
    }
}

/// The surface of a grid of two or three axes; nothing of another.
pub fn grid_surface(grid: &GridFile) -> Triangulation {
    match grid.counts.len() {
        2 => heights(grid),
        3 => zero_set(grid),
        _ => Triangulation::default(),
    }
}

/// Nodes of an axis that are drawn, the first and the last among them.
fn drawn_nodes(count: usize) -> Vec<usize> {
    let last = count.saturating_sub(1);
    let step = last.div_ceil(MOST_CELLS).max(1);
    (0..last).step_by(step).chain([last]).collect()
}

/// Place and value of a node.
fn node(grid: &GridFile, indices: &[usize]) -> (Vec<f64>, f64) {
    let mut row = 0;
    let mut place = Vec::with_capacity(indices.len());
    let axes = grid.counts.iter().zip(&grid.origin).zip(&grid.spacing);
    for (index, ((count, origin), spacing)) in indices.iter().zip(axes) {
        row = row * count + index;
        place.push(origin + *index as f64 * spacing);
    }
    (place, grid.values.get(row).copied().unwrap_or_default())
}

fn heights(grid: &GridFile) -> Triangulation {
    let axes: Vec<Vec<usize>> = grid
        .counts
        .iter()
        .map(|count| drawn_nodes(*count))
        .collect();
    let [first, second] = &axes[..] else {
        return Triangulation::default();
    };
    let mut drawn = Triangulation::default();
    let width = second.len() as i64;
    for (row, i) in (0..).zip(first) {
        for (column, j) in (0..).zip(second) {
            let (place, height) = node(grid, &[*i, *j]);
            if let [x, y] = place[..] {
                drawn.points.push([x, y, height]);
            }
            if row > 0 && column > 0 {
                let here: i64 = row * width + column;
                let (left, below) = (here - 1, here - width);
                drawn.triangles.push([below - 1, left, here]);
                drawn.triangles.push([below - 1, here, below]);
            }
        }
    }
    drawn
}

fn zero_set(grid: &GridFile) -> Triangulation {
    let axes: Vec<Vec<usize>> = grid
        .counts
        .iter()
        .map(|count| drawn_nodes(*count))
        .collect();
    let [first, second, third] = &axes[..] else {
        return Triangulation::default();
    };
    let mut drawn = Triangulation::default();
    for i in first.windows(2) {
        for j in second.windows(2) {
            for k in third.windows(2) {
                add_cell(grid, [i, j, k], &mut drawn);
            }
        }
    }
    drawn
}

/// Adds the surface in one cell, whose ends along each axis are given.
fn add_cell(grid: &GridFile, ends: [&[usize]; 3], drawn: &mut Triangulation) {
    let corner = |bits: usize| {
        let axis = |k: usize| {
            let end = ends.get(k).and_then(|ends| ends.get(bits >> k & 1));
            end.copied().unwrap_or_default()
        };
        let (place, value) = node(grid, &[axis(0), axis(1), axis(2)]);
        (Vector::try_from(place).unwrap_or_default(), value)
    };
    let corners: [(Vector, f64); 8] = std::array::from_fn(corner);
    let inside = corners.iter().filter(|(_, value)| *value < 0.0).count();
    if inside == 0 || inside == corners.len() {
        return;
    }
    for tetrahedron in TETRAHEDRA {
        let corners = tetrahedron.iter().filter_map(|&corner| corners.get(corner));
        let (inner, outer): (Vec<_>, Vec<_>) = corners.partition(|(_, value)| *value < 0.0);
        add_polygon(&inner, &outer, drawn);
    }
}

/// Adds the triangle, or the two, between the corners inside and outside.
fn add_polygon(inner: &[(Vector, f64)], outer: &[(Vector, f64)], drawn: &mut Triangulation) {
    let between =
        |(a, u): (Vector, f64), (b, v): (Vector, f64)| add(a, scale(subtract(b, a), u / (u - v)));
    let polygon: Vec<Vector> = match (inner, outer) {
        ([one], [a, b, c]) | ([a, b, c], [one]) => {
            [a, b, c].map(|other| between(*one, *other)).to_vec()
        }
        ([a, b], [c, d]) => [(a, c), (a, d), (b, d), (b, c)]
            .map(|(from, to)| between(*from, *to))
            .to_vec(),
        _ => return,
    };
    let (Some((from, _)), Some((to, _))) = (inner.first(), outer.first()) else {
        return;
    };
    let [p, q, r, ..] = polygon[..] else {
        return;
    };
    // From outside all are seen anticlockwise.
    let is_outwards = dot(cross(subtract(q, p), subtract(r, p)), subtract(*to, *from)) >= 0.0;
    let start = drawn.points.len() as i64;
    for next in 1..polygon.len() as i64 - 1 {
        let (second, third) = if is_outwards {
            (next, next + 1)
        } else {
            (next + 1, next)
        };
        drawn.triangles.push([start, start + second, start + third]);
    }
    drawn.points.extend(polygon);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ball(count: usize) -> GridFile {
        let spacing = 3.0 / (count - 1) as f64;
        let mut grid = GridFile {
            counts: vec![count; 3],
            origin: vec![-1.5; 3],
            spacing: vec![spacing; 3],
            values: Vec::new(),
        };
        let at = |i: usize| -1.5 + i as f64 * spacing;
        for i in 0..count.pow(3) {
            let [x, y, z] = [i / (count * count), i / count % count, i % count].map(at);
            grid.values.push(x.hypot(y).hypot(z) - 1.0);
        }
        grid
    }

    /// Volume within a closed triangulation.
    fn volume(surface: &Triangulation) -> f64 {
        let corner = |index: i64| surface.points[index as usize];
        let part = |triangle: &[i64; 3]| {
            let [a, b, c] = triangle.map(corner);
            dot(a, cross(b, c)) / 6.0
        };
        surface.triangles.iter().map(part).sum()
    }

    #[test]
    fn distances_are_drawn_as_a_closed_surface_seen_from_outside() {
        let whole = 4.0 / 3.0 * std::f64::consts::PI;
        for (count, tolerance) in [(31, 1e-2), (130, 3e-3)] {
            let drawn = grid_surface(&ball(count));
            assert!(
                (volume(&drawn) / whole - 1.0).abs() < tolerance,
                "{}",
                volume(&drawn)
            );
            for [x, y, z] in drawn.points {
                assert!((x.hypot(y).hypot(z) - 1.0).abs() < 5e-3);
            }
        }
    }

    #[test]
    fn heights_are_drawn_at_their_nodes() {
        let grid = GridFile {
            counts: vec![3, 2],
            origin: vec![1.0, 2.0],
            spacing: vec![0.5, 2.0],
            values: vec![0.0, 1.0, 2.0, 3.0, 4.0, 5.0],
        };
        let drawn = grid_surface(&grid);
        assert_eq!((drawn.points.len(), drawn.triangles.len()), (6, 4));
        let off = subtract(drawn.points[3], [1.5, 4.0, 3.0]);
        assert!(dot(off, off) < 1e-28);
        for triangle in &drawn.triangles {
            let [a, b, c] = triangle.map(|index| drawn.points[index as usize]);
            assert!(cross(subtract(b, a), subtract(c, a))[2] > 0.0);
        }
        let large = GridFile {
            counts: vec![1000, 4],
            values: vec![0.0; 4000],
            ..grid
        };
        assert_eq!(grid_surface(&large).points.len(), 64 * 4);
    }

    #[test]
    fn facets_are_scaled_and_posed_about_the_origin() {
        let file = SurfaceFile {
            vertices: vec![[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            facets: vec![[0, 1, 2]],
        };
        let surface = facets(&file, 2.0);
        let pose = Pose {
            translation: [0.0, 0.0, -1.0],
            rotation: [0.0, 0.0, std::f64::consts::PI],
        };
        let near = BoundingBox::of(&[[-9.0; 3], [9.0; 3]]);
        let drawn = file_drawn_near(&surface, &pose, &near);
        let expected = [[-2.0, 0.0, -1.0], [0.0, -2.0, -1.0], [0.0, 0.0, 1.0]];
        for (point, expected) in drawn.points.iter().zip(expected) {
            let off = subtract(*point, expected);
            assert!(dot(off, off) < 1e-28);
        }
        assert_eq!(drawn.triangles, [[0, 1, 2]]);
    }
}
