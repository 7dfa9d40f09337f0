//! Scene files and the messages they become.

use std::path::Path;

use signorini_proto::v1;

use super::{SceneFile, SceneFileError, read};
use crate::library::error::Violation;

const SMALL: &str = r#"
mesh = "meshes/a.msh"
[material.body]
model = "linear-elastic"
shear_modulus = 1
poisson_ratio = 0.5
"#;

fn parse(text: &str, overrides: &[&str]) -> Result<SceneFile, SceneFileError> {
    let overrides: Vec<_> = overrides.iter().map(|text| text.parse().unwrap()).collect();
    read(text, Path::new("folder/small.toml"), &overrides)
}

fn violations(text: &str) -> Vec<Violation> {
    match parse(text, &[]) {
        Err(SceneFileError::Invalid(violations)) => violations,
        other => unreachable!("{other:?}"),
    }
}

fn fault(addition: &str) -> String {
    violations(&format!("{SMALL}{addition}"))
        .iter()
        .map(ToString::to_string)
        .collect::<Vec<_>>()
        .join("; ")
}

#[test]
fn defaults_come_from_the_file_name() {
    let file = parse(SMALL, &[]).unwrap();
    assert_eq!(file.scene.name, "small");
    assert_eq!(file.mesh, Path::new("folder/meshes/a.msh"));
    assert_eq!(file.scene.kind(), v1::SceneKind::Unspecified);
    assert_eq!(file.scene.solver, None);
}

#[test]
fn a_mesh_that_is_set_is_relative_to_the_working_directory() {
    let file = parse(SMALL, &["mesh=other/b.msh"]).unwrap();
    assert_eq!(file.mesh, Path::new("other/b.msh"));
}

#[test]
fn integers_are_numbers_and_infinities_are_passed_on() {
    let file = parse(
        SMALL,
        &["material.body.poisson_ratio=nan", "mesh_scale=-inf"],
    )
    .unwrap();
    let material = &file.scene.materials[0];
    let Some(v1::material::Model::LinearElastic(law)) = &material.model else {
        unreachable!()
    };
    assert_eq!(
        law.modulus,
        Some(v1::linear_elastic::Modulus::ShearModulus(1.0))
    );
    assert!(law.poisson_ratio.unwrap().is_nan());
    assert_eq!(file.scene.mesh_scale, Some(f64::NEG_INFINITY));
}

#[test]
fn a_tolerance_is_a_number_or_the_discretisation_s() {
    let solver = |text: &str| {
        let text = format!("{SMALL}[solver]\ntolerance = {text}");
        parse(&text, &[]).unwrap().scene.solver.unwrap()
    };
    let number = solver("1e-6");
    assert_eq!(number.tolerance, Some(1e-6));
    assert_eq!(number.tolerance_rule(), v1::ToleranceRule::Unspecified);
    let word = solver("\"discretisation\"");
    assert_eq!(word.tolerance, None);
    assert_eq!(word.tolerance_rule(), v1::ToleranceRule::Discretisation);
    assert_eq!(
        fault("[solver]\ntolerance = \"discretization\""),
        "solver.tolerance: \"discretization\" is not known; did you mean \"discretisation\"?"
    );
    assert_eq!(
        fault("[solver]\ntolerance = true"),
        "solver.tolerance: a number is expected, found true or false"
    );
}

#[test]
fn unknown_keys_suggest_the_nearest() {
    assert_eq!(
        fault("poison_ratio = 0.5"),
        "material.body.poison_ratio: unknown key; did you mean \"poisson_ratio\"?"
    );
    assert_eq!(
        fault("[solver]\ntolerence = 1"),
        "solver.tolerence: unknown key; did you mean \"tolerance\"?"
    );
    assert!(fault("[extra]").starts_with("extra: unknown key; known keys are name, mesh"));
    let turned = fault("[[step]]\nobstacle.ball = { rotation_degrees = [0, 0, 90] }");
    assert!(
        turned.contains("did you mean \"rotation\"? It is in radians"),
        "{turned}"
    );
    let addition = "[[obstacle]]\nname = \"ball\"\non = \"z1\"\nshape = { kind = \"wedge\" }";
    let unknown = fault(addition);
    assert!(
        unknown.contains("known are half-space, sphere, cylinder, ")
            && unknown.ends_with(", height-field, distance-grid"),
        "{unknown}"
    );
    let addition = "[[obstacle]]\nname = \"ball\"\non = \"z1\"\nshape = { kind = \"spere\" }";
    assert_eq!(
        fault(addition),
        "obstacle.ball.shape.kind: \"spere\" is not known; did you mean \"sphere\"?"
    );
}

#[test]
fn lists_longer_than_any_server_takes_are_one_fault_each_and_nobody_looks_into_them() {
    let bad = "[[support]]\nonn = 1\n".repeat(20_000);
    let told = fault(&bad);
    assert_eq!(
        told,
        "support: has 20000 elements; at most 10000 are allowed"
    );
    let names: String = (0..20_000)
        .map(|n| format!("obstacle.o{n} = 1\n"))
        .collect();
    let told = fault(&format!("[[step]]\n{names}"));
    assert_eq!(
        told,
        "step[0].obstacle: has 20000 elements; at most 10000 are allowed"
    );
}

#[test]
fn a_file_full_of_faults_tells_the_first_hundred() {
    let bad = "[[support]]\nonn = 1\n".repeat(10_000);
    let told = violations(&format!("{SMALL}{bad}"));
    assert_eq!(told.len(), 101);
    assert!(
        told[100].message.contains("more than these 100"),
        "{}",
        told[100]
    );
}

#[test]
fn what_is_wrong_with_a_fluid_is_told_with_its_cure() {
    assert_eq!(
        fault("[[fluid]]\nname = \"water\"\non = \"z1\"\nfilm = \"stay\"\nthreshold = \"fluids\""),
        "fluid.water.from: required key is missing; \
         fluid.water.threshold: \"fluids\" is not known; did you mean \"fluid\"?; \
         fluid.water.film: \"stay\" is not known; did you mean \"stays\"?"
    );
    assert_eq!(
        fault("[[step]]\nfluid.water = { pressure = \"to blowoff\", up_to = 5 }"),
        "step[0].fluid.water.pressure: \"to blowoff\" is not known; did you mean \"to blow-off\"?"
    );
    let open = fault("[[step]]\nfluid.water = { pressure = \"to blow-off\" }");
    assert!(
        open.starts_with("step[0].fluid.water.up_to: required key is missing: the pressure at"),
        "{open}"
    );
    assert_eq!(
        fault("[[step]]\nfluid.water = { pressure = 2, up_to = 5 }"),
        "step[0].fluid.water.up_to: goes with pressure = \"to blow-off\" only; leave it out"
    );
    assert_eq!(
        fault("[[step]]\nfluid.water = { up_to = 5 }"),
        "step[0].fluid.water.pressure: required key is missing; \
         step[0].fluid.water.up_to: goes with pressure = \"to blow-off\" only; leave it out"
    );
}

#[test]
fn wrong_types_name_both_types() {
    assert_eq!(
        fault("[[traction]]\non = 3\nvalue = [0, 1]"),
        "traction[0].on: a string or a list of strings is expected, found an integer; \
         traction[0].value: a list of three numbers is expected, found 2: add a third, 0"
    );
    assert_eq!(
        fault("[[step]]\nincrements = 2.5"),
        "step[0].increments: an integer is expected, found a number"
    );
    assert_eq!(
        fault("[[step]]\nincrements = 5000000000"),
        "step[0].increments: 5000000000 is out of range"
    );
    assert_eq!(
        fault("[support]"),
        "support: an array of tables ([[support]], once for each, not [support]) is expected, found a table"
    );
}

#[test]
fn bodies_have_meshes_of_their_own_and_places() {
    let bodies = "[[body]]\nname = \"ring\"\nmesh = \"ring.msh\"\ntranslation = [1, 2, 0]\nmesh_scale = 2\n\
                  [[body]]\nmesh = \"/shell.msh\"\nrotation = [0, 0, 0.5]\n";
    let file = parse(bodies, &[]).unwrap();
    assert_eq!(file.mesh, Path::new(""));
    let [ring, shell] = &file.bodies[..] else {
        panic!("{:?}", file.bodies);
    };
    assert_eq!(
        (ring.name.as_str(), shell.name.as_str()),
        ("ring", "body-2")
    );
    assert_eq!(ring.mesh, Path::new("folder/ring.msh"));
    assert_eq!(shell.mesh, Path::new("/shell.msh"));
    assert_eq!(ring.placement.scale.to_bits(), 2.0_f64.to_bits());
    assert_eq!(
        ring.placement.translation.map(f64::to_bits),
        [1.0_f64, 2.0, 0.0].map(f64::to_bits)
    );
    assert_eq!(shell.placement.rotation[2].to_bits(), 0.5_f64.to_bits());
    let faults: Vec<_> = violations(&format!(
        "mesh = \"a.msh\"\nmesh_scale = 2\n{bodies}{bodies}"
    ))
    .into_iter()
    .map(|fault| fault.path)
    .collect();
    assert_eq!(faults, ["mesh", "mesh_scale", "body.ring.name"]);
}

#[test]
fn an_empty_scene_misses_its_mesh() {
    let faults = violations("");
    assert_eq!(
        faults,
        [Violation {
            path: "mesh".into(),
            message: "required key is missing".into()
        }]
    );
}

#[test]
fn missing_keys_are_all_reported() {
    let addition =
        "[[support]]\nname = \"base\"\n[[obstacle]]\n[material.core]\nmodel = \"linear-elastic\"";
    let paths: Vec<_> = violations(&format!("{SMALL}{addition}"))
        .into_iter()
        .map(|fault| fault.path)
        .collect();
    assert_eq!(
        paths,
        [
            "material.core.shear_modulus",
            "material.core.poisson_ratio",
            "support.base.displacement",
            "support.base.on",
            "obstacle[0].on",
            "obstacle[0].shape",
        ]
    );
}

#[test]
fn two_moduli_contradict_each_other() {
    assert!(fault("young_modulus = 3").starts_with("material.body.young_modulus: give either"));
}

#[test]
fn text_that_is_not_toml_is_a_syntax_error_with_its_line() {
    let error = parse("mesh = \n", &[]).unwrap_err();
    assert!(matches!(error, SceneFileError::Syntax(_)));
    assert!(error.to_string().contains("line 1"), "{error}");
}

#[test]
fn every_key_of_the_contract_reaches_the_message() {
    let text = include_str!("every_key.toml");
    let scene = parse(text, &[]).unwrap().scene;
    assert_eq!(scene.kind(), v1::SceneKind::Solid);
    assert_eq!(scene.materials.len(), 12);
    assert!(
        scene
            .materials
            .iter()
            .all(|material| material.model.is_some())
    );
    assert_eq!(
        scene
            .supports
            .iter()
            .map(|support| support.name.as_str())
            .collect::<Vec<_>>(),
        ["base", "support-2", "skin", "sleeve"]
    );
    assert_eq!(scene.supports[1].normal, Some(0.0));
    let load = scene.supports[3].load.as_ref().expect("a load");
    let named = [
        load.force,
        load.moment,
        load.stiffness,
        load.rotational_stiffness,
    ];
    assert!(named.iter().all(Option::is_some) && load.about.len() == 3);
    assert_eq!(
        (
            scene.tractions.len(),
            scene.pressures.len(),
            scene.body_force.len()
        ),
        (2, 1, 3)
    );
    let names: Vec<&str> = scene.fluids.iter().map(|one| one.name.as_str()).collect();
    assert_eq!(names, ["water", "fluid-2"]);
    let thresholds = [0, 1].map(|index: usize| scene.fluids[index].threshold);
    assert_eq!(thresholds, [Some(0.25), None]);
    let films = [0, 1].map(|index: usize| scene.fluids[index].film());
    assert_eq!(films, [v1::Film::SqueezedOut, v1::Film::Stays]);
    assert_eq!(scene.obstacles.len(), 10);
    assert!(scene.obstacles.iter().all(|obstacle| {
        obstacle
            .shape
            .as_ref()
            .is_some_and(|shape| shape.kind.is_some())
    }));
    assert!(scene.obstacles[1].shape.as_ref().unwrap().inside);
    let files = parse(text, &[]).unwrap().surfaces;
    let files: Vec<_> = files
        .iter()
        .map(|(at, path)| (*at, path.to_str()))
        .collect();
    let expected = [
        "folder/a.stl",
        "folder/heights.grid",
        "folder/distances.grid",
    ]
    .map(Some);
    assert_eq!(
        files,
        [7, 8, 9].into_iter().zip(expected).collect::<Vec<_>>()
    );
    let values = parse(text, &[]).unwrap().values;
    let values: Vec<_> = values
        .iter()
        .map(|one| (one.key.as_str(), one.path.to_str().unwrap()))
        .collect();
    let expected = [
        ("support.skin.values", "folder/skin.csv"),
        ("traction.wind.values", "folder/wind.csv"),
        ("body_force.values", "folder/weights.csv"),
        ("step[0].support.skin.values", "folder/skin-2.csv"),
        ("step[0].traction.wind.values", "folder/wind-2.csv"),
        ("step[0].body_force.values", "folder/weights-2.csv"),
    ];
    assert_eq!(values, expected);
    assert_eq!(
        (scene.obstacles[0].friction, scene.obstacles[1].tresca),
        (Some(0.3), Some(2.0))
    );
    let surfaces = [0, 1].map(|index: usize| scene.obstacles[index].surface());
    let unsaid = v1::SurfaceGeometry::Unspecified;
    assert_eq!(surfaces, [unsaid, v1::SurfaceGeometry::Smooth]);
    let policies = [0, 1].map(|index: usize| scene.obstacles[index].initial_penetration());
    let unsaid = v1::InitialPenetration::Unspecified;
    assert_eq!(policies, [unsaid, v1::InitialPenetration::Reject]);
    assert_eq!(scene.manufactured, "A1m");
    let step = &scene.steps[0];
    assert_eq!((step.increments, step.load), (Some(4), Some(0.5)));
    assert_eq!(step.obstacles[0].translation, [0.0, 0.0, -0.05]);
    assert_eq!(
        step.obstacles[1].force,
        Some(v1::Components {
            x: None,
            y: None,
            z: Some(-1.0)
        })
    );
    assert_eq!(step.supports[0].rotation, [0.0, 0.0, 7.0]);
    let mut loads: Vec<_> = step
        .fluids
        .iter()
        .map(|one| (&*one.name, one.load))
        .collect();
    loads.sort_by_key(|(name, _)| *name);
    use v1::fluid_target::Load;
    let expected = [
        ("fluid-2", Some(Load::ToBlowOff(50.0))),
        ("water", Some(Load::Pressure(3.0))),
    ];
    assert_eq!(loads, expected);
    let solver = scene.solver.unwrap();
    assert_eq!(
        (solver.tolerance, solver.quadrature_degree, solver.penalty),
        (Some(1e-9), Some(8), Some(2.0))
    );
    assert_eq!(solver.displacement_preconditioner, "p-multigrid");
    assert_eq!(solver.error_estimate, "off");
    assert_eq!(scene.probes[0].point, [0.0, 1.0, 2.0]);
    let output = scene.output.unwrap();
    assert_eq!((output.fields, output.every), ((1..=17).collect(), Some(2)));
}

#[test]
fn rows_of_files_reach_the_places_that_name_them() {
    let folder = std::env::temp_dir().join(format!("signorini-values-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.join(name), text).unwrap();
    let text = include_str!("every_key.toml");
    let names = ["skin", "wind", "weights", "skin-2", "wind-2", "weights-2"];
    for (row, name) in names.iter().enumerate() {
        write(
            &format!("{name}.csv"),
            &format!("node, x, y, z\n{row}, 1, 2, 3\n"),
        );
    }
    let mut file = read(text, &folder.join("every.toml"), &[]).unwrap();
    super::read_values(&mut file).unwrap();
    let scene = &file.scene;
    let step = &scene.steps[0];
    let found = [
        &scene.supports[2].values,
        &scene.tractions[1].values,
        &scene.body_force_values,
        &step
            .supports
            .iter()
            .find(|one| one.name == "skin")
            .unwrap()
            .values,
        &step.tractions[0].values,
        &step.body_force,
    ];
    for (row, values) in (0..).zip(found) {
        let values = values.as_ref().expect("rows");
        let number: Vec<i32> = signorini_proto::array::decode(&values.numbers).unwrap();
        assert_eq!((number, values.rows.len()), (vec![row], 24));
    }
    write("wind-2.csv", "node, x, y, z\n4711, 1, nan, 3\n");
    std::fs::remove_file(folder.join("skin.csv")).unwrap();
    let mut file = read(text, &folder.join("every.toml"), &[]).unwrap();
    let faults = super::read_values(&mut file).unwrap_err();
    let paths: Vec<&str> = faults.iter().map(|fault| fault.path.as_str()).collect();
    assert_eq!(
        paths,
        ["support.skin.values", "step[0].traction.wind.values"]
    );
    let why = &faults[1].message;
    assert!(why.contains("wind-2.csv: line 2: node 4711:"), "{why}");
    std::fs::remove_dir_all(folder).unwrap();
}

#[test]
fn goals_and_parameters_are_a_name_or_a_list() {
    let text = format!(
        "{SMALL}[accuracy]\nbound = \"force.lid.y\"\n[[gradient]]\nof = [\"force.lid.y\"]\nto = \"load\"\n"
    );
    let scene = parse(&text, &[]).unwrap().scene;
    assert_eq!(scene.accuracy.unwrap().bound, ["force.lid.y"]);
    assert_eq!(
        (&scene.gradients[0].of[0], &scene.gradients[0].to[0]),
        (&"force.lid.y".to_owned(), &"load".to_owned())
    );
    assert_eq!(scene.gradients[0].at(), v1::AskedAt::Unspecified);
    let all = text.replace("to =", "at = \"increments\"\nto =");
    let gradients = parse(&all, &[]).unwrap().scene.gradients;
    assert_eq!(gradients[0].at(), v1::AskedAt::Increments);
    assert_eq!(
        fault("[accuracy]\nbound = \"force.lid.y\"\nat = \"end\"\n"),
        "accuracy.at: \"end\" is not known; known are steps, increments"
    );
    assert_eq!(
        fault("[[gradient]]\nof = \"load\"\n"),
        "gradient[0].to: required key is missing"
    );
}

#[test]
fn tolerances_of_goals_are_read_with_and_without_axis() {
    let text = format!(
        "{SMALL}[accuracy]\nforce.lid = 0.01\nforce.\"left.wall\".x = 0.02\nreaction.base = {{ x = 1, y = 2 }}\nmax_unknowns = 2e6\n"
    );
    let accuracy = parse(&text, &[]).unwrap().scene.accuracy.unwrap();
    let targets = accuracy
        .targets
        .iter()
        .map(|one| (one.goal.as_str(), one.tolerance));
    let targets: Vec<_> = targets.collect();
    let expected = [
        ("force.left.wall.x", 0.02),
        ("force.lid", 0.01),
        ("reaction.base.x", 1.0),
        ("reaction.base.y", 2.0),
    ];
    assert_eq!(targets, expected);
    assert_eq!(accuracy.max_unknowns, Some(2_000_000));
    for (wrong, key) in [
        ("force.lid = 0", "accuracy.force.lid"),
        ("reaction.base = 0.1", "accuracy.reaction.base"),
        ("force.lid.w = 0.1", "accuracy.force.lid.w"),
        ("max_unknowns = 0", "accuracy.max_unknowns"),
    ] {
        let told = fault(&format!("[accuracy]\n{wrong}\n"));
        assert!(told.starts_with(key), "{told}");
    }
}
