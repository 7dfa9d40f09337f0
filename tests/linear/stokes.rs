//! Flow: exact solutions in channels, mass that enters and leaves, and what makes
//! no sense where u is a velocity.

use std::sync::Arc;

use crate::common::meshes::{cube, irregular, mesh, moved, square};
use crate::common::scenes::{HELD, obstacle, probe, support};
use crate::common::{close, node_positions, run_one, solve_one, values};
use signorini::scene::{
    Formulation, Material, MaterialModel, Profile, Scene, Shape, Support, SupportTarget,
};
use signorini::{FieldName, Mesh, Plan, SceneError, Step};

const VISCOSITY: f64 = 0.25;
const PEAK: f64 = 3.0;
const LENGTH: f64 = 2.0;

fn flow() -> Scene {
    let mut scene = Scene {
        name: "flow".to_owned(),
        materials: vec![Material {
            group: "body".to_owned(),
            model: MaterialModel::Stokes {
                viscosity: VISCOSITY,
                formulation: Formulation::Auto,
            },
        }],
        ..Scene::default()
    };
    scene.solver.verify = true;
    scene.solver.tolerance = 1e-10;
    scene
}

/// A parabola of velocities along x.
fn inflow(on: &str, peak: f64) -> Support {
    Support {
        profile: Profile::Parabolic,
        ..support(on, [Some(peak), Some(0.0), Some(0.0)])
    }
}

/// A plane channel of length 2 and height 1 that flows from x0 to x1, where the
/// velocity is along x and the normal stress zero.
fn channel() -> (Scene, Arc<Mesh>) {
    let plane = |support: Support| Support {
        normal: None,
        displacement: [support.displacement[0], support.displacement[1], None],
        ..support
    };
    let mut scene = flow();
    scene.supports = vec![
        plane(inflow("x0", PEAK)),
        plane(support("y0", HELD)),
        plane(support("y1", HELD)),
        support("x1", [None, Some(0.0), None]),
    ];
    let stretch = |[x, y, z]: [f64; 3]| [LENGTH * x, y, z];
    (scene, mesh(moved(irregular(square(4), 4), stretch)))
}

#[test]
fn poiseuille_flow_is_exact() {
    let (mut scene, mesh) = channel();
    scene.probes = vec![
        probe("middle", [1.0, 0.5, 0.0]),
        probe("start", [0.0, 0.5, 0.0]),
    ];
    let (session, report) = run_one(&scene, &Step::default(), &mesh);
    let velocity = values(&session, FieldName::Displacement);
    for (point, u) in node_positions(&mesh).iter().zip(velocity.chunks(3)) {
        let exact = PEAK * 4.0 * point[1] * (1.0 - point[1]);
        assert!(
            (u[0] - exact).abs() < 1e-8 && u[1].abs() < 1e-8,
            "{point:?}: {u:?}"
        );
    }
    // dp/dx = mu d2u/dy2 = -8 mu U, zero at the end.
    let drop = 8.0 * VISCOSITY * PEAK * LENGTH;
    let at = |name: &str| report.probes[name].pressure.expect("a flow has a pressure");
    assert!(close(at("start"), drop, 1e-7) && close(at("middle"), 0.5 * drop, 1e-7));
    // Nothing but the walls and the inflow holds the fluid along x.
    let force = |name: &str| report.supports[name].force[0];
    let (walls, inflow) = (force("y0") + force("y1"), force("x0"));
    assert!(
        walls < 0.0 && (walls + inflow).abs() < 1e-8 * drop,
        "{walls} {inflow}"
    );
}

#[test]
fn half_of_the_power_dissipated_is_the_energy() {
    let (scene, mesh) = channel();
    let report = solve_one(&scene, &Step::default(), &mesh);
    // 1/2 int mu (du/dy)^2 = 1/2 mu 16 U^2 / 3 times the length.
    let exact = 0.5 * VISCOSITY * 16.0 / 3.0 * PEAK * PEAK * LENGTH;
    assert!(
        close(report.strain_energy, exact, 1e-8),
        "{}",
        report.strain_energy
    );
}

#[test]
fn a_step_changes_the_peak_of_a_profile() {
    let (scene, mesh) = channel();
    let step = Step {
        supports: vec![SupportTarget {
            name: "x0".to_owned(),
            displacement: [Some(-1.0), None, None],
            ..SupportTarget::default()
        }],
        ..Step::default()
    };
    let (session, _) = run_one(&scene, &step, &mesh);
    let velocity = values(&session, FieldName::Displacement);
    for (point, u) in node_positions(&mesh).iter().zip(velocity.chunks(3)) {
        assert!((u[0] + 4.0 * point[1] * (1.0 - point[1])).abs() < 1e-8);
    }
}

#[test]
fn a_square_duct_takes_the_product_of_two_parabolas_and_loses_no_mass() {
    let mut scene = flow();
    scene.supports = vec![
        inflow("x0", PEAK),
        support("y0", HELD),
        support("y1", HELD),
        support("z0", HELD),
        support("z1", HELD),
    ];
    let mesh = mesh(irregular(cube(3), 3));
    assert!(
        Plan::new(&scene, &[], &mesh)
            .expect("a valid scene")
            .report()
            .warnings
            .is_empty()
    );
    let (session, report) = run_one(&scene, &Step::default(), &mesh);
    // Velocities of any size are no strains.
    assert!(report.warnings.is_empty(), "{:?}", report.warnings);
    let velocity = values(&session, FieldName::Displacement);
    let mut inlet = 0;
    for (point, u) in node_positions(&mesh).iter().zip(velocity.chunks(3)) {
        if point[0].abs() < 1e-12 {
            let hump = |s: f64| 4.0 * s * (1.0 - s);
            assert!((u[0] - PEAK * hump(point[1]) * hump(point[2])).abs() < 1e-12);
            inlet += 1;
        }
    }
    assert_eq!(inlet, 49);
    assert!(
        (report.volume_ratio - 1.0).abs() < 1e-9,
        "{}",
        report.volume_ratio
    );
}

#[test]
fn a_closed_channel_has_a_pressure_of_mean_zero() {
    let (mut scene, mesh) = channel();
    scene.supports[3] = Support {
        normal: None,
        displacement: [Some(PEAK), Some(0.0), None],
        ..inflow("x1", PEAK)
    };
    scene.probes = vec![
        probe("middle", [1.0, 0.5, 0.0]),
        probe("start", [0.0, 0.5, 0.0]),
    ];
    let report = solve_one(&scene, &Step::default(), &mesh);
    let at = |name: &str| report.probes[name].pressure.expect("a flow has a pressure");
    assert!(at("middle").abs() < 1e-7, "{}", at("middle"));
    assert!(close(at("start"), 8.0 * VISCOSITY * PEAK, 1e-7));
}

#[test]
fn the_plan_speaks_of_velocity_and_viscosity() {
    let (scene, mesh) = channel();
    let report = Plan::new(&scene, &[], &mesh)
        .expect("a valid scene")
        .report();
    let text = format!("{:?}", report.decisions);
    assert!(
        text.contains("P2 velocity") && text.contains("viscosity"),
        "{text}"
    );
    assert!(report.warnings.is_empty(), "{:?}", report.warnings);
}

fn refused(scene: &Scene, mesh: &Mesh) -> Vec<String> {
    match Plan::new(scene, &[], mesh) {
        Err(SceneError::Invalid(violations)) => violations
            .into_iter()
            .map(|violation| violation.path)
            .collect(),
        other => panic!("{other:?}"),
    }
}

#[test]
fn what_makes_no_sense_in_a_flow_is_refused() {
    let (good, mesh) = channel();
    let mut scene = good.clone();
    scene.materials[0].model = MaterialModel::Stokes {
        viscosity: 0.0,
        formulation: Formulation::Displacement,
    };
    assert_eq!(
        refused(&scene, &mesh),
        ["material.body.viscosity", "material.body.formulation"]
    );
    let mut scene = good;
    let floor = Shape::HalfSpace {
        point: [0.0; 3],
        normal: [-1.0, 0.0, 0.0],
    };
    scene.obstacles = vec![obstacle("floor", "x1", floor)];
    assert_eq!(refused(&scene, &mesh), ["obstacle.floor"]);
}

#[test]
fn a_parabola_needs_a_flat_surface_across_an_axis() {
    let (mut scene, mesh) = channel();
    scene.supports[1].on.push("x1".to_owned());
    scene.supports[1].profile = Profile::Parabolic;
    assert_eq!(refused(&scene, &mesh), ["support.y0.profile"]);
}

#[test]
fn a_solid_cannot_share_a_scene_with_a_flow() {
    let (mut scene, _) = channel();
    let mut parts = square(2);
    let all = parts.groups[0].members.split_off(4);
    parts.groups.push(signorini::Group {
        name: "wall".to_owned(),
        kind: signorini::GroupKind::Cells,
        members: all,
    });
    let mut solid = crate::common::scenes::elastic(0.5).materials.remove(0);
    solid.group = "wall".to_owned();
    scene.materials.push(solid);
    assert_eq!(refused(&scene, &mesh(parts)), ["material.wall.model"]);
}
