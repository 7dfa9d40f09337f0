//! The curvature without what held gaps cancel.

use super::*;
use crate::contact::area_change::Pressures;
use crate::contact::curvature_where_held;

/// x^T K x of both curvatures of a face under uneven pressure.
fn energies(sample: &Sample, internal: &[f64], closed: f64, x: &[f64]) -> [f64; 2] {
    let plane = HalfSpace::new([0.0, 0.0, SCALE], [0.0, 0.0, -1.0]).expect("a half-space");
    let count = sample.surface.multipliers();
    let contact: Vec<f64> = (0..count).map(|m| 1.0 + 0.3 * m as f64).collect();
    let closed = vec![closed; count];
    let pressures = Pressures {
        contact: &contact,
        internal,
        closed: &closed,
    };
    let held = vec![false; sample.displacement.len()];
    let body = sample.body(&sample.displacement);
    let whole = curvature(&body, &[(&sample.surface, &plane, &contact[..])], &held);
    let rest = curvature_where_held(&body, &[(&sample.surface, &plane, pressures)], &held);
    [whole, rest].map(|matrix| {
        let mut product = vec![0.0; x.len()];
        matrix.apply(x, &mut product, &mut Workspace::new());
        dot(x, &product)
    })
}

#[test]
fn what_a_held_gap_cancels_is_nothing_along_the_plane() {
    let mut sample = solid().quadratic().finite();
    // The face is closed: it lies in the plane.
    let nodes = sample.displacement.chunks_exact_mut(3);
    nodes.for_each(|node| node[2] = 0.0);
    let internal: Vec<f64> = (0..sample.space.vertices).map(|v| 0.7 * v as f64).collect();
    let (_, mut along) = sample.moved(0.0);
    let [whole, rest] = energies(&sample, &internal, 1.0, &along);
    assert!((whole - rest).abs() > 1e-3 * whole.abs(), "{whole} {rest}");
    along.chunks_exact_mut(3).for_each(|node| node[2] = 0.0);
    let [whole, rest] = energies(&sample, &internal, 1.0, &along);
    assert!((whole - rest).abs() < 1e-12 * (1.0 + whole.abs()));
}

#[test]
fn an_open_face_keeps_its_curvature() {
    let sample = solid().quadratic().finite();
    let internal = vec![3.0; sample.space.vertices];
    let (_, any) = sample.moved(0.0);
    let [whole, rest] = energies(&sample, &internal, 0.0, &any);
    assert!((whole - rest).abs() < 1e-12 * whole.abs());
}

#[test]
fn what_a_closed_face_has_yet_to_close_takes_nothing_off_the_stiffness() {
    let sample = solid().quadratic().finite();
    let count = sample.surface.multipliers();
    let (contact, closed) = (vec![5.0; count], vec![1.0; count]);
    let pressures = Pressures {
        contact: &contact,
        internal: &[],
        closed: &closed,
    };
    let held = vec![false; sample.displacement.len()];
    let body = sample.body(&sample.displacement);
    let (_, any) = sample.moved(0.0);
    let products = [SCALE, 0.5 * SCALE].map(|height| {
        let plane = HalfSpace::new([0.0, 0.0, height], [0.0, 0.0, -1.0]).expect("a half-space");
        let surfaces = [(&sample.surface, &plane, pressures)];
        let rest = curvature_where_held(&body, &surfaces, &held);
        let mut product = vec![0.0; any.len()];
        rest.apply(&any, &mut product, &mut Workspace::new());
        product
    });
    assert_eq!(products[0], products[1]);
}
