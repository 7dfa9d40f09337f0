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
        numbers("*HYPERELASTIC, VAN DER WAALS\n0.5, 8., 0.2, 0.1, 0.5"),
        (
            "van-der-waals".into(),
            vec![
                one("shear_modulus", 0.5),
                one("locking_stretch", 8.0),
                one("a", 0.2),
                one("beta", 0.1),
                one("bulk_modulus", 4.0)
            ]
        )
    );
    assert_eq!(
        numbers("*HYPERFOAM, N=3\n1., 8., 2., -2., 3., 4., 0.1, 0.\n0.3"),
        (
            "hyperfoam".into(),
            vec![
                ("mu", vec![1.0, 2.0, 3.0]),
                ("alpha", vec![8.0, -2.0, 4.0]),
                ("nu", vec![0.1, 0.0, 0.3])
            ]
        )
    );
    assert_eq!(numbers("*HYPERFOAM\n1., 8.").1[2], one("nu", 0.0));
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
        "*HYPERFOAM, N=7\n1., 2.",
        "*HYPERFOAM, N=2\n1., 2., 3.",
        "*HYPERFOAM\n1., 2., 0.3, 20.",
        "*HYPERELASTIC, OGDEN, N=2\n1., 2., 3.",
        "*HYPERELASTIC, NEO HOOKE",
        "*ELASTIC, TYPE=ORTHOTROPIC\n1., 2.",
        "*ELASTIC\n1., 0.3, 20.\n2., 0.3, 40.",
    ] {
        assert!(law_of(text).unwrap_err().starts_with('*'), "{text}");
    }
}

#[test]
fn a_law_with_test_data_names_the_command_that_fits_it() {
    let told = law_of("*HYPERELASTIC, N=2, TEST DATA INPUT").unwrap_err();
    assert!(told.contains("signorini fit SCENE DATA.csv"), "{told}");
}

const DECK: &str = "*NSET, NSET=point\n900\n*NSET, NSET=floor, GENERATE\n1, 9, 1\n\
    *BOUNDARY\nfloor, ENCASTRE\nside, 1\npoint, 1, 6\n\
    *SURFACE, NAME=plate, TYPE=SEGMENTS\nSTART, 2., 1.\nLINE, -2., 1.\n\
    *SURFACE, NAME=roll, TYPE=CYLINDER\n0., 0., 0., 0., 1., 0.\n1., 0., 0.\nSTART, 0., 2.\n\
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
        point: [0.0, 0.0, -4.0],
        axis: [-1.0, 0.0, 0.0],
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

#[test]
fn elements_of_sections_say_what_the_section_stands_for() {
    for (element, kind) in [
        ("CAX8RH", Some("axisymmetric")),
        ("cps4r", Some("plane-stress")),
        ("CPE3", Some("plane-strain")),
        ("C3D10H", None),
    ] {
        let text = format!("*ELEMENT, TYPE={element}, ELSET=all\n");
        assert_eq!(scene(text.as_bytes()).unwrap().kind, kind, "{element}");
    }
}

fn only_tool(text: &str) -> (DeckScene, Profile) {
    let found = scene(text.as_bytes()).unwrap();
    let [tool] = found.tools.as_slice() else {
        unreachable!("one tool: {:?}", found.left_out);
    };
    let profile = tool.profile;
    (found, profile)
}

#[test]
fn a_swept_line_is_the_plane_of_the_line_and_its_generator() {
    // As a press has them: x to the right, swept to the front or the back, a line at height 3.
    for (generator, local) in [(-1.0, -3.0), (1.0, 3.0)] {
        let (_, plate) = only_tool(&format!(
            "*SURFACE, NAME=plate, TYPE=CYLINDER\n0., 0., 0., 1., 0., 0.\n0., {generator}, 0.\n\
             START, -5., {local}\nLINE, 5., {local}\n"
        ));
        let Profile::Plane { point, normal } = plate else {
            unreachable!("{plate:?}");
        };
        assert_eq!((point[2], normal[0], normal[1]), (3.0, 0.0, 0.0));
        assert!(normal[2] != 0.0);
    }
}

#[test]
fn a_tool_of_an_instance_is_where_the_instance_is_and_has_its_name() {
    let text = "*ASSEMBLY, NAME=a\n*INSTANCE, NAME=plate-1, PART=plate\n0., 0., 7.\n\
        0., 0., 7., 1., 0., 7., 90.\n*NODE, NSET=point\n1, 0., 0., 0.\n\
        *SURFACE, TYPE=CYLINDER, NAME=rigid\nSTART, -5., 2.\nLINE, 5., 2.\n\
        *RIGID BODY, REF NODE=point, ANALYTICAL SURFACE=rigid\n*END INSTANCE\n\
        *NSET, NSET=drive, INSTANCE=plate-1\n1,\n*END ASSEMBLY\n\
        *BOUNDARY, TYPE=DISPLACEMENT\ndrive, 3, 3, -1.\nplate-1.point, 1, 2\n";
    let (found, plate) = only_tool(text);
    let Profile::Plane { point, normal } = plate else {
        unreachable!("{plate:?}");
    };
    // Turned about x: the line at local y = 2 is two above the origin of the instance.
    assert!((point[2] - 9.0).abs() < 1e-12, "{point:?}");
    assert!(normal[0].abs() + normal[1].abs() < 1e-12, "{normal:?}");
    assert_eq!(found.tools[0].name, "plate-1.rigid");
    assert_eq!(found.tools[0].reference.as_deref(), Some("PLATE-1.1"));
    let moved: Vec<&str> = found
        .conditions
        .iter()
        .map(|one| one.set.as_str())
        .collect();
    assert_eq!(moved, ["PLATE-1.1", "PLATE-1.1"]);
}

#[test]
fn axes_that_cannot_be_told_are_left_out_and_numbers_that_are_none_are_refused() {
    let text = "*SURFACE, NAME=s, TYPE=REVOLUTION\nSTART, 0., 1.\nLINE, 5., 1.\n";
    let found = scene(text.as_bytes()).unwrap();
    assert!(found.tools.is_empty());
    assert_eq!(found.left_out[0].0, 1);
    let text = "*MATERIAL, NAME=m\n*HYPERELASTIC, NEO HOOKE\nnan, 0.\n";
    let told = scene(text.as_bytes()).unwrap_err().to_string();
    assert_eq!(
        told,
        "line 3: in *HYPERELASTIC: a finite number is expected, found \"nan\""
    );
}
