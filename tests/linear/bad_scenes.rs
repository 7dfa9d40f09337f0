//! Every fault of a scene is refused with the path of its key.

use crate::common::meshes::{cube, mesh};
use crate::common::refusals::{assert_refused, block, sphere, violations, with_ball};
use crate::common::scenes::{HELD, cube_bend, elastic, probe, support, traction};
use signorini::scene::{Formulation, MaterialModel, Modulus, Shape};
use signorini::{Plan, Scene};
#[test]
fn unknown_groups_get_the_nearest_name() {
    let mut scene = cube_bend(0.5);
    scene.supports[0].on = vec!["xO".to_owned()];
    assert_refused(&scene, "support.x0.on", &["`xO`", "did you mean `x0`"]);
    let mut scene = cube_bend(0.5);
    scene.tractions[0].on = vec!["right".to_owned()];
    assert_refused(
        &scene,
        "traction[0].on",
        &["`right`", "x0, x1, y0, y1, z0, z1"],
    );
    let mut scene = cube_bend(0.5);
    scene.materials[0].group = "bod".to_owned();
    assert_refused(&scene, "material.bod", &["did you mean `body`"]);
    // A surface group is no group of cells.
    scene.materials[0].group = "x0".to_owned();
    assert_refused(&scene, "material.x0", &["no group of cells", "body"]);
}

#[test]
fn material_parameters_have_ranges() {
    for poisson_ratio in [0.6, -1.0, f64::NAN, f64::INFINITY] {
        let path = "material.body.poisson_ratio";
        assert_refused(&cube_bend(poisson_ratio), path, &["at most 0.5"]);
    }
    for (value, key) in [
        (0.0, "shear"),
        (-1.0, "young"),
        (f64::NAN, "shear"),
        (f64::INFINITY, "young"),
    ] {
        let mut scene = cube_bend(0.5);
        let MaterialModel::LinearElastic { modulus, .. } = &mut scene.materials[0].model else {
            unreachable!("the cube is elastic");
        };
        *modulus = match key {
            "shear" => Modulus::Shear(value),
            _ => Modulus::Young(value),
        };
        let path = format!("material.body.{key}_modulus");
        assert_refused(&scene, &path, &["above zero and finite"]);
    }
    let mut scene = cube_bend(0.5);
    let MaterialModel::LinearElastic { formulation, .. } = &mut scene.materials[0].model else {
        unreachable!("the cube is elastic");
    };
    *formulation = Formulation::Displacement;
    assert_refused(&scene, "material.body.formulation", &["mixed"]);
}

#[test]
fn every_cell_needs_one_material() {
    let mut scene = cube_bend(0.5);
    scene.materials.clear();
    assert_refused(&scene, "material", &["no material"]);
    let mut parts = cube(2);
    parts.groups[0].members.pop();
    let found = violations(&cube_bend(0.5), &[], &mesh(parts));
    assert!(
        found[0].message.contains("1 cells have no material"),
        "{found:?}"
    );
}

#[test]
fn shapes_need_sizes_and_directions() {
    for radius in [-1.0, 0.0, f64::NAN, f64::INFINITY] {
        assert_refused(
            &with_ball(sphere(radius)),
            "obstacle.ball.shape.radius",
            &["radius"],
        );
    }
    let plane = |normal| Shape::HalfSpace {
        point: [0.0, 0.0, 2.0],
        normal,
    };
    for normal in [[0.0; 3], [0.0, f64::NAN, 1.0]] {
        assert_refused(
            &with_ball(plane(normal)),
            "obstacle.ball.shape.normal",
            &["normal"],
        );
    }
    let cylinder = Shape::Cylinder {
        point: [0.0, f64::INFINITY, 0.0],
        axis: [1.0, 0.0, 0.0],
        radius: 1.0,
    };
    assert_refused(
        &with_ball(cylinder),
        "obstacle.ball.shape.point",
        &["not finite"],
    );
}

#[test]
fn numbers_must_be_finite() {
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let mut scene = cube_bend(0.5);
        scene.supports[0].displacement[1] = Some(bad);
        scene.tractions[0].value[2] = bad;
        scene.body_force[0] = bad;
        scene.probes[0].point[0] = bad;
        scene.mesh_scale = Some(bad);
        scene.solver.tolerance = bad;
        scene.solver.max_wall_time = Some(bad);
        let paths = [
            "support.x0.displacement",
            "traction[0].value",
            "body_force.value",
            "probe.corner.point",
            "mesh_scale",
            "solver.tolerance",
            "solver.max_wall_time",
        ];
        for path in paths {
            assert_refused(&scene, path, &[]);
        }
    }
}

#[test]
fn several_faults_are_reported_together() {
    let mut scene = with_ball(sphere(-1.0));
    scene.materials = vec![crate::common::scenes::material(Modulus::Shear(-1.0), 0.7)];
    scene.supports[0].on = vec!["bottom".to_owned()];
    let found = violations(&scene, &[], &block());
    let paths: Vec<&str> = found
        .iter()
        .map(|violation| violation.path.as_str())
        .collect();
    for path in [
        "material.body.shear_modulus",
        "material.body.poisson_ratio",
        "support.z0.on",
        "obstacle.ball.shape.radius",
    ] {
        assert!(paths.contains(&path), "{paths:?}");
    }
}

#[test]
fn a_candidate_face_must_be_able_to_move() {
    let mut scene = with_ball(sphere(1.0));
    scene.supports.push(support("z1", HELD));
    assert_refused(&scene, "obstacle.ball.on", &["hold all its components"]);
    // Several supports can do it together.
    scene.supports[1].displacement = [Some(0.0), None, Some(0.0)];
    scene.supports.push(support("z1", [None, Some(0.0), None]));
    scene.supports[2].name = "second".to_owned();
    assert_refused(&scene, "obstacle.ball.on", &["hold all its components"]);
}

#[test]
fn free_rigid_modes_are_named() {
    let mut scene = elastic(0.5);
    scene.tractions = vec![traction("z1", [0.0, 0.0, 1.0])];
    let all = [
        "translation along x",
        "translation along z",
        "rotation about y",
    ];
    assert_refused(&scene, "support", &all);
    scene.supports = vec![support("x0", [Some(0.0), None, None])];
    let message = &violations(&scene, &[], &block())[0].message;
    for word in [
        "translation along y",
        "translation along z",
        "rotation about x",
    ] {
        assert!(message.contains(word), "{message}");
    }
    assert!(
        !message.contains("rotation about z") && !message.contains("along x"),
        "{message}"
    );
}

#[test]
fn names_are_unique_and_groups_not_empty() {
    let mut scene = cube_bend(0.5);
    scene.supports.push(support("x0", HELD));
    assert_refused(&scene, "support[1].name", &["used twice"]);
    let mut scene = cube_bend(0.5);
    scene.supports[0].on.clear();
    assert_refused(&scene, "support.x0.on", &["names no group"]);
    let mut scene = cube_bend(0.5);
    scene.supports[0].displacement = [None; 3];
    assert_refused(&scene, "support.x0.displacement", &["holds no component"]);
}

#[test]
fn manufactured_fields_have_names_and_conditions() {
    let mut scene = elastic(0.5);
    scene.supports = vec![support("x0", HELD)];
    scene.manufactured = Some("A1n".to_owned());
    assert_refused(
        &scene,
        "manufactured.field",
        &["`A1n`", "did you mean `A1m`"],
    );
    scene.manufactured = Some("vortex".to_owned());
    assert_refused(&scene, "manufactured.field", &["in 3 dimensions"]);
    scene.manufactured = Some("A1m".to_owned());
    scene.body_force = [1.0, 0.0, 0.0];
    assert_refused(&scene, "manufactured.field", &["its own loads"]);
}

#[test]
fn probes_must_lie_in_the_body() {
    let mut scene = cube_bend(0.5);
    scene.probes = vec![probe("far", [2.0, 0.5, 0.5])];
    assert_refused(&scene, "probe.far.point", &["outside the body"]);
    scene.mesh_scale = Some(4.0);
    assert!(Plan::new(&scene, &[], &block()).is_ok());
}

#[test]
fn an_empty_scene_says_what_it_needs() {
    let found = violations(&Scene::default(), &[], &block());
    let paths: Vec<&str> = found
        .iter()
        .map(|violation| violation.path.as_str())
        .collect();
    assert_eq!(paths, ["material", "support"]);
}

#[test]
fn sizes_whose_volume_leaves_the_range_of_numbers_are_refused() {
    for scale in [1e160, 1e-200] {
        let mut scene = cube_bend(0.5);
        scene.probes.clear();
        scene.mesh_scale = Some(scale);
        assert_refused(&scene, "mesh_scale", &["range of numbers"]);
    }
}

#[test]
fn supports_that_contradict_each_other_are_warned_of() {
    let mut scene = cube_bend(0.5);
    let plan = |scene: &Scene| {
        Plan::new(scene, &[], &block())
            .expect("a valid scene")
            .report()
    };
    scene.supports.push(signorini::scene::Support {
        name: "again".to_owned(),
        ..support("x0", HELD)
    });
    assert!(plan(&scene).warnings.is_empty());
    scene.supports.push(signorini::scene::Support {
        name: "shifted".to_owned(),
        ..support("x0", [Some(0.5), None, None])
    });
    let warnings = plan(&scene).warnings;
    assert!(
        warnings
            .iter()
            .any(|w| w.contains("shifted") && w.contains("holds")),
        "{warnings:?}"
    );
}

#[test]
fn a_manufactured_field_takes_no_values_of_supports() {
    let mut scene = cube_bend(0.5);
    scene.tractions.clear();
    scene.manufactured = Some("A1m".to_owned());
    scene.supports[0].displacement[0] = Some(3.0);
    assert_refused(&scene, "support.x0.displacement", &["manufactured"]);
}

#[test]
fn a_scene_that_names_far_more_than_its_mesh_has_is_refused_before_it_is_copied() {
    let mut scene = elastic(0.5);
    scene.supports = vec![support("z0", HELD)];
    scene.supports[0].on = vec!["z0".to_owned(); 20_000];
    assert_refused(&scene, "on", &["160000 facets", "at most"]);
    scene.supports[0].on = vec!["z0".to_owned(); 100_001];
    assert_refused(&scene, "on", &["100001 groups", "at most 100000"]);
}
