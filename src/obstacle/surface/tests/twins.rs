//! Patches beside searches and differences that know nothing of trees and walks.

use super::revolved::{rounded_cylinder, torus};
use super::*;
use crate::obstacle::surface::closest::Part;

/// Vertices and facets.
pub(super) type Facets = (Vec<[f64; 3]>, Vec<[u32; 3]>);

/// The surfaces that twins are compared on.
pub(super) fn surfaces() -> Vec<Facets> {
    vec![
        icosphere(3),
        torus(),
        rounded_cylinder(),
        cuboid([0.5, 0.3, 0.4]),
    ]
}

/// Points within 0.1 of the middles of facets, on both sides.
pub(super) fn points_near(tool: &Triangulated) -> Vec<[f64; 3]> {
    let patches = &tool.geometry.searched.patches;
    let step = (patches.len() / 60).max(1);
    let shifts: Vec<[f64; 3]> = directions(7).map(|d| scale(0.05, d)).collect();
    let near = patches.iter().step_by(step).zip(shifts.iter().cycle());
    near.map(|(patch, shift)| {
        let [a, b, c] = patch.corners;
        let middle = scale(1.0 / 3.0, add(a, add(b, c)));
        scale(tool.geometry.unit, add(middle, *shift))
    })
    .collect()
}

/// The nearest point of all patches, each searched from several of its points.
fn brute_force(tool: &Triangulated, point: [f64; 3]) -> f64 {
    let unit = tool.geometry.unit;
    let x = point.map(|x| x / unit);
    let starts = [
        [1.0 / 3.0; 3],
        [0.8, 0.1, 0.1],
        [0.1, 0.8, 0.1],
        [0.1, 0.1, 0.8],
    ];
    let places = tool
        .geometry
        .searched
        .patches
        .iter()
        .flat_map(|patch| starts.map(|start| patch.closest(x, start).distance));
    unit * places.fold(f64::INFINITY, f64::min)
}

#[test]
fn no_patch_is_nearer_than_the_one_that_is_found() {
    for surface in surfaces() {
        let tool = tool(surface, SMOOTH);
        for point in points_near(&tool) {
            let found = tool.distance(point).distance.abs();
            let least = brute_force(&tool, point);
            assert!((found - least).abs() < 1e-12, "{point:?}: {found} {least}");
        }
    }
}

#[test]
fn the_curvature_is_the_slope_of_the_normal() {
    let mut seen = 0;
    for surface in surfaces() {
        let tool = tool(surface, SMOOTH);
        let place = |point: [f64; 3]| {
            let searched = &tool.geometry.searched;
            let x = point.map(|x| x / tool.geometry.unit);
            let at = searched.nearest(x, &searched.nearest_facet(x));
            (at.facet, at.foot.part)
        };
        for point in points_near(&tool) {
            let here = tool.distance(point);
            let step = 1e-5 * here.distance.abs();
            let moved = |axis: usize, by: f64| {
                let mut there = point;
                there[axis] += by;
                there
            };
            // From patch to patch the normal jumps by as much as normals are wrong.
            let beside = (0..3).flat_map(|axis| [moved(axis, step), moved(axis, -step)]);
            if here.distance.abs() < 1e-3 || beside.into_iter().any(|p| place(p) != place(point)) {
                continue;
            }
            // On smooth edges the normal is a mean of two patches'.
            if matches!(place(point).1, Part::Edge(_) | Part::Corner(_)) && tool.is_smooth() {
                continue;
            }
            seen += 1;
            for axis in 0..3 {
                let [up, down] = [step, -step].map(|by| tool.distance(moved(axis, by)).normal);
                for i in 0..3 {
                    let slope = (up[i] - down[i]) / (2.0 * step);
                    let size = 1.0 + 1.0 / here.distance.abs();
                    let error = (slope - here.curvature[i][axis]).abs();
                    assert!(error < 1e-5 * size, "{point:?} {i}{axis}: {error:e}");
                }
            }
        }
    }
    assert!(seen > 100, "{seen}");
}

#[test]
fn what_is_found_depends_neither_on_the_threads_nor_on_the_points_before() {
    let made = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        let pool = pool.build().expect("a pool");
        pool.install(|| tool(icosphere(5), SMOOTH))
    };
    let [one, three] = [1, 3].map(made);
    let points: Vec<[f64; 3]> = (0..4000)
        .map(|i| {
            let t = f64::from(i);
            [(0.37 * t).sin(), (1.7 * t).cos(), (0.011 * t).sin()]
        })
        .collect();
    let mut batch = vec![Contact::default(); points.len()];
    three.probe(&points, Derivatives::Curvature, &mut batch);
    for (contact, &point) in batch.iter().zip(&points) {
        assert_eq!(*contact, one.distance(point));
    }
}

#[test]
fn tools_of_one_surface_share_their_patches_at_any_scale() {
    let (vertices, facets) = icosphere(2);
    let surface = Arc::new(TriangulatedSurface::new(vertices, facets).expect("closed"));
    let made = |scale: f64, length: f64| {
        let shape = SurfaceShape {
            surface: Arc::clone(&surface),
            scale,
            between: SMOOTH,
        };
        Triangulated::new(&shape, length).expect("a tool")
    };
    let [first, second] = [made(1.0, 1.0), made(3.0, 0.7)];
    assert!(Arc::ptr_eq(&first.geometry, &second.geometry));
    let size = 3.0 / 0.7;
    let point = [0.3, 0.9, 0.8];
    let [small, large] = [first.distance(point), second.distance(scale(size, point))];
    assert!((large.distance - size * small.distance).abs() < 1e-14);
    assert!(norm(sub(large.normal, small.normal)) < 1e-14);
    for (a, b) in small
        .curvature
        .iter()
        .flatten()
        .zip(large.curvature.iter().flatten())
    {
        assert!((a - size * b).abs() < 1e-12);
    }
    let held = first.inner_ball().expect("a ball").radius;
    assert!((second.inner_ball().expect("a ball").radius - size * held).abs() < 1e-14);
}
