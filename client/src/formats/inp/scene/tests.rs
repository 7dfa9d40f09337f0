//! Decks with what a scene says, and what it does not.

use super::{DeckScene, Law, Profile, scene};

fn law_of(text: &str) -> Result<Law, String> {
    let text = format!("*MATERIAL, NAME=rubber\n{text}\n");
    let scene = scene(text.as_bytes()).unwrap();
    match scene.laws.into_iter().next() {
        Some((name, law)) => {
            assert_eq!(name, "rubber");
            Ok(law)
        }
        None => Err(scene.left_out[0].1.clone()),
    }
}

fn numbers(text: &str) -> (String, Vec<(&'static str, Vec<f64>)>) {
    let law = law_of(text).unwrap();
    (law.model.to_owned(), law.numbers)
}

#[test]
fn laws_have_the_numbers_of_the_scene() {
    let one = |key, value: f64| (key, vec![value]);
    assert_eq!(
        numbers("*HYPERELASTIC, NEO HOOKE\n0.25, 0.5"),
        (
            "neo-hookean".into(),
            vec![one("shear_modulus", 0.5), one("bulk_modulus", 4.0)]
        )
    );
    assert_eq!(
        numbers("*Hyperelastic, mooney-rivlin\n0.25, 0.125, 0."),
        (
            "mooney-rivlin".into(),
            vec![one("c10", 0.25), one("c01", 0.125)]
        )
    );
    // Abaqus has 2 mu / alpha^2 where the scene has mu / alpha.
    assert_eq!(
        numbers("*HYPERELASTIC, OGDEN, N=2\n0.5, 4., 0.25, -2., 1e-3, 0."),
        (
            "ogden".into(),
            vec![
                ("mu", vec![0.25, -0.25]),
                ("alpha", vec![4.0, -2.0]),
                one("bulk_modulus", 2000.0)
            ]
        )
    );
    assert_eq!(
        numbers("*HYPERELASTIC, N=2, POLYNOMIAL\n1., 2., 3., 4., 5., 0., 0.").1,
        [
            one("c10", 1.0),
            one("c01", 2.0),
            one("c20", 3.0),
            one("c11", 4.0),
            one("c02", 5.0)
        ]
    );
    assert_eq!(numbers("*HYPERELASTIC, YEOH\n1., -2., 3.").1.len(), 3);
    assert_eq!(
        numbers("*HYPERELASTIC, ARRUDA-BOYCE\n1., 5., 0.").0,
        "arruda-boyce"
    );
    assert_eq!(
        numbers("*ELASTIC\n210000., 0.3").1,
        [one("young_modulus", 210_000.0), one("poisson_ratio", 0.3)]
    );
}

#[test]
fn laws_that_the_scene_does_not_have_are_left_out_with_their_line() {
    for text in [
        "*HYPERELASTIC, YEOH\n1., 2., 3., 0.1, 0.2",
        "*HYPERELASTIC, VAN DER WAALS\n1., 2., 3.",
        "*HYPERELASTIC, NEO HOOKE, TEST DATA INPUT",
        "*HYPERELASTIC, OGDEN, N=6\n1., 2.",
        "*HYPERELASTIC, OGDEN, N=2\n1., 2., 3.",
        "*HYPERELASTIC, NEO HOOKE",
        "*ELASTIC, TYPE=ORTHOTROPIC\n1., 2.",
        "*ELASTIC\n1., 0.3, 20.\n2., 0.3, 40.",
    ] {
        assert!(law_of(text).unwrap_err().starts_with('*'), "{text}");
    }
}

const DECK: &str = "*NSET, NSET=point\n900\n*NSET, NSET=floor, GENERATE\n1, 9, 1\n\
    *BOUNDARY\nfloor, ENCASTRE\nside, 1\npoint, 1, 6\n\
    *SURFACE, NAME=plate, TYPE=SEGMENTS\nSTART, 2., 1.\nLINE, -2., 1.\n\
    *SURFACE, NAME=roll, TYPE=CYLINDER\n0., 0., 0., 0., 1., 0.\n0., 0., 1.\nSTART, 0., 2.\n\
    CIRCL, 2., 4., 0., 4.\nCIRCL, 0., 6., 0., 4.\n\
    *RIGID BODY, REF NODE=900, ANALYTICAL SURFACE=plate\n*SURFACE INTERACTION, NAME=dry\n1.,\n\
    *FRICTION\n0.3\n*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=HARD\n\
    *CONTACT PAIR, INTERACTION=Dry\nskin, plate\n*STEP, NLGEOM\n*STATIC\n0.05, 1.\n\
    *BOUNDARY\npoint, 2, 2, -0.4\n*CLOAD\nside, 1, 2.\n*END STEP\n";

#[test]
fn conditions_tools_contacts_and_steps_are_taken_over_and_the_rest_is_listed() {
    let found: DeckScene = scene(DECK.as_bytes()).unwrap();
    let held: Vec<_> = found
        .conditions
        .iter()
        .map(|one| (one.set.as_str(), one.components))
        .collect();
    assert_eq!(held, [("floor", [1, 6]), ("side", [1, 1]), ("900", [1, 6])]);
    let [step] = found.steps.as_slice() else {
        unreachable!("one step");
    };
    assert_eq!(step.increments, 20);
    assert_eq!(
        (step.conditions[0].set.as_str(), step.conditions[0].value),
        ("900", -0.4)
    );
    assert_eq!(found.tools[0].reference.as_deref(), Some("900"));
    let Profile::Plane { point, normal } = found.tools[0].profile else {
        unreachable!("a plane");
    };
    assert_eq!((point, normal), ([2.0, 1.0, 0.0], [0.0, -4.0, 0.0]));
    let roll = Profile::Cylinder {
        point: [0.0, 0.0, 4.0],
        axis: [1.0, 0.0, 0.0],
        radius: 2.0,
    };
    assert_eq!(
        (found.tools[1].profile, &found.tools[1].reference),
        (roll, &None)
    );
    assert_eq!(
        (found.contacts[0].slave.as_str(), found.contacts[0].friction),
        ("skin", 0.3)
    );
    let listed: Vec<&str> = found
        .left_out
        .iter()
        .map(|(_, told)| told.as_str())
        .collect();
    assert_eq!(listed, ["*SURFACE BEHAVIOR", "*CLOAD"]);
}

#[test]
fn profiles_that_turn_about_an_axis_are_planes_cylinders_or_balls() {
    let profile = |parts: &str| {
        let text = format!("*SURFACE, NAME=s, TYPE=REVOLUTION\n0., 0., 1., 0., 0., 2.\n{parts}\n");
        scene(text.as_bytes())
            .unwrap()
            .tools
            .first()
            .map(|tool| tool.profile)
    };
    let Some(Profile::Plane { point, normal }) = profile("START, 0., 3.\nLINE, 5., 3.") else {
        unreachable!("a plane");
    };
    assert_eq!((point, normal), ([0.0, 0.0, 4.0], [0.0, 0.0, 5.0]));
    let ball = Profile::Sphere {
        centre: [0.0, 0.0, 4.0],
        radius: 2.0,
    };
    assert_eq!(profile("START, 0., 1.\nCIRCL, 2., 3., 0., 3."), Some(ball));
    let shaft = profile("START, 2., 0.\nLINE, 2., 5.");
    assert!(
        matches!(shaft, Some(Profile::Cylinder { radius: 2.0, .. })),
        "{shaft:?}"
    );
    assert_eq!(profile("START, 2., 0.\nLINE, 3., 5."), None);
    assert_eq!(profile("START, 2., 0.\nLINE, 3., 0.\nLINE, 3., 1."), None);
}
