//! Outlines of known patches: a disc, a ring, a whole surface, an interval.

use super::*;
use crate::formats::mesh::MeshGroup;
use crate::formats::vtu::unique_edges;

/// The square [-1, 1]^2 of `n` times `n` cells under the tip of a pyramid far below.
fn square(n: u32) -> MeshFile {
    let at = |i: u32| 2.0 * f64::from(i) / f64::from(n) - 1.0;
    let rows = (0..=n).flat_map(|i| (0..=n).map(move |j| (i, j)));
    let mut coordinates: Vec<[f64; 3]> = rows.map(|(i, j)| [at(i), at(j), 0.0]).collect();
    coordinates.push([0.0, 0.0, -10.0]);
    let vertex = |i: u32, j: u32| i * (n + 1) + j;
    let cells = (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
    let facets: Vec<u32> = cells
        .flat_map(|(i, j)| {
            let [a, b] = [vertex(i, j), vertex(i + 1, j)];
            let [c, d] = [vertex(i + 1, j + 1), vertex(i, j + 1)];
            [a, b, c, a, c, d]
        })
        .collect();
    let tip = (n + 1) * (n + 1);
    let (faces, _) = facets.as_chunks::<3>();
    MeshFile {
        vertices_per_cell: 4,
        cells: faces.iter().flat_map(|&[a, b, c]| [a, b, c, tip]).collect(),
        groups: vec![top(2, facets.len() / 3)],
        coordinates,
        facets,
        curved: Vec::new(),
        warnings: Vec::new(),
    }
}

fn top(dimension: usize, members: usize) -> MeshGroup {
    MeshGroup {
        name: "top".to_owned(),
        dimension,
        members: (0..members as u32).collect(),
    }
}

/// The outline on a body that has moved by 1 along z, of a pressure with these coefficients.
fn outlined(mesh: &MeshFile, is_linear: bool, coefficient: fn([f64; 3]) -> f64) -> PatchOutline {
    let points = &mesh.coordinates;
    let grid = Grid::new(mesh.vertices_per_cell, points, &mesh.cells).unwrap();
    let (nodes, _) = grid.points().as_chunks::<3>();
    let own: Vec<f64> = nodes.iter().map(|&x| coefficient(x)).collect();
    let mut values = own[..points.len()].to_vec();
    if !is_linear {
        let edges = unique_edges(mesh.vertices_per_cell, &mesh.cells).into_iter();
        values.extend(
            edges
                .zip(&own[points.len()..])
                .map(|((a, b), middle)| 0.25 * (own[a as usize] + own[b as usize]) + 0.5 * middle),
        );
    }
    let moved = [0.0, 0.0, 1.0].repeat(nodes.len());
    let surface = PatchSurface::new(mesh, &["top".to_owned()]);
    surface.outline(&grid, &moved, &values)
}

fn disc([x, y, z]: [f64; 3]) -> f64 {
    (0.25 - x * x - y * y - z * z).max(0.0)
}

fn ring([x, y, z]: [f64; 3]) -> f64 {
    let square = x * x + y * y + z * z;
    ((0.49 - square) * (square - 0.09)).max(0.0)
}

/// Largest distance of a line from the circle about the origin.
fn off(outline: &PatchOutline, line: usize, radius: f64) -> f64 {
    let points = outline.lines[line]
        .iter()
        .map(|&at| outline.points[at as usize]);
    let far = points.map(|[x, y, z]| {
        assert!((z - 1.0).abs() < 1e-12, "the body has moved");
        (x.hypot(y) - radius).abs()
    });
    far.fold(0.0, f64::max)
}

#[test]
fn a_disc_has_one_closed_line_within_half_an_edge_of_the_circle() {
    // Half the longest edge, and half of that with quadratic pressures.
    let half = 0.5 * 2.0_f64.sqrt() * 0.1;
    for (is_linear, within) in [(true, half), (false, 0.5 * half)] {
        let found = outlined(&square(20), is_linear, disc);
        assert_eq!(found.lines.len(), 1, "{is_linear}");
        assert_eq!(found.lines[0].first(), found.lines[0].last());
        assert!(off(&found, 0, 0.5) < within, "{is_linear}");
    }
}

#[test]
fn a_ring_has_a_line_outside_and_one_around_its_hole() {
    for is_linear in [true, false] {
        let found = outlined(&square(20), is_linear, ring);
        assert_eq!(found.lines.len(), 2);
        let worst = [0, 1].map(|line| off(&found, line, 0.7).min(off(&found, line, 0.3)));
        assert!(worst.iter().all(|worst| *worst < 0.071), "{worst:?}");
        let inner = (0..2).filter(|&line| off(&found, line, 0.3) < 0.071);
        assert_eq!(inner.count(), 1);
    }
}

#[test]
fn where_the_surface_ends_the_patch_ends() {
    let all = outlined(&square(4), false, |[_, _, z]| f64::from(u8::from(z > -1.0)));
    assert_eq!(all.lines.len(), 1);
    // Eight halves of sides along each of four sides.
    assert_eq!((all.lines[0].len(), all.points.len()), (33, 32));
    let length: f64 = all.lines[0]
        .windows(2)
        .map(|pair| {
            let [[x, y, _], [u, v, _]] = [pair[0], pair[1]].map(|at| all.points[at as usize]);
            (x - u).hypot(y - v)
        })
        .sum();
    assert!((length - 8.0).abs() < 1e-12, "{length}");
    let nowhere = outlined(&square(4), false, |_| 0.0);
    assert_eq!(nowhere, PatchOutline::default());
}

#[test]
fn a_patch_in_the_plane_has_ends() {
    let at = |i: u32| f64::from(i) / 10.0;
    let mut coordinates: Vec<[f64; 3]> = (0..=10).map(|i| [at(i), 0.0, 0.0]).collect();
    coordinates.push([0.5, -1.0, 0.0]);
    let facets: Vec<u32> = (0..10).flat_map(|i| [i, i + 1]).collect();
    let mesh = MeshFile {
        vertices_per_cell: 3,
        cells: (0..10).flat_map(|i| [11, i + 1, i]).collect(),
        groups: vec![top(1, 10)],
        coordinates,
        facets,
        curved: Vec::new(),
        warnings: Vec::new(),
    };
    let pressure = |[x, y, _]: [f64; 3]| if y < 0.0 { 0.0 } else { (x - 0.33).max(0.0) };
    for (is_linear, first) in [(true, 0.35), (false, 0.325)] {
        let found = outlined(&mesh, is_linear, pressure);
        assert_eq!(found.lines, [vec![0], vec![1]]);
        let ends = [0, 1].map(|end: usize| found.points[end][0]);
        assert!((ends[0] - first).abs() < 1e-12, "{ends:?}");
        assert!((ends[1] - 1.0).abs() < 1e-12, "{ends:?}");
    }
}
