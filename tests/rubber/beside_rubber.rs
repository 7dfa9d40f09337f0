//! Linear parts beside rubber: stiff or soft, they bear what linear elasticity says of small
//! strains, and turn with the body.

use std::sync::Arc;

use crate::common::meshes::{mesh, square};
use crate::common::refusals::unsupported;
use crate::common::scenes::{HELD, elastic, material, pull, support, turned};
use crate::common::{assert_converged, close, solve, solve_one};
use signorini::scene::{Formulation, Material, MaterialModel, Modulus, RubberModel};
use signorini::{Group, GroupKind, Mesh, Plan, Scene, Step};

/// Poisson's ratio of both layers, so that their pressures are equal where they are in series.
const RATIO: f64 = 0.3;

/// The unit square, its cells below and above the middle as the groups `soft` and `stiff`.
fn layers() -> Arc<Mesh> {
    let mut parts = square(2);
    let half = parts.cells.len() as u32 / 6;
    let group = |name: &str, members: Vec<u32>| Group {
        name: name.to_owned(),
        kind: GroupKind::Cells,
        members,
    };
    let groups = [
        group("soft", (0..half).collect()),
        group("stiff", (half..2 * half).collect()),
    ];
    parts.groups.retain(|group| group.name != "body");
    parts.groups.extend(groups);
    mesh(parts)
}

/// Rubber of shear modulus one below, a linear layer `contrast` times as stiff above.
fn scene(contrast: f64, ratio: f64) -> Scene {
    let bulk = 2.0 * (1.0 + RATIO) / (3.0 * (1.0 - 2.0 * RATIO));
    let rubber = Material {
        group: "soft".to_owned(),
        model: MaterialModel::Rubber {
            model: RubberModel::NeoHookean { shear_modulus: 1.0 },
            bulk_modulus: Some(bulk),
            formulation: Formulation::Auto,
        },
    };
    let linear = Material {
        group: "stiff".to_owned(),
        ..material(Modulus::Shear(contrast), ratio)
    };
    Scene {
        materials: vec![rubber, linear],
        ..elastic(RATIO)
    }
}

#[test]
fn layers_in_series_bear_what_linear_elasticity_says_of_small_strains() {
    // Held at the sides: sigma = (lambda + 2 mu) eps in each, of the same sigma.
    let travel = 1e-6;
    for contrast in [0.1, 10.0, 1e5] {
        let mut scene = scene(contrast, RATIO);
        scene.supports = vec![
            support("y0", [Some(0.0), Some(0.0), None]),
            support("y1", [Some(0.0), Some(0.0), None]),
            support("x0", [Some(0.0), None, None]),
            support("x1", [Some(0.0), None, None]),
        ];
        let pressed = pull("y1", [Some(0.0), Some(-travel), None], 1);
        let report = solve_one(&scene, &pressed, &layers());
        let modulus = 2.0 * (1.0 - RATIO) / (1.0 - 2.0 * RATIO);
        let expected = -travel * modulus / (0.5 + 0.5 / contrast);
        let found = report.supports["y1"].force[1];
        assert!(
            close(found, expected, 1e-5),
            "{contrast} {found} {expected}"
        );
    }
}

#[test]
fn a_linear_layer_turns_with_the_rubber_that_it_is_bonded_to() {
    let mut scene = scene(1e5, 0.3);
    scene.supports = vec![support("y0", HELD)];
    let step = Step {
        supports: vec![turned("y0", [0.0, 0.0, 2.0], [0.0; 3])],
        increments: 4,
        ..Step::default()
    };
    let reports = solve(&scene, &[step], &layers());
    reports.iter().for_each(assert_converged);
    let energy = reports.last().expect("an increment").strain_energy;
    assert!(energy.abs() < 1e-12, "{energy:e}");
}

#[test]
fn the_plan_says_which_law_takes_the_place_of_the_linear_one() {
    let mut scene = scene(10.0, 0.5);
    scene.supports = vec![support("y0", HELD)];
    let plan = Plan::new(&scene, &[], &layers()).expect("a valid scene");
    let report = plan.report();
    let entry = report.decisions.iter().find(|one| one.what == "material");
    let chosen = &entry.expect("of rubber").choice;
    let said = "neo-hookean in the place of linear-elastic, incompressible";
    assert!(chosen.contains(said), "{chosen}");
}

#[test]
fn a_linear_part_beside_rubber_has_a_poisson_ratio_above_zero() {
    let mut scene = scene(10.0, 0.005);
    scene.supports = vec![support("y0", HELD)];
    let found = unsupported(&scene, &layers());
    assert_eq!(found.path, "material.stiff.poisson_ratio");
}
