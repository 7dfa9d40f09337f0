//! Which surface of a tie carries: one that has functions for what is tied.

use signorini::scene::SceneError;
use signorini::{Plan, Scene, Step};

use super::scenes::{joined, linear, tie};
use crate::common::meshes::{mesh, moved, unit_grid};
use crate::common::scenes::{HELD_IN_PLANE, pull, support};
use crate::common::{assert_converged, run};

/// A stiff block of width 0.3 on the top of a soft unit square of `count` facets, lifted by .05.
fn lifted(count: usize, carries: Option<&str>) -> (Scene, [f64; 2]) {
    let upper = moved(unit_grid(4, 4), |[x, y, z]| {
        [0.33 + 0.3 * x, 1.0 + 0.3 * y, z]
    });
    let body = joined([("low", unit_grid(count, count)), ("up", upper)]);
    let mut seam = tie("seam", "low_y1", "up_y0");
    seam.carries = carries.map(str::to_owned);
    let scene = Scene {
        supports: vec![
            support("low_y0", HELD_IN_PLANE),
            support("up_y1", HELD_IN_PLANE),
        ],
        ties: vec![seam],
        ..linear(&[("low", 1.0), ("up", 1000.0)], 0.3)
    };
    let (_, reports) = run(
        &scene,
        &[pull("up_y1", [None, Some(0.05), None], 1)],
        &mesh(body),
    );
    assert_converged(&reports[0]);
    let own = &reports[0].ties["seam"];
    (scene, [own.force[1], own.moment[2]])
}

/// The reference is a mesh on which either surface has functions enough.
#[test]
fn a_stiff_block_on_a_few_large_soft_facets_is_held() {
    let [exact, fine] = [Some("up_y0"), None].map(|carries| lifted(24, carries).1[0]);
    assert!((fine / exact - 1.0).abs() < 0.02, "{fine} {exact}");
    for count in [1, 2, 3, 4, 6] {
        let force = lifted(count, None).1[0];
        assert!(force.abs() > 0.9 * exact.abs(), "{count}: {force} {exact}");
    }
}

/// Equal to the tie that is carried by the surface that moves.
#[test]
fn a_support_on_the_surface_that_would_carry_is_no_loss() {
    let upper = moved(unit_grid(3, 3), |[x, y, z]| [x, y + 1.0, z]);
    let body = mesh(joined([("low", unit_grid(4, 4)), ("up", upper)]));
    let forces = [None, Some("up_y0")].map(|carries| {
        let mut seam = tie("seam", "low_y1", "up_y0");
        seam.carries = carries.map(str::to_owned);
        let scene = Scene {
            supports: vec![
                support("low_y0", HELD_IN_PLANE),
                support("low_y1", HELD_IN_PLANE),
                support("up_y1", HELD_IN_PLANE),
            ],
            ties: vec![seam],
            ..linear(&[("low", 1.0), ("up", 2.0)], 0.3)
        };
        let (_, reports) = run(&scene, &[pull("up_y1", [None, Some(0.05), None], 1)], &body);
        assert_converged(&reports[0]);
        reports[0].ties["seam"].force[1]
    });
    assert!(
        forces[0].abs() > 0.1 && forces[0].to_bits() == forces[1].to_bits(),
        "{forces:?}"
    );
}

#[test]
fn a_surface_that_is_named_and_cannot_carry_is_refused() {
    let upper = moved(unit_grid(3, 3), |[x, y, z]| [x, y + 1.0, z]);
    let body = mesh(joined([("low", unit_grid(4, 4)), ("up", upper)]));
    let mut seam = tie("seam", "low_y1", "up_y0");
    seam.carries = Some("low_y1".to_owned());
    let scene = Scene {
        supports: vec![
            support("low_y0", HELD_IN_PLANE),
            support("low_y1", HELD_IN_PLANE),
        ],
        ties: vec![seam],
        ..linear(&[("low", 1.0), ("up", 2.0)], 0.3)
    };
    let Err(SceneError::Invalid(all)) = Plan::new(&scene, &[Step::default()], &body) else {
        panic!("a fault");
    };
    assert_eq!(all[0].path, "tie.seam.between");
    assert!(
        all[0]
            .message
            .contains("name the other surface in `carries`"),
        "{}",
        all[0].message
    );
}
