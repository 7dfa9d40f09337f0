//! Materials that resist a change of volume little, or less than nothing, in scenes that
//! carry a pressure because of another material.

use crate::common::meshes::{cube, mesh, with_inclusion};
use crate::common::scenes::{HELD, elastic, material, probe, pull, rollers, support, traction};
use crate::common::{close, solve_one};
use signorini::scene::{Formulation, MaterialModel, Modulus};
use signorini::{Scene, Step};

const RATIOS: [f64; 5] = [0.009, 0.0, -0.3, -0.7, -0.89];

/// A body whose volume is carried by a pressure, whatever its Poisson ratio.
fn mixed(ratio: f64) -> Scene {
    let mut scene = elastic(ratio);
    if let MaterialModel::LinearElastic { formulation, .. } = &mut scene.materials[0].model {
        *formulation = Formulation::Mixed;
    }
    scene
}

fn lame(ratio: f64) -> f64 {
    2.0 * ratio / (1.0 - 2.0 * ratio)
}

#[test]
fn a_pulled_bar_is_exact_for_any_poisson_ratio() {
    for ratio in RATIOS {
        let mut scene = mixed(ratio);
        scene.supports = rollers();
        scene.tractions = vec![traction("z1", [0.0, 0.0, 0.1])];
        scene.probes = vec![probe("corner", [1.0; 3])];
        let report = solve_one(&scene, &Step::default(), &mesh(cube(3)));
        let strain = 0.1 / (2.0 * (1.0 + ratio));
        let corner = report.probes["corner"];
        let [x, _, z] = corner.displacement;
        assert!(close(z, strain, 1e-6), "{ratio} {z} {strain}");
        assert!((x + ratio * strain).abs() < 1e-6 * strain, "{ratio} {x}");
        let pressure = -lame(ratio) * (1.0 - 2.0 * ratio) * strain;
        let found = corner.pressure.expect("a pressure");
        assert!(
            (found - pressure).abs() < 1e-6,
            "{ratio} {found} {pressure}"
        );
        assert!(close(report.strain_energy, 0.05 * strain, 1e-6));
    }
}

#[test]
fn a_closed_in_block_resists_as_its_two_moduli_say() {
    for ratio in RATIOS {
        let mut scene = mixed(ratio);
        scene.supports = ["x0", "x1"]
            .map(|name| support(name, [Some(0.0), None, None]))
            .into();
        scene
            .supports
            .extend(["y0", "y1"].map(|name| support(name, [None, Some(0.0), None])));
        scene
            .supports
            .extend(["z0", "z1"].map(|name| support(name, [None, None, Some(0.0)])));
        let step = pull("z1", [None, None, Some(-0.01)], 1);
        let report = solve_one(&scene, &step, &mesh(cube(2)));
        let force = report.supports["z1"].force[2];
        let modulus = 2.0 + lame(ratio);
        assert!(
            close(force, -0.01 * modulus, 1e-6),
            "{ratio} {force} {modulus}"
        );
    }
}

#[test]
fn foam_beside_an_incompressible_body_changes_little_where_its_form_changes() {
    let bent = |ratio: f64| {
        let parts = with_inclusion(cube(4), "foam", |[_, _, z]| z > 0.5);
        let mut scene = elastic(0.5);
        scene.materials.push(signorini::scene::Material {
            group: "foam".to_owned(),
            ..material(Modulus::Shear(1.0), ratio)
        });
        scene.supports = vec![support("z0", HELD)];
        scene.tractions = vec![traction("z1", [0.02, 0.0, -0.05])];
        scene.probes = vec![probe("top", [1.0; 3])];
        solve_one(&scene, &Step::default(), &mesh(parts)).probes["top"].displacement
    };
    let (below, above) = (bent(0.0099), bent(0.0101));
    let length = above.iter().map(|x| x * x).sum::<f64>().sqrt();
    for (a, b) in below.iter().zip(above) {
        assert!((a - b).abs() < 1e-3 * length, "{below:?} {above:?}");
    }
}
