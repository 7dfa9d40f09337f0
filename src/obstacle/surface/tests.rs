use std::collections::HashMap;
use std::sync::Arc;

use proptest::prelude::*;

use super::*;
use crate::geometry::vector3::{add, dot, norm, normalised, scale, sub};
use crate::obstacle::{Contact, Derivatives, Obstacle, Shape};

mod boxes;
mod damaged;
mod joined;
mod revolved;
mod searches;
mod twins;

/// An icosahedron divided `levels` times, its vertices on the unit sphere.
fn icosphere(levels: usize) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    let t = 0.5 * (1.0 + 5.0_f64.sqrt());
    let raw = [
        [-1.0, t, 0.0],
        [1.0, t, 0.0],
        [-1.0, -t, 0.0],
        [1.0, -t, 0.0],
        [0.0, -1.0, t],
        [0.0, 1.0, t],
        [0.0, -1.0, -t],
        [0.0, 1.0, -t],
        [t, 0.0, -1.0],
        [t, 0.0, 1.0],
        [-t, 0.0, -1.0],
        [-t, 0.0, 1.0],
    ];
    let mut vertices: Vec<[f64; 3]> = raw.map(|v| normalised(v).expect("a vertex")).to_vec();
    let mut facets: Vec<[u32; 3]> = vec![
        [0, 11, 5],
        [0, 5, 1],
        [0, 1, 7],
        [0, 7, 10],
        [0, 10, 11],
        [1, 5, 9],
        [5, 11, 4],
        [11, 10, 2],
        [10, 7, 6],
        [7, 1, 8],
        [3, 9, 4],
        [3, 4, 2],
        [3, 2, 6],
        [3, 6, 8],
        [3, 8, 9],
        [4, 9, 5],
        [2, 4, 11],
        [6, 2, 10],
        [8, 6, 7],
        [9, 8, 1],
    ];
    for _ in 0..levels {
        let mut middles = HashMap::new();
        let mut next = Vec::with_capacity(4 * facets.len());
        for [a, b, c] in facets {
            let mut middle = |i: u32, j: u32| {
                *middles.entry((i.min(j), i.max(j))).or_insert_with(|| {
                    let sum = add(vertices[i as usize], vertices[j as usize]);
                    vertices.push(normalised(sum).expect("a middle"));
                    vertices.len() as u32 - 1
                })
            };
            let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
            next.extend([[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]);
        }
        facets = next;
    }
    (vertices, facets)
}

/// A box of the given half sizes, two facets a side.
fn cuboid(half: [f64; 3]) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    let corner = |index: u32| -> [f64; 3] {
        std::array::from_fn(|i| half[i] * if index >> i & 1 == 1 { 1.0 } else { -1.0 })
    };
    let sides: [[u32; 4]; 6] = [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 4, 6, 2],
        [1, 3, 7, 5],
    ];
    let facets = sides
        .iter()
        .flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]);
    ((0..8).map(corner).collect(), facets.collect())
}

fn tool(
    (vertices, facets): (Vec<[f64; 3]>, Vec<[u32; 3]>),
    between: Interpolation,
) -> Triangulated {
    let surface = Arc::new(TriangulatedSurface::new(vertices, facets).expect("closed"));
    let shape = SurfaceShape {
        surface,
        scale: 1.0,
        between,
    };
    Triangulated::new(&shape, 1.0).expect("a tool")
}

const SMOOTH: Interpolation = Interpolation::Patches(0.52);

/// Deterministic directions all around.
fn directions(count: u32) -> impl Iterator<Item = [f64; 3]> {
    (0..count).map(move |i| {
        let z = 1.0 - (2.0 * f64::from(i) + 1.0) / f64::from(count);
        let around = 2.399_963_229_728_653 * f64::from(i);
        let r = (1.0 - z * z).sqrt();
        [r * around.cos(), r * around.sin(), z]
    })
}

/// Largest errors of distance, normal and curvature near a unit sphere.
fn sphere_errors(tool: &Triangulated) -> [f64; 3] {
    let mut errors = [0.0_f64; 3];
    for direction in directions(4000) {
        for height in [-0.03, 0.0, 0.2] {
            let found = tool.distance(scale(1.0 + height, direction));
            let trace: f64 = (0..3).map(|i| found.curvature[i][i]).sum();
            errors[0] = errors[0].max((found.distance - height).abs());
            errors[1] = errors[1].max(norm(sub(found.normal, direction)));
            errors[2] = errors[2].max((trace - 2.0 / (1.0 + height)).abs());
        }
    }
    errors
}

#[test]
fn patches_over_a_sphere_are_a_thousand_times_nearer_than_facets() {
    let [distance, normal, curvature] = sphere_errors(&tool(icosphere(4), SMOOTH));
    assert!(distance < 4e-7, "{distance:e}");
    assert!(normal < 6e-5, "{normal:e}");
    assert!(curvature < 0.02, "{curvature:e}");
    let [coarse, ..] = sphere_errors(&tool(icosphere(3), SMOOTH));
    assert!(
        coarse / distance > 12.0,
        "order four: {coarse:e} {distance:e}"
    );
    let [flat, ..] = sphere_errors(&tool(icosphere(4), Interpolation::Facets));
    assert!(flat > 1e-3, "{flat:e}");
}

#[test]
fn a_box_of_facets_is_the_analytic_box() {
    let half = [1.0, 0.6, 0.4];
    let analytic = Shape::Box {
        centre: [0.0; 3],
        half_sizes: half,
        rounding: 0.0,
    };
    let analytic = analytic.build(1.0).expect("a box");
    for between in [SMOOTH, Interpolation::Facets] {
        let tool = tool(cuboid(half), between);
        assert!(!tool.is_smooth());
        assert_eq!(tool.sharpest_radius(), Some(0.0));
        for direction in directions(500) {
            for length in [0.3, 0.9, 1.3, 2.0] {
                let point = scale(length, direction);
                let (found, exact) = (tool.distance(point), analytic.distance(point));
                assert!((found.distance - exact.distance).abs() < 1e-14, "{point:?}");
                assert!(norm(sub(found.normal, exact.normal)) < 1e-7, "{point:?}");
            }
        }
    }
}

#[test]
fn the_largest_ball_lies_inside() {
    let tool = tool(icosphere(2), SMOOTH);
    let ball = tool.inner_ball().expect("a ball");
    assert!(ball.radius > 0.75 && norm(ball.centre) < 0.25, "{ball:?}");
    let sharpest = tool.sharpest_radius().expect("convex");
    assert!((sharpest - 1.0).abs() < 0.05, "{sharpest}");
}

/// The nearest point among all facets, without the tree.
fn brute_force(tool: &Triangulated, point: [f64; 3]) -> f64 {
    let plain = |[a, b, c]: [[f64; 3]; 3]| {
        let patch = patch::Patch {
            corners: [a, b, c],
            bends: [[0.0; 3]; 3],
        };
        patch.closest(point, [1.0 / 3.0; 3]).distance
    };
    let facets = 0..tool.surface().facets().len();
    let places = facets.map(|facet| plain(tool.surface().corners(facet)));
    places.fold(f64::INFINITY, f64::min)
}

proptest! {
    #[test]
    fn the_tree_finds_the_nearest_facet(point in prop::array::uniform3(-2.0..2.0)) {
        let tool = tool(icosphere(1), Interpolation::Facets);
        let found = tool.distance(point).distance.abs();
        prop_assert!((found - brute_force(&tool, point)).abs() < 1e-14);
    }

    #[test]
    fn the_normal_is_the_slope_of_the_distance(point in prop::array::uniform3(-1.5..1.5)) {
        let tool = tool(icosphere(2), SMOOTH);
        prop_assume!(norm(point) > 0.5);
        let here = tool.distance(point);
        // Across the borders of patches the normal jumps by as much as normals are wrong.
        for axis in 0..3 {
            let moved = |by: f64| {
                let mut there = point;
                there[axis] += by;
                tool.distance(there).distance
            };
            let slope = (moved(1e-6) - moved(-1e-6)) / 2e-6;
            prop_assert!((slope - here.normal[axis]).abs() < 2e-3);
        }
        prop_assert!((norm(here.normal) - 1.0).abs() < 1e-12);
        let foot = sub(point, scale(here.distance, here.normal));
        prop_assert!(tool.distance(foot).distance.abs() < 1e-5);
    }

    #[test]
    fn any_numbers_make_a_surface_or_a_fault(
        vertices in prop::collection::vec(prop::array::uniform3(-1.0..1.0), 0..6),
        facets in prop::collection::vec(prop::array::uniform3(0_u32..7), 0..8),
    ) {
        if let Ok(surface) = TriangulatedSurface::new(vertices, facets) {
            let shape = SurfaceShape { surface: surface.into(), scale: 1.0, between: SMOOTH };
            let tool = Triangulated::new(&shape, 1.0).expect("a tool");
            prop_assert!(tool.distance([0.1, 0.2, 0.3]).distance.is_finite());
        }
    }
}

#[test]
fn a_batch_has_the_bits_of_its_points() {
    let tool = tool(icosphere(2), SMOOTH);
    let points: Vec<[f64; 3]> = directions(50).map(|d| scale(1.01, d)).collect();
    let mut out = vec![Contact::default(); points.len()];
    tool.probe(&points, Derivatives::Curvature, &mut out);
    for (contact, &point) in out.iter().zip(&points) {
        assert_eq!(*contact, tool.distance(point));
    }
}

#[test]
fn faults_are_named_with_their_facet() {
    let (vertices, facets) = cuboid([1.0; 3]);
    let refused = |vertices: &[[f64; 3]], facets: &[[u32; 3]]| {
        TriangulatedSurface::new(vertices.to_vec(), facets.to_vec()).expect_err("refused")
    };
    assert_eq!(refused(&vertices, &[]), SurfaceError::Empty);
    let open = refused(&vertices, &facets[..11]);
    assert!(matches!(open, SurfaceError::Open { .. }), "{open}");
    let mut turned = facets.clone();
    turned[3].swap(0, 1);
    let turned = refused(&vertices, &turned);
    assert!(
        matches!(turned, SurfaceError::Orientation { facet: 3.., .. }),
        "{turned}"
    );
    let mut flat = facets.clone();
    flat[5] = [0, 1, 1];
    let flat = refused(&vertices, &flat);
    assert!(matches!(flat, SurfaceError::Open { .. }), "{flat}");
    let mut alike = vertices.clone();
    alike[3] = alike[1];
    let flat = refused(&alike, &facets);
    assert!(matches!(flat, SurfaceError::Degenerate { .. }), "{flat}");
    let inside_out: Vec<[u32; 3]> = facets.iter().map(|[a, b, c]| [*a, *c, *b]).collect();
    assert_eq!(refused(&vertices, &inside_out), SurfaceError::InsideOut);
    let mut broken = vertices.clone();
    broken[4][1] = f64::NAN;
    assert_eq!(
        refused(&broken, &facets),
        SurfaceError::NotFinite { vertex: 4 }
    );
    let mut beyond = facets;
    beyond[7][2] = 99;
    let beyond = refused(&vertices, &beyond);
    assert_eq!(beyond.to_string(), "facet 7 names vertex 99, there are 8");
}

#[test]
fn an_edge_has_the_curvature_of_a_line_and_a_corner_that_of_a_point() {
    let tool = tool(cuboid([1.0; 3]), SMOOTH);
    let sum = |point: [f64; 3]| {
        let found = tool.distance(point);
        assert!(dot(found.normal, found.normal) > 0.99);
        (0..3).map(|i| found.curvature[i][i]).sum::<f64>()
    };
    assert!((sum([1.3, 1.4, 0.2]) - 2.0).abs() < 1e-12);
    assert!((sum([1.1, 1.2, 1.2]) - 2.0 / 0.3).abs() < 1e-12);
    assert!(sum([0.2, 0.3, 1.5]).abs() < 1e-12);
}
