//! Values of other codes: by nodes, facets and cells, on supports, tractions and the body.

use std::sync::Arc;

use proptest::prelude::*;
use signorini::scene::{
    SceneError, SceneKind, SupportTarget, Traction, TractionTarget, ValuePlace, Values, Violation,
};
use signorini::{FieldName, GroupKind, Mesh, Plan, Reuse, Scene, Session, Step};

use super::nodal_force::nodes_of;
use crate::common::meshes::{cube, irregular, mesh, square};
use crate::common::scenes::{HELD, elastic, mooney_rivlin, rubber, support, traction};
use crate::common::{close, difference, node_positions, open, run_one, take, values};

type Vector = [f64; 3];

/// Rows for the nodes of a group, at their places.
fn by_nodes(mesh: &Mesh, group: &str, value: impl Fn(Vector) -> Vector) -> Values {
    let places = node_positions(mesh);
    let nodes = nodes_of(mesh, group);
    Values {
        place: ValuePlace::Nodes,
        rows: nodes.iter().map(|&node| value(places[node])).collect(),
        numbers: nodes.iter().map(|&node| node as u32).collect(),
    }
}

/// Rows for the facets of a group, backwards.
fn by_facets(mesh: &Mesh, group: &str, value: Vector) -> Values {
    let facets = mesh.group(group, GroupKind::Facets).expect("a side");
    let mut numbers = facets.members.clone();
    numbers.sort_unstable_by(|a, b| b.cmp(a));
    Values {
        place: ValuePlace::Facets,
        rows: vec![value; numbers.len()],
        numbers,
    }
}

/// The same row everywhere in the body, without numbers.
fn everywhere(place: ValuePlace, count: usize, value: Vector) -> Option<Values> {
    Some(Values {
        place,
        numbers: Vec::new(),
        rows: vec![value; count],
    })
}

fn with_values(on: &str, values: Values) -> Traction {
    Traction {
        name: Some("wind".to_owned()),
        values: Some(values),
        ..traction(on, [0.0; 3])
    }
}

fn displacement(scene: &Scene, step: &Step, mesh: &Arc<Mesh>) -> Vec<f64> {
    let (session, _) = run_one(scene, step, mesh);
    values(&session, FieldName::Displacement)
}

fn held_cube() -> (Scene, Arc<Mesh>) {
    let mut scene = elastic(0.5);
    scene.supports = vec![support("x0", HELD)];
    scene.solver.tolerance = 1e-11;
    (scene, mesh(irregular(cube(3), 3)))
}

#[test]
fn the_same_value_everywhere_is_the_constant() {
    let (mut scene, mesh) = held_cube();
    let (pull, weight) = ([0.1, -0.2, 0.05], [0.02, 0.0, -0.1]);
    let nodes = mesh.vertex_count() + mesh.edges().len();
    scene.tractions = vec![traction("x1", pull)];
    scene.body_force = weight;
    let expected = displacement(&scene, &Step::default(), &mesh);
    let size = expected.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    scene.body_force = [0.0; 3];
    let tractions = [
        by_nodes(&mesh, "x1", |_| pull),
        by_facets(&mesh, "x1", pull),
    ];
    let bodies = [
        everywhere(ValuePlace::Nodes, mesh.vertex_count(), weight),
        everywhere(ValuePlace::Nodes, nodes, weight),
        everywhere(ValuePlace::Cells, mesh.cell_count(), weight),
    ];
    for values in tractions {
        for body in &bodies {
            scene.tractions = vec![with_values("x1", values.clone())];
            scene.body_force_values.clone_from(body);
            let found = displacement(&scene, &Step::default(), &mesh);
            assert!(difference(&found, &expected) < 1e-9 * size);
        }
    }
}

#[test]
fn a_body_of_revolution_turns_its_values_with_it() {
    let mut scene = rubber(mooney_rivlin(), Some(50.0));
    scene.kind = Some(SceneKind::Axisymmetric);
    scene.supports = vec![support("y0", [Some(0.0), Some(0.0), None])];
    scene.tractions = vec![traction("y1", [0.02, -0.1, 0.0])];
    scene.body_force = [0.0, 0.1, 0.0];
    let mesh = mesh(irregular(square(4), 4));
    let expected = displacement(&scene, &Step::default(), &mesh);
    let values = by_nodes(&mesh, "y1", |_| [0.02, -0.1, 0.0]);
    scene.tractions = vec![with_values("y1", values)];
    scene.body_force = [0.0; 3];
    scene.body_force_values = everywhere(ValuePlace::Cells, mesh.cell_count(), [0.0, 0.1, 0.0]);
    let found = displacement(&scene, &Step::default(), &mesh);
    assert!(difference(&found, &expected) < 1e-8);
}

#[test]
fn a_field_of_the_space_on_all_sides_is_the_field_inside() {
    let field = |[x, y, z]: Vector| [0.1 * x + 0.2 * y, -0.05 * y + 0.3 * z, 0.02 * x - 0.05 * z];
    for model in [elastic(0.5), rubber(mooney_rivlin(), Some(100.0))] {
        let mut scene = model;
        let mesh = mesh(irregular(cube(2), 2));
        let is_rubber = scene.materials[0].model.name() != "linear-elastic";
        let factor = if is_rubber { 0.1 } else { 1.0 };
        let field = |x: Vector| field(x).map(|u| factor * u);
        let sides = ["x0", "x1", "y0", "y1", "z0", "z1"];
        scene.supports = sides.map(|side| support(side, HELD)).to_vec();
        for (support, side) in scene.supports.iter_mut().zip(sides) {
            let mut values = by_nodes(&mesh, side, field);
            if side == "y1" {
                // Vertices alone: the middles of edges have the means.
                let first = mesh.vertex_count() as u32;
                let vertices = values.numbers.iter().filter(|&&one| one < first).count();
                values.numbers.truncate(vertices);
                values.rows.truncate(vertices);
            }
            support.values = Some(values);
        }
        let found = displacement(&scene, &Step::default(), &mesh);
        let places = node_positions(&mesh).into_iter();
        let expected: Vec<f64> = places.flat_map(field).collect();
        assert!(difference(&found, &expected) < 1e-8, "{is_rubber}");
    }
}

#[test]
fn varying_loads_have_their_resultants() {
    let (mut scene, mesh) = held_cube();
    // int y (1 - z) over the unit square and int x y over the unit cube.
    let values = by_nodes(&mesh, "x1", |[_, y, z]| [y * (1.0 - z), 0.0, 0.5]);
    scene.tractions = vec![with_values("x1", values)];
    let places = node_positions(&mesh);
    scene.body_force_values = Some(Values {
        place: ValuePlace::Nodes,
        numbers: Vec::new(),
        rows: places.iter().map(|[x, y, _]| [0.0, x * y, 0.0]).collect(),
    });
    let (_, report) = run_one(&scene, &Step::default(), &mesh);
    let reaction = report.supports["x0"].force;
    for (found, expected) in reaction.into_iter().zip([-0.25, -0.25, -0.5]) {
        assert!(close(found, expected, 1e-9), "{reaction:?}");
    }
}

#[test]
fn steps_give_new_values_that_ramp_over_their_increments() {
    let (mut scene, mesh) = held_cube();
    let pull = |by: f64| by_nodes(&mesh, "x1", |[_, y, _]| [by * y, 0.0, 0.0]);
    let shift = |by: f64| by_nodes(&mesh, "x0", |[_, y, _]| [0.0, by * y, 0.0]);
    scene.tractions = vec![Traction {
        name: Some("wind".to_owned()),
        ..traction("x1", [0.0; 3])
    }];
    let step = |by: f64, increments| Step {
        increments,
        tractions: vec![TractionTarget {
            name: "wind".to_owned(),
            values: pull(by),
        }],
        supports: vec![SupportTarget {
            name: "x0".to_owned(),
            values: Some(shift(0.1 * by)),
            ..SupportTarget::default()
        }],
        body_force: everywhere(ValuePlace::Cells, mesh.cell_count(), [0.0, 0.0, by]),
        ..Step::default()
    };
    let mut session = open(&scene, &mesh);
    let mut fields = Vec::new();
    for step in [step(0.4, 2), step(-0.2, 3), Step::default()] {
        let mut run = session.begin_step(&step).expect("a valid step");
        let mut silent = signorini::Silent;
        let cancel = signorini::CancelToken::new();
        while session.advance(&mut run, &mut silent, &cancel).is_some() {
            fields.push(values(&session, FieldName::Displacement));
        }
    }
    // Everything is linear in the values: parts of the first whole.
    let whole = displacement(&scene, &step(1.0, 1), &mesh);
    let parts = [0.2, 0.4, 0.2, 0.0, -0.2, -0.2];
    assert_eq!(fields.len(), parts.len());
    for (found, part) in fields.iter().zip(parts) {
        let expected: Vec<f64> = whole.iter().map(|u| part * u).collect();
        assert!(difference(found, &expected) < 1e-8, "{part}");
    }
}

#[test]
fn a_session_goes_on_from_its_bytes_with_its_values() {
    let (mut scene, mesh) = held_cube();
    let values_of = |by: f64| by_nodes(&mesh, "x1", |[_, y, _]| [by * y, 0.0, 0.0]);
    scene.tractions = vec![with_values("x1", values_of(0.1))];
    let mut session = open(&scene, &mesh);
    take(&mut session, &Step::default());
    let bytes = session.export();
    let plan = Arc::new(session.plan().clone());
    let built = signorini::Prepared::build(&plan, &mesh, &signorini::CancelToken::new());
    let built = Arc::new(built.expect("a solvable scene"));
    let again = Session::import(plan, mesh.clone(), built, Reuse::Built, &bytes);
    let mut again = again.expect("what was exported");
    let step = Step {
        increments: 2,
        body_force: everywhere(ValuePlace::Cells, mesh.cell_count(), [0.0, 0.0, 0.1]),
        ..Step::default()
    };
    for _ in 0..2 {
        take(&mut session, &step);
        take(&mut again, &step);
        let [a, b] = [&session, &again].map(|one| values(one, FieldName::Displacement));
        assert!(a.iter().zip(&b).all(|(a, b)| a.to_bits() == b.to_bits()));
    }
    assert_eq!(session.export(), again.export());
}

fn faults(scene: &Scene, mesh: &Mesh) -> Vec<Violation> {
    match Plan::new(scene, &[], mesh) {
        Err(SceneError::Invalid(faults)) => faults,
        other => panic!("{other:?}"),
    }
}

/// A change of good values, and the words that refuse it.
type Fault = (fn(&mut Values), &'static str);

#[test]
fn wrong_values_are_refused_by_key_number_and_row() {
    let (mut scene, mesh) = held_cube();
    let good = by_nodes(&mesh, "x0", |_| [0.0; 3]);
    let cases: [Fault; 8] = [
        (|one| one.numbers[2] = 4711, "row 2: node 4711 is none of"),
        (|one| one.numbers[3] = one.numbers[0], "has a row already"),
        (|one| one.rows[1][2] = f64::NAN, "must be finite"),
        (|one| one.rows[1][0] = f64::INFINITY, "must be finite"),
        (|one| one.rows.truncate(5), "has 5 rows, but numbers"),
        (|one| one.numbers.clear(), ""),
        (
            |one| {
                one.rows.pop();
                one.numbers.pop();
            },
            "has no row",
        ),
        (|one| one.place = ValuePlace::Cells, "come by cell"),
    ];
    for (change, expected) in cases {
        let mut values = good.clone();
        change(&mut values);
        scene.supports[0].values = Some(values);
        if expected.is_empty() {
            Plan::new(&scene, &[], &mesh).expect("rows in ascending order");
            continue;
        }
        let all = faults(&scene, &mesh);
        assert_eq!(all.len(), 1, "{all:?}");
        assert_eq!(all[0].path, "support.x0.values");
        assert!(all[0].message.contains(expected), "{}", all[0].message);
    }
    scene.supports[0].values = None;
    scene.body_force_values = everywhere(ValuePlace::Facets, 1, [0.0; 3]);
    assert_eq!(faults(&scene, &mesh)[0].path, "body_force.values");
    scene.body_force_values = everywhere(ValuePlace::Cells, 7, [0.0; 3]);
    let message = &faults(&scene, &mesh)[0].message;
    assert!(message.starts_with("has 7 rows; there are"), "{message}");
}

#[test]
fn steps_name_the_tractions_that_the_scene_has() {
    let (mut scene, mesh) = held_cube();
    scene.tractions = vec![Traction {
        name: Some("wind".to_owned()),
        ..traction("x1", [0.0; 3])
    }];
    let session = open(&scene, &mesh);
    let target = |name: &str| Step {
        tractions: vec![TractionTarget {
            name: name.to_owned(),
            values: by_facets(&mesh, "x1", [1.0, 0.0, 0.0]),
        }],
        ..Step::default()
    };
    session.check_step(&target("wind")).expect("a valid step");
    let refused = session.check_step(&target("wnid")).unwrap_err();
    let message = refused.to_string();
    assert!(message.contains("did you mean `wind`"), "{message}");
    let mut step = target("wind");
    step.tractions[0].values.rows[0][1] = f64::NAN;
    let message = session.check_step(&step).unwrap_err().to_string();
    assert!(
        message.starts_with("step.traction.wind.values: facet"),
        "{message}"
    );
}

#[test]
fn values_stand_beside_no_other_variation() {
    let (mut scene, mesh) = held_cube();
    scene.supports[0].values = Some(by_nodes(&mesh, "x0", |_| [0.0; 3]));
    scene.supports[0].displacement = [None; 3];
    scene.supports[0].normal = Some(0.0);
    assert!(faults(&scene, &mesh)[0].message.contains("beside `normal`"));
    let mut flat = elastic(0.5);
    flat.supports = vec![support("y0", [Some(0.0), Some(0.0), None])];
    let mesh = crate::common::meshes::mesh(irregular(square(2), 2));
    flat.supports[0].values = Some(by_nodes(&mesh, "y0", |_| [0.0, 0.0, 1.0]));
    assert!(faults(&flat, &mesh)[0].message.contains("z component"));
    flat.supports[0].values = Some(by_nodes(&mesh, "y0", |_| [0.0; 3]));
    flat.manufactured = Some("polynomial".to_owned());
    let all = faults(&flat, &mesh);
    assert!(all.iter().any(|one| one.path == "manufactured.field"));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn any_values_are_taken_or_refused(
        place in 0..3_usize,
        numbers in prop::collection::vec(0..60_u32, 0..30),
        count in 0..60_usize,
        value in prop::num::f64::ANY,
    ) {
        let mut scene = elastic(0.5);
        scene.supports = vec![support("x0", HELD)];
        let mesh = mesh(cube(1));
        let values = Values {
            place: [ValuePlace::Nodes, ValuePlace::Facets, ValuePlace::Cells][place],
            numbers,
            rows: vec![[value, 0.0, 1.0]; count],
        };
        scene.supports[0].values = Some(values.clone());
        scene.tractions = vec![with_values("x1", values.clone())];
        scene.body_force_values = Some(values);
        if let Err(SceneError::Invalid(all)) = Plan::new(&scene, &[], &mesh) {
            prop_assert!(all.iter().all(|one| one.path.ends_with("values")));
        }
    }
}
