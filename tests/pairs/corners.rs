//! Corners of a body that dip into a softer one.

use super::folds::with_union;
use super::scenes::{between, joined, rubber};
use crate::common::meshes::{mesh, moved, unit_grid};
use crate::common::scenes::{HELD_IN_PLANE, pull, support};
use crate::common::{assert_converged, close, solve};
use signorini::scene::MaterialModel;
use signorini::{Scene, StepReport};

/// A block of five facets pressed by its `surface` into a soft slab of `facets`, which carries.
fn dipped(facets: usize, friction: f64, surface: &str) -> Vec<StepReport> {
    let slab = moved(unit_grid(facets, 4), |[x, y, z]| {
        [2.4 * x - 1.2, y - 1.0, z]
    });
    let block = moved(unit_grid(5, 5), |[x, y, z]| [x - 0.4, y, z]);
    let parts = joined(&[("low_", slab), ("up_", block)]);
    let parts = with_union(parts, "skin", &["up_x0", "up_y0", "up_x1"]);
    let mut contacts = between("low_y1", surface);
    contacts.iter_mut().for_each(|one| one.friction = friction);
    let scene = Scene {
        supports: vec![
            support("low_y0", HELD_IN_PLANE),
            support("up_y1", HELD_IN_PLANE),
        ],
        contacts,
        ..rubber([("low_body", 0.01), ("up_body", 1.0)], Some(2.0))
    };
    let steps = [pull("up_y1", [Some(0.0), Some(-0.12), None], 3)];
    solve(&scene, &steps, &mesh(parts))
}

#[test]
fn walls_that_touch_nothing_change_nothing_where_corners_dip_into_a_soft_body() {
    for (facets, friction) in [(5, 0.0), (6, 0.0), (7, 0.3), (8, 0.3)] {
        let [all, sole] = ["skin", "up_y0"].map(|on| dipped(facets, friction, on));
        for (all, sole) in all.iter().zip(&sole) {
            assert_converged(all);
            assert!(all.sqp_iterations <= 12, "{}", all.sqp_iterations);
            let [found, expected] = [all, sole].map(|report| report.contacts["pair"].force[1]);
            assert!(close(found, expected, 1e-7), "{found} {expected}");
        }
    }
}

/// A blunt wedge above a block, led through the gap in some increments: its flanks meet nothing before its end.
fn wedge(contrast: f64, increments: u32) -> [f64; 2] {
    let slab = moved(unit_grid(12, 6), |[x, y, z]| [x, 0.6 * y, z]);
    let tip = moved(unit_grid(5, 2), |[x, y, z]| {
        let low = 0.69 + 0.08 * ((5.0 * x - 2.5).abs() - 0.5).max(0.0);
        [0.2 + 0.6 * x, low + (1.05 - low) * y, z]
    });
    let parts = joined(&[("low_", slab), ("up_", tip)]);
    let scene = Scene {
        supports: vec![
            support("low_y0", HELD_IN_PLANE),
            support("up_y1", HELD_IN_PLANE),
        ],
        contacts: between("low_y1", "up_y0"),
        ..rubber([("low_body", 1.0), ("up_body", contrast)], None)
    };
    let step = pull("up_y1", [Some(0.0), Some(-0.1), None], increments);
    let reports = solve(&scene, &[step], &mesh(parts));
    let last = reports.last().expect("a report");
    assert_converged(last);
    [last.contacts["pair"].force[1], last.strain_energy]
}

#[test]
fn flanks_of_a_blunt_tip_touch_nothing_before_its_end() {
    for contrast in [1e2, 1e5] {
        let one = wedge(contrast, 1);
        for increments in [2, 3, 5] {
            let found = wedge(contrast, increments);
            for (found, one) in found.iter().zip(one) {
                assert!(close(*found, one, 1e-6), "{increments}: {found} {one}");
            }
        }
    }
}

/// Force of a wedge of 67 degrees, a hundred times as stiff, pressed into a slab of 8 facets, or of times as many.
fn sharp_wedge(finer: usize) -> f64 {
    let slab = moved(unit_grid(8 * finer, 4 * finer), |[x, y, z]| [x, 0.6 * y, z]);
    let tip = moved(unit_grid(4 * finer, 2 * finer), |[x, y, z]| {
        let low = 0.65 + 0.4 * (x - 0.5).abs();
        [0.2 + 0.6 * x, low + (1.05 - low) * y, z]
    });
    let mut scene = Scene {
        supports: vec![
            support("low_y0", HELD_IN_PLANE),
            support("up_y1", HELD_IN_PLANE),
        ],
        contacts: between("up_y0", "low_y1"),
        ..rubber([("low_body", 1.0), ("up_body", 100.0)], None)
    };
    scene.contacts[0].carries = Some("low_y1".to_owned());
    let step = pull("up_y1", [Some(0.0), Some(-0.1), None], 2);
    let reports = solve(
        &scene,
        &[step],
        &mesh(joined(&[("low_", slab), ("up_", tip)])),
    );
    let last = reports.last().expect("a report");
    assert_converged(last);
    last.contacts["pair"].force[1]
}

/// Its sides are no walls: both press on the function that meets the tip.
#[test]
fn both_flanks_of_a_sharp_tip_count() {
    let [coarse, fine] = [1, 2].map(sharp_wedge);
    assert!(close(coarse, fine, 0.2), "{coarse} {fine}");
}

/// A block of 8 by 8 facets, a hundred times as stiff, pressed by its `surface` into a slab of 8 by 4 between two of
/// whose vertices its corners lie.
fn pressed_between_vertices(surface: &str) -> Vec<StepReport> {
    let slab = moved(unit_grid(8, 4), |[x, y, z]| [3.0 * x, y - 1.0, z]);
    let block = moved(unit_grid(8, 8), |[x, y, z]| {
        [1.055 + 0.8584 * x, 0.666 * y, z]
    });
    let parts = joined(&[("low_", slab), ("up_", block)]);
    let parts = with_union(parts, "skin", &["up_x0", "up_y0", "up_x1"]);
    let mut scene = Scene {
        supports: vec![
            support("low_y0", HELD_IN_PLANE),
            support("up_y1", HELD_IN_PLANE),
        ],
        contacts: between("low_y1", surface),
        ..rubber([("low_body", 1.0), ("up_body", 100.0)], Some(1000.0))
    };
    if let MaterialModel::Rubber { bulk_modulus, .. } = &mut scene.materials[0].model {
        *bulk_modulus = Some(10.0);
    }
    let steps = [pull("up_y1", [Some(0.0), Some(-0.2), None], 4)];
    solve(&scene, &steps, &mesh(parts))
}

#[test]
fn open_walls_make_no_room_for_a_sole_that_presses() {
    let [all, sole] = ["skin", "up_y0"].map(pressed_between_vertices);
    for (all, sole) in all.iter().zip(&sole) {
        assert_converged(all);
        let [found, expected] = [all, sole].map(|report| report.contacts["pair"].force[1]);
        assert!(close(found, expected, 5e-3), "{found} {expected}");
    }
}

#[test]
fn intervals_of_contact_bear_its_force_where_the_carrier_is_wider() {
    for report in dipped(5, 0.0, "up_y0") {
        let pair = &report.contacts["pair"];
        for axis in 0..2 {
            let intervals = pair.contact_intervals.iter();
            let sum: f64 = intervals.map(|one| one.force[axis]).sum();
            let error = (sum - pair.force[axis]).abs();
            assert!(
                error <= 1e-9 * pair.force[1].abs(),
                "{sum} {:?}",
                pair.force
            );
        }
    }
}
