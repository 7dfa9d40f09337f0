//! Surfaces of revolution as programs write them: a torus of even facets, and a cylinder with
//! rounded rims whose caps are fans of slivers and whose side is one long strip.

use std::f64::consts::{FRAC_PI_2, TAU};

use super::*;

/// Turns a profile (radius, height), downwards, about z in `around` parts; its ends are closed
/// with each other or, `capped`, each by a fan of its own points.
fn revolved(profile: &[[f64; 2]], around: u32, capped: bool) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    let mut vertices = Vec::new();
    for &[radius, height] in profile {
        for i in 0..around {
            let angle = TAU * (f64::from(i) + 0.37) / f64::from(around);
            vertices.push([radius * angle.cos(), radius * angle.sin(), height]);
        }
    }
    let rows = profile.len() as u32;
    let mut facets = Vec::new();
    for row in 0..rows - u32::from(capped) {
        let [here, below] = [row, (row + 1) % rows].map(|row| row * around);
        for i in 0..around {
            let next = (i + 1) % around;
            facets.push([here + i, below + i, below + next]);
            facets.push([here + i, below + next, here + next]);
        }
    }
    if capped {
        let last = (rows - 1) * around;
        for i in 1..around - 1 {
            facets.push([0, i, i + 1]);
            facets.push([last, last + i + 1, last + i]);
        }
    }
    (vertices, facets)
}

/// A torus of 5,120 facets.
pub(super) fn torus() -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    let profile: Vec<[f64; 2]> = (0..40)
        .map(|i| {
            let angle = -TAU * f64::from(i) / 40.0;
            [0.35 + 0.25 * angle.cos(), 0.25 * angle.sin()]
        })
        .collect();
    revolved(&profile, 64, false)
}

/// A cylinder of radius 0.4 and half height 0.3 with rims of radius 0.05.
pub(super) fn rounded_cylinder() -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    let rim = |i: u32, sign: f64| {
        let angle = FRAC_PI_2 * f64::from(i) / 8.0;
        let (sin, cos) = if sign > 0.0 {
            angle.sin_cos()
        } else {
            (angle.cos(), angle.sin())
        };
        [0.35 + 0.05 * sin, sign * (0.25 + 0.05 * cos)]
    };
    let upper = (0..=8).map(|i| rim(i, 1.0));
    let profile: Vec<[f64; 2]> = upper.chain((0..=8).map(|i| rim(i, -1.0))).collect();
    revolved(&profile, 96, true)
}

/// Largest error of the distance near the surface.
fn worst(tool: &Triangulated, exact: impl Fn([f64; 3]) -> f64, near: &[[f64; 3]]) -> f64 {
    let error = |&point: &[f64; 3]| (tool.distance(point).distance - exact(point)).abs();
    near.iter().map(error).fold(0.0, f64::max)
}

/// Points around the origin whose exact distance is small.
fn near(exact: impl Fn([f64; 3]) -> f64) -> Vec<[f64; 3]> {
    let mut points = Vec::new();
    for direction in directions(400) {
        for step in 1..60 {
            let point = scale(0.02 * f64::from(step), direction);
            if exact(point).abs() < 0.02 {
                points.push(point);
            }
        }
    }
    points
}

#[test]
fn patches_over_a_torus_know_that_its_curvature_changes() {
    let exact = |[x, y, z]: [f64; 3]| (x.hypot(y) - 0.35).hypot(z) - 0.25;
    let tool = tool(torus(), SMOOTH);
    assert!(tool.is_smooth());
    let error = worst(&tool, exact, &near(exact));
    assert!(error < 1.2e-5, "{error:e}");
}

#[test]
fn patches_over_a_rounded_cylinder_are_nearer_than_its_facets() {
    let exact = |[x, y, z]: [f64; 3]| {
        let (r, h) = (x.hypot(y) - 0.35, z.abs() - 0.25);
        r.max(0.0).hypot(h.max(0.0)) + r.max(h).min(0.0) - 0.05
    };
    let surface = rounded_cylinder();
    let points = near(exact);
    let patches = tool(surface.clone(), SMOOTH);
    assert!(!patches.is_smooth(), "where the side meets a rim");
    let smooth = worst(&patches, exact, &points);
    let flat = worst(&tool(surface, Interpolation::Facets), exact, &points);
    assert!(smooth < 1.3e-4, "{smooth:e}");
    assert!(smooth < 0.4 * flat, "{smooth:e} {flat:e}");
}
