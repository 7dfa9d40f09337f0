//! A deck of a block on the ground under a plate, as a scene.

use std::path::Path;

use signorini_client::formats::inp;
use signorini_client::scene_file;
use signorini_proto::v1;
use signorini_proto::v1::material::Model;
use signorini_proto::v1::shape::Kind;

use crate::commands::scene_draft::draft;

const DECK: &str = "*NODE\n1, 0., 0.\n2, 1., 0.\n3, 1., 1.\n4, 0., 1.\n*ELEMENT, TYPE=CPE4RH, ELSET=block\n\
    1, 1, 2, 3, 4\n*NSET, NSET=ground\n1, 2\n*NSET, NSET=left side\n1, 4\n*NSET, NSET=inside\n3\n\
    *SURFACE, NAME=lid\n1, S3\n*SOLID SECTION, ELSET=block, MATERIAL=Rubber\n\
    *MATERIAL, NAME=rubber\n*HYPERELASTIC, MOONEY-RIVLIN\n0.4, 0.1, 0.002\n\
    *SURFACE, NAME=plate, TYPE=SEGMENTS\nSTART, -2., 1.\nLINE, 3., 1.\n\
    *RIGID BODY, REF NODE=99, ANALYTICAL SURFACE=plate\n\
    *SURFACE INTERACTION, NAME=i\n*FRICTION\n0.2\n*CONTACT PAIR, INTERACTION=i\nlid, plate\n\
    *BOUNDARY\nground, ENCASTRE\ninside, 1\n99, 1, 6\n\
    *STEP\n*STATIC\n0.1, 1.\n*BOUNDARY\n99, 2, 2, -0.1\nleft side, 1\n*DLOAD\nblock, P1, 3.\n*END STEP\n\
    *STEP\n*STATIC\n*BOUNDARY\n99, 1, 1, 0.05\nleft side, 1, 1, 0.01\nground, 6, 6, 0.5\n*END STEP\n";

fn drafted(deck: &str) -> (String, v1::Scene) {
    let mesh = inp::read(deck.as_bytes()).unwrap();
    let found = inp::read_scene(deck.as_bytes(), &mut |_| Err(String::new())).unwrap();
    let text = draft(&mesh, "block.inp", Some(&found));
    let scene = scene_file::read(&text, Path::new("draft.toml"), &[]);
    let scene = scene.unwrap_or_else(|error| unreachable!("{error}\n{text}"));
    (text, scene.scene)
}

#[test]
fn a_deck_becomes_the_scene_that_it_describes() {
    let (text, scene) = drafted(DECK);
    assert_eq!(scene.materials[0].group, "Rubber");
    let law = v1::MooneyRivlin {
        c10: Some(0.4),
        c01: Some(0.1),
        bulk_modulus: Some(1000.0),
    };
    assert_eq!(scene.materials[0].model, Some(Model::MooneyRivlin(law)));
    let held: Vec<_> = scene
        .supports
        .iter()
        .map(|one| (one.name.as_str(), one.displacement))
        .collect();
    let components = |x, y| Some(v1::Components { x, y, z: None });
    let expected = [
        ("ground", components(Some(0.0), Some(0.0))),
        ("left side", components(Some(0.0), None)),
    ];
    assert_eq!(held, expected);
    let [plate] = scene.obstacles.as_slice() else {
        unreachable!("{text}");
    };
    assert_eq!((plate.on[0].as_str(), plate.friction), ("lid", Some(0.2)));
    let Some(Kind::HalfSpace(plane)) = plate.shape.as_ref().and_then(|shape| shape.kind.as_ref())
    else {
        unreachable!("{text}");
    };
    // The body is below: the line of the deck goes the other way round.
    assert!(plane.normal[1] < 0.0, "{text}");
    assert_eq!(scene.steps.len(), 2);
    assert_eq!(
        (scene.steps[0].increments, scene.steps[1].increments),
        (Some(10), Some(10))
    );
    assert_eq!(scene.steps[0].obstacles[0].translation, [0.0, -0.1, 0.0]);
    assert_eq!(scene.steps[1].obstacles[0].translation, [0.05, -0.1, 0.0]);
    assert_eq!(
        scene.steps[1].supports[0].displacement,
        components(Some(0.01), None)
    );
}

#[test]
fn what_is_not_taken_over_is_listed_with_its_line() {
    let (text, _) = drafted(DECK);
    let line = |word: &str| 1 + DECK.lines().position(|line| line == word).unwrap();
    let listed: Vec<&str> = text
        .split_once("# Not taken over of the deck:\n")
        .unwrap()
        .1
        .lines()
        .collect();
    let expected = [
        format!(
            "# line {}: *BOUNDARY: inside is no group of facets",
            line("inside, 1")
        ),
        format!("# line {}: *DLOAD", line("*DLOAD")),
        format!(
            "# line {}: *BOUNDARY in step 2: ground",
            line("ground, 6, 6, 0.5")
        ),
    ];
    assert_eq!(listed, expected);
}

#[test]
fn a_deck_of_a_mesh_alone_is_drafted_like_any_mesh() {
    let (mesh, _) = DECK.split_once("*MATERIAL").unwrap();
    let (text, scene) = drafted(mesh);
    assert_eq!(
        (scene.supports.len(), scene.obstacles.len()),
        (1, 1),
        "{text}"
    );
    assert!(!text.contains("Not taken over"), "{text}");
}

#[test]
fn a_law_that_is_not_taken_over_is_asked_for_and_never_made_up() {
    let deck = DECK.replace("MOONEY-RIVLIN", "N=2, TEST DATA INPUT");
    let mesh = inp::read(deck.as_bytes()).unwrap();
    let found = inp::read_scene(deck.as_bytes(), &mut |_| Err(String::new())).unwrap();
    let text = draft(&mesh, "block.inp", Some(&found));
    let told = match scene_file::read(&text, Path::new("draft.toml"), &[]) {
        Ok(_) => unreachable!("{text}"),
        Err(error) => error.to_string(),
    };
    assert!(told.contains("material.Rubber.model"), "{told}");
}
