//! Two balls against Hertz.

use std::sync::Arc;

use signorini::report::BodyContactResult;
use signorini::scene::SupportTarget;
use signorini::{Mesh, Scene, Step};

use crate::common::meshes::{half_space, moved};
use crate::common::rounded::offsets;
use crate::common::scenes::support;
use crate::common::{assert_converged, close, solve, solve_one};
use crate::scenes::{between, joined, linear, linear_of};

/// A point of a half-space given the surface of a ball of radius one, of a parabola near the pole.
fn rounded([x, y, z]: [f64; 3]) -> [f64; 3] {
    let fade = (1.0 + z).powi(2);
    let square = x * x + y * y;
    [x, y, z - 0.5 * square / (1.0 + square) * fade]
}

/// Quarters of what stands for two balls, one `gap` below the other; groups `low_` and `up_`.
fn mesh(counts: [usize; 2], gap: f64) -> Arc<Mesh> {
    parts_of(counts, gap, &[0, 1])
}

/// The same, parts to one side only along the axes of `half`.
fn parts_of(counts: [usize; 2], gap: f64, half: &[usize]) -> Arc<Mesh> {
    let [low, up] = counts.map(|count| half_space(3, count, 4.0, half));
    let straight = joined(&[("low_", low.clone()), ("up_", up.clone())]);
    let first = low.coordinates.len();
    let place = |x: [f64; 3], is_low: bool| {
        let [x, y, z] = rounded(x);
        [x, y, if is_low { z } else { -z }]
    };
    let mut upper = moved(up, |x| place(x, false));
    upper.cells.chunks_mut(4).for_each(|cell| cell.swap(2, 3));
    let upper = moved(upper, |[x, y, z]| [x, y, z + gap]);
    let parts = joined(&[("low_", moved(low, |x| place(x, true))), ("up_", upper)]);
    let before = &straight.coordinates;
    let mut all = Vec::new();
    for is_low in [true, false] {
        let mut own = straight.clone();
        let is_own = |cell: &[u32]| ((cell[0] as usize) < first) == is_low;
        own.cells = own
            .cells
            .chunks(4)
            .filter(|cell| is_own(cell))
            .flatten()
            .copied()
            .collect();
        let middles = offsets(&own, |ends| {
            let middle = [0, 1, 2].map(|i| 0.5 * (ends[0][i] + ends[1][i]));
            let ends = ends.map(|end| place(end, is_low));
            let (middle, mean) = (
                place(middle, is_low),
                [0, 1, 2].map(|i| 0.5 * (ends[0][i] + ends[1][i])),
            );
            // What the middle is off its ends, from where these are.
            let off = [0, 1, 2].map(|i| middle[i] - mean[i]);
            Some(off)
        });
        for mut edge in middles {
            let ends = edge.ends.map(|end| before[end as usize]);
            for i in 0..3 {
                edge.offset[i] += 0.5 * (ends[0][i] + ends[1][i]);
            }
            all.push(edge);
        }
    }
    all.sort_by_key(|edge| edge.ends);
    Arc::new(Mesh::second_order(parts, all).expect("a valid mesh"))
}

/// What presses two balls that begin `gap` apart and come .018 nearer than touch.
fn pressed(counts: [usize; 2], gap: f64) -> BodyContactResult {
    let scene = Scene {
        supports: vec![
            support("low_z0", [Some(0.0); 3]),
            support("up_z0", [Some(0.0); 3]),
            support("low_x0", [Some(0.0), None, None]),
            support("up_x0", [Some(0.0), None, None]),
            support("low_y0", [None, Some(0.0), None]),
            support("up_y0", [None, Some(0.0), None]),
        ],
        contacts: between("up_z1", "low_z1"),
        ..linear([("low_body", 1.0), ("up_body", 1.0)])
    };
    let target = |name: &str, way: f64| SupportTarget {
        name: name.to_owned(),
        displacement: [Some(0.0), Some(0.0), Some(way)],
        ..SupportTarget::default()
    };
    let step = Step {
        supports: vec![target("up_z0", -0.009 - gap), target("low_z0", 0.009)],
        ..Step::default()
    };
    let report = solve_one(&scene, &step, &mesh(counts, gap));
    report.contacts["pair"].clone()
}

#[test]
fn balls_press_by_what_they_are_pressed_beyond_touch() {
    let exact = pressed([5, 6], 0.0);
    for gap in [0.05, 0.15] {
        let found = pressed([5, 6], gap);
        let force = found.force[2] / exact.force[2];
        assert!((force - 1.0).abs() < 3e-3, "{gap} {force}");
    }
}

#[test]
fn two_balls_press_as_hertz_has_it() {
    let contact = pressed([8, 9], 0.0);
    // Whole balls: E* = 2 mu, R = 1/2; the peak follows from the force, whatever the bodies are far off.
    let force = 4.0 * contact.force[2];
    let [modulus, radius] = [2.0, 0.5];
    let half_width = (0.75 * force * radius / modulus).cbrt();
    let peak = 1.5 * force / (std::f64::consts::PI * half_width * half_width);
    let area = 0.25 * std::f64::consts::PI * half_width * half_width;
    let mean = force / (4.0 * area);
    let found = [
        contact.contact_area / area,
        contact.mean_pressure.unwrap_or_default() / mean,
        contact.peak_pressure / peak,
    ];
    assert!(close(found[0], 1.0, 0.03), "{found:?}");
    assert!(close(found[1], 1.0, 0.03), "{found:?}");
    // Five facets are on the radius.
    assert!(close(found[2], 1.0, 0.2), "{found:?}");
}

/// Halves of balls without lateral strain, pressed as far as Hertz has a radius of .095 of contact, then
/// pushed across by `way`: force and push of whole balls.
fn pushed(friction: f64, way: f64) -> [f64; 2] {
    let mut scene = Scene {
        supports: vec![
            support("low_z0", [Some(0.0); 3]),
            support("up_z0", [Some(0.0); 3]),
            support("low_y0", [None, Some(0.0), None]),
            support("up_y0", [None, Some(0.0), None]),
        ],
        contacts: between("up_z1", "low_z1"),
        ..linear_of(0.0, [("low_body", 1.0), ("up_body", 1.0)])
    };
    scene.contacts[0].friction = friction;
    let target = |name: &str, [across, up]: [f64; 2]| SupportTarget {
        name: name.to_owned(),
        displacement: [Some(across), Some(0.0), Some(up)],
        ..SupportTarget::default()
    };
    let step = |across: f64| Step {
        supports: vec![
            target("up_z0", [0.5 * across, -0.009]),
            target("low_z0", [-0.5 * across, 0.009]),
        ],
        ..Step::default()
    };
    let steps = [step(0.0), step(0.5 * way), step(way)];
    let reports = solve(&scene, &steps, &parts_of([5, 6], 0.0, &[1]));
    reports.iter().for_each(assert_converged);
    let contact = &reports[2].contacts["pair"];
    if friction < 1.0 {
        let found = contact.friction.expect("friction");
        assert!(found.stick_vertices > 0 && found.slip_vertices > 0);
        assert!(found.dissipated_total > 0.0);
    }
    [contact.force[2], contact.force[0].abs()].map(|force| 2.0 * force)
}

/// What the bodies give far from the contact is left out by a push at which all sticks.
#[test]
fn two_balls_that_are_pushed_across_give_way_as_mindlin_has_it() {
    let (friction, way) = (0.3, 0.0032);
    let ([load, push], [_, whole]) = (pushed(friction, way), pushed(1e3, way));
    let [modulus, radius] = [1.0, 0.5];
    let half_width = (0.75 * load * radius / modulus).cbrt();
    let part = push / (friction * load);
    let all_sticks = 0.5 * push / half_width;
    let told = 0.75 * friction * load / half_width * (1.0 - (1.0 - part).powf(2.0 / 3.0));
    let found = way * (1.0 - push / whole) + all_sticks;
    assert!(part > 0.3 && part < 0.8, "{part}");
    assert!(close(found, told, 0.03), "{found} {told}");
}
