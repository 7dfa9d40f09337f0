//! Supports that are loaded: their surface moves as a rigid part, and the pose follows from force,
//! moment and spring. A bush by its sleeve, a roller by its axle.

use std::sync::Arc;

use crate::common::meshes::{mesh, ring, square};
use crate::common::refusals::{unsupported, violations};
use crate::common::rounded::whole_ring;
use crate::common::scenes::{elastic, in_parts, material, obstacle, plane, rubber, support};
use crate::common::{assert_converged, close, solve, solve_one};
use signorini::scene::{Formulation, Material, MaterialModel, Modulus, RubberModel};
use signorini::scene::{Support, SupportLoad, SupportTarget};
use signorini::{Group, GroupKind, Mesh, Scene, Step, StepReport};

const FLAT: [Option<f64>; 3] = [Some(0.0), Some(0.0), None];
const NEO_HOOKEAN: RubberModel = RubberModel::NeoHookean { shear_modulus: 1.0 };

/// A ring of radii 1 and 2 whose innermost cells are the group `sleeve`, the others `rubber`.
fn bush_mesh() -> Arc<Mesh> {
    let mut parts = whole_ring(24, 4);
    let inside = |cell: usize| {
        let corners = &parts.cells[3 * cell..3 * cell + 3];
        corners.iter().all(|&vertex| {
            let [x, y, _] = parts.coordinates[vertex as usize];
            x.hypot(y) < 1.26
        })
    };
    let cells = 0..parts.cells.len() / 3;
    let (sleeve, others): (Vec<usize>, Vec<usize>) = cells.partition(|&cell| inside(cell));
    let group = |name: &str, members: Vec<usize>| Group {
        name: name.to_owned(),
        kind: GroupKind::Cells,
        members: members.into_iter().map(|cell| cell as u32).collect(),
    };
    let own = [group("sleeve", sleeve), group("rubber", others)];
    parts.groups.retain(|group| group.name != "body");
    parts.groups.extend(own);
    mesh(parts)
}

/// Rubber between a sleeve of `contrast` times its modulus, whose bore is loaded, and the ground.
fn bush(contrast: f64) -> Scene {
    let rubber = Material {
        group: "rubber".to_owned(),
        model: MaterialModel::Rubber {
            model: NEO_HOOKEAN,
            bulk_modulus: None,
            formulation: Formulation::Auto,
        },
    };
    let sleeve = Material {
        group: "sleeve".to_owned(),
        ..material(Modulus::Shear(contrast), 0.3)
    };
    Scene {
        materials: vec![rubber, sleeve],
        supports: vec![support("inner", FLAT), support("outer", FLAT)],
        ..elastic(0.3)
    }
}

fn loaded(force: [Option<f64>; 3], moment: Option<f64>) -> Step {
    Step {
        supports: vec![SupportTarget {
            name: "inner".to_owned(),
            force,
            moment: [None, None, moment],
            ..SupportTarget::default()
        }],
        ..Step::default()
    }
}

fn led(report: &StepReport) -> Step {
    let found = report.supports["inner"];
    Step {
        supports: vec![SupportTarget {
            name: "inner".to_owned(),
            translation: Some(found.translation),
            rotation: Some(found.rotation),
            ..SupportTarget::default()
        }],
        ..Step::default()
    }
}

/// The last report of a bush under `step` in `increments`, and that of one led by its pose.
fn both_ways(contrast: f64, step: Step, increments: u32) -> [StepReport; 2] {
    let mesh = bush_mesh();
    let scene = bush(contrast);
    let by_force = solve(&scene, &[in_parts(step, increments)], &mesh);
    by_force.iter().for_each(assert_converged);
    let by_force = by_force.last().expect("a report").clone();
    let by_travel = solve(&scene, &[in_parts(led(&by_force), increments)], &mesh);
    let by_travel = by_travel.last().expect("a report").clone();
    assert_converged(&by_travel);
    [by_force, by_travel]
}

#[test]
fn a_bush_is_as_stiff_by_force_as_by_travel() {
    for contrast in [1.0, 1e5] {
        let [by_force, by_travel] = both_ways(contrast, loaded([Some(3.0), None, None], None), 2);
        let [own, other] = [&by_force, &by_travel].map(|report| report.supports["inner"]);
        assert!(close(own.force[0], 3.0, 1e-8), "{own:?}");
        assert!(own.translation[0] > 1e-3, "{own:?}");
        let stiffness = [own, other].map(|one| one.force[0] / one.translation[0]);
        assert!(close(stiffness[0], stiffness[1], 1e-8), "{stiffness:?}");
    }
}

#[test]
fn a_bush_is_as_stiff_by_moment_as_by_rotation() {
    for contrast in [1.0, 1e5] {
        let [by_force, by_travel] = both_ways(contrast, loaded([None; 3], Some(4.0)), 2);
        let [own, other] = [&by_force, &by_travel].map(|report| report.supports["inner"]);
        assert!(close(own.moment[2], 4.0, 1e-8), "{own:?}");
        let stiffness = [own, other].map(|one| one.moment[2] / one.rotation[2]);
        assert!(close(stiffness[0], stiffness[1], 1e-8), "{stiffness:?}");
    }
}

#[test]
fn force_and_moment_at_once_are_met_about_the_reference_point() {
    let mut scene = bush(1e5);
    scene.supports[0] = Support {
        load: SupportLoad {
            force: [Some(1.0), Some(-2.0), None],
            moment: [None, None, Some(1.5)],
            about: Some([0.5, 0.0, 0.0]),
            ..SupportLoad::default()
        },
        displacement: [None; 3],
        ..support("inner", FLAT)
    };
    let report = solve_one(&scene, &Step::default(), &bush_mesh());
    assert_converged(&report);
    let own = report.supports["inner"];
    assert!(
        close(own.force[0], 1.0, 1e-7) && close(own.force[1], -2.0, 1e-7),
        "{own:?}"
    );
    assert!(close(own.moment[2], 1.5, 1e-7), "{own:?}");
    let expected = [0.5 + own.translation[0], own.translation[1], 0.0];
    let misplaced = (0..3).map(|i| (own.reference_point[i] - expected[i]).abs());
    assert!(misplaced.fold(0.0, f64::max) < 1e-15, "{own:?}");
    // About one point the moments of both supports balance.
    let outer = report.supports["outer"];
    let [x, y, _] = own.reference_point;
    let about = own.moment[2] + x * own.force[1] - y * own.force[0];
    assert!((about + outer.moment[2]).abs() < 1e-6, "{own:?} {outer:?}");
}

#[test]
fn a_spring_takes_its_share_of_the_force() {
    let mut scene = bush(1.0);
    scene.supports[0].displacement = [None, Some(0.0), None];
    scene.supports[0].load.stiffness = [Some(50.0), None, None];
    let report = solve_one(&scene, &loaded([Some(5.0), None, None], None), &bush_mesh());
    assert_converged(&report);
    let own = report.supports["inner"];
    assert!(own.translation[0] > 0.01, "{own:?}");
    let sum = own.force[0] + 50.0 * own.translation[0];
    assert!(close(sum, 5.0, 1e-7), "{own:?} {sum}");
}

#[test]
fn a_spring_alone_holds_what_presses_the_body() {
    // The body is pushed by a plane against its sprung base: a series of two springs.
    let mut scene = rubber(NEO_HOOKEAN, Some(1e3));
    let base = SupportLoad {
        stiffness: [None, Some(0.5), None],
        ..SupportLoad::default()
    };
    scene.supports = vec![Support {
        load: base,
        ..support("y0", [Some(0.0), None, None])
    }];
    scene.obstacles = vec![obstacle(
        "lid",
        "y1",
        plane([0.0, 1.0, 0.0], [0.0, -1.0, 0.0]),
    )];
    let step = crate::common::scenes::push("lid", [0.0, -0.1, 0.0]);
    let report = solve_one(&scene, &step, &mesh(square(4)));
    assert_converged(&report);
    let (lid, base) = (&report.obstacles["lid"], report.supports["y0"]);
    assert!(close(base.force[1], -lid.force[1], 1e-7), "{base:?}");
    assert!(
        close(base.force[1], -0.5 * base.translation[1], 1e-7),
        "{base:?}"
    );
}

/// A roller of rubber on its axle over a road it does not touch at first.
fn roller(friction: f64) -> (Scene, Arc<Mesh>) {
    let mut scene = rubber(NEO_HOOKEAN, None);
    scene.supports = vec![support("rim", FLAT)];
    scene.obstacles = vec![obstacle(
        "road",
        "tread",
        plane([0.0, -1.05, 0.0], [0.0, 1.0, 0.0]),
    )];
    scene.obstacles[0].friction = friction;
    (scene, mesh(ring(48, 4, 0.5)))
}

fn on_axle(force: f64, moment: Option<f64>) -> Step {
    let mut step = loaded([None, Some(force), None], moment);
    step.supports[0].name = "rim".to_owned();
    step
}

#[test]
fn a_roller_is_lowered_by_the_force_on_its_axle() {
    let (scene, mesh) = roller(0.0);
    let report = solve_one(&scene, &on_axle(-0.2, None), &mesh);
    assert_converged(&report);
    let (road, axle) = (&report.obstacles["road"], report.supports["rim"]);
    assert!(close(road.force[1], 0.2, 1e-7), "{road:?}");
    assert!(close(axle.force[1], -0.2, 1e-7), "{axle:?}");
    assert!(axle.translation[1] < -0.05, "{axle:?}");
}

#[test]
fn a_torque_on_the_axle_of_a_pressed_roller_is_borne_by_friction() {
    let (scene, mesh) = roller(0.5);
    let steps = [on_axle(-0.3, None), on_axle(-0.3, Some(0.05))];
    let reports = solve(&scene, &steps, &mesh);
    reports.iter().for_each(assert_converged);
    let (road, axle) = (&reports[1].obstacles["road"], reports[1].supports["rim"]);
    assert!(close(axle.moment[2], 0.05, 1e-6), "{axle:?}");
    // The axle keeps its place along the road, which bears the torque at the tread.
    assert!(
        close(road.force[0], -axle.force[0], 1e-6),
        "{road:?} {axle:?}"
    );
    let arm = 1.05 + axle.translation[1];
    assert!((road.force[0].abs() * arm - 0.05).abs() < 0.005, "{road:?}");
    assert!(axle.rotation[2] > 0.0, "{axle:?}");
}

#[test]
fn a_linear_body_is_loaded_by_a_face_that_moves_as_a_rigid_part() {
    let mut scene = elastic(0.3);
    scene.supports = vec![support("y0", FLAT), support("y1", FLAT)];
    let mut step = loaded([None, Some(-0.01), None], None);
    step.supports[0].name = "y1".to_owned();
    let mesh = mesh(square(6));
    let by_force = solve_one(&scene, &step, &mesh);
    assert_converged(&by_force);
    let own = by_force.supports["y1"];
    let back = crate::common::scenes::pull("y1", [Some(0.0), Some(own.translation[1]), None], 1);
    let by_travel = solve_one(&scene, &back, &mesh).supports["y1"];
    assert!(close(own.force[1], -0.01, 1e-8), "{own:?}");
    assert!(close(by_travel.force[1], -0.01, 1e-8), "{by_travel:?}");
}

#[test]
fn a_loaded_support_that_is_led_again_keeps_nothing_of_its_force() {
    let mesh = bush_mesh();
    let scene = bush(1.0);
    let back = Step {
        supports: vec![SupportTarget {
            name: "inner".to_owned(),
            translation: Some([0.0; 3]),
            ..SupportTarget::default()
        }],
        ..Step::default()
    };
    let reports = solve(
        &scene,
        &[loaded([Some(3.0), None, None], None), back],
        &mesh,
    );
    reports.iter().for_each(assert_converged);
    assert!(
        reports[1].strain_energy < 1e-12,
        "{}",
        reports[1].strain_energy
    );
}

#[test]
fn loads_of_supports_that_make_no_sense_are_refused_by_key() {
    let mesh = bush_mesh();
    let refused = |change: &dyn Fn(&mut Support), step: Step| {
        let mut scene = bush(1.0);
        change(&mut scene.supports[0]);
        violations(&scene, &[step], &mesh)
    };
    let none = Step::default();
    let both = |one: &mut Support| one.load.force = [Some(1.0), None, None];
    assert!(
        refused(&both, none.clone())[0]
            .path
            .ends_with("displacement.x")
    );
    let soft = |one: &mut Support| {
        one.displacement = [None, Some(0.0), None];
        one.load.stiffness = [Some(0.0), None, None];
    };
    assert!(refused(&soft, none)[0].path.ends_with("stiffness.x"));
    let free = |one: &mut Support| one.displacement = [Some(0.0), None, None];
    let found = refused(&free, loaded([None, Some(1.0), None], Some(1.0)));
    assert!(
        found
            .iter()
            .any(|one| one.message.contains("needs all components")),
        "{found:?}"
    );
    let out = refused(&|_| (), loaded([None, None, Some(1.0)], None));
    assert!(out[0].message.contains("plane body"), "{out:?}");
    let mut scene = elastic(0.3);
    scene.supports = vec![support("y0", FLAT), support("y1", FLAT)];
    scene.supports[1].load.moment = [None, None, Some(1.0)];
    let fault = unsupported(&scene, &mesh_of_square());
    assert!(fault.message.contains("not rubber"), "{fault:?}");
}

fn mesh_of_square() -> Arc<Mesh> {
    mesh(square(2))
}

#[test]
fn a_sleeve_that_is_released_comes_back_to_rest() {
    let mesh = bush_mesh();
    let scene = bush(1.0);
    let pushed = loaded([Some(3.0), None, None], Some(4.0));
    let released = loaded([Some(0.0), None, None], Some(0.0));
    let reports = solve(&scene, &[pushed, released], &mesh);
    reports.iter().for_each(assert_converged);
    let own = reports[1].supports["inner"];
    assert!(
        own.force[0].abs() < 3e-7 && own.moment[2].abs() < 4e-7,
        "{own:?}"
    );
    assert!(
        own.translation[0].abs() < 1e-6 && own.rotation[2].abs() < 1e-6,
        "{own:?}"
    );
}

#[test]
fn a_large_moment_is_reached_in_one_increment() {
    let [by_moment, by_rotation] = both_ways(1.0, loaded([None; 3], Some(20.0)), 1);
    let own = by_moment.supports["inner"];
    assert!(own.rotation[2] > 1.0, "{own:?}");
    assert!(close(own.moment[2], 20.0, 1e-8), "{own:?}");
    assert!(close(by_rotation.supports["inner"].moment[2], 20.0, 1e-7));
}

#[test]
fn a_displacement_ends_a_force_where_it_says() {
    let mesh = bush_mesh();
    let scene = bush(1.0);
    let back = Step {
        supports: vec![SupportTarget {
            name: "inner".to_owned(),
            displacement: [Some(0.0), None, None],
            ..SupportTarget::default()
        }],
        ..Step::default()
    };
    let reports = solve(
        &scene,
        &[loaded([Some(3.0), None, None], None), back],
        &mesh,
    );
    reports.iter().for_each(assert_converged);
    let own = reports[1].supports["inner"];
    assert!(
        own.force[0].abs() < 1e-6 && own.translation[0] == 0.0,
        "{own:?}"
    );
}

#[test]
fn a_moment_about_another_point_ramps_from_what_the_support_exerts_about_it() {
    let mesh = bush_mesh();
    let scene = bush(1.0);
    let led = Step {
        supports: vec![SupportTarget {
            name: "inner".to_owned(),
            translation: Some([0.0, 0.1, 0.0]),
            ..SupportTarget::default()
        }],
        ..Step::default()
    };
    let mut turned = loaded([None; 3], Some(1.0));
    turned.supports[0].about = Some([2.0, 0.0, 0.0]);
    turned.increments = 4;
    let reports = solve(&scene, &[led, turned], &mesh);
    reports.iter().for_each(assert_converged);
    let moments: Vec<f64> = reports[1..]
        .iter()
        .map(|one| one.supports["inner"].moment[2])
        .collect();
    let start = -2.0 * reports[0].supports["inner"].force[1];
    for (part, moment) in (1..).zip(&moments) {
        let expected = start + 0.25 * f64::from(part) * (1.0 - start);
        assert!(close(*moment, expected, 1e-3), "{moments:?} from {start}");
    }
}
