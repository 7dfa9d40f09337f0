//! No text makes the reader of scene files panic or take memory beyond its budget.

use std::path::Path;

use crate::fuzz::memory::Budget;
use crate::fuzz::{Campaign, Corpus, Form};
use fastrand::Rng;
use prost::Message;
use signorini_client::scene_file::{self, Override};

const WORDS: [&str; 24] = [
    "[",
    "]",
    "[[",
    "]]",
    "{",
    "}",
    "\"",
    "\"\"\"",
    "'",
    "#",
    "=",
    ".",
    ",",
    "\n[obstacle]\n",
    "[[step]]\n",
    "[[support]]\n",
    "[material.body]\n",
    "shape = {",
    "kind = ",
    "on = [",
    "1979-05-27T07:32:00Z",
    "\u{feff}",
    "\\uD800",
    "a.a.a.a.a.a.a.a.",
];

const CHANGES: [&str; 10] = [
    "mesh=b.msh",
    "obstacle.ball.shape.radius=2",
    "step.0.increments=4",
    "step.9223372036854775808.load=1",
    "material.a.poisson_ratio=nan",
    "solver=[]",
    "probe.0.point.1=[[[[[[1]]]]]]",
    "a.b.c.d.e.f=\"\"\"",
    "support.base.on.0={}",
    "step.1={",
];

fn corpus() -> Corpus {
    let seeds = [
        include_str!("../../src/scene_file/every_key.toml"),
        include_str!("../../examples/cook.toml"),
        include_str!("../../examples/cube-bend.toml"),
        include_str!("../../examples/hertz-plane.toml"),
        include_str!("../../examples/hertz-sphere.toml"),
        include_str!("../../examples/manufactured.toml"),
        include_str!("../../examples/stokes-cylinder.toml"),
    ];
    Corpus::new(Form::File, seeds.map(Vec::from).into(), &WORDS)
}

fn changes(rng: &mut Rng) -> Vec<Override> {
    let wanted = rng.usize(..6).saturating_sub(3);
    let texts = std::iter::repeat_with(|| CHANGES[rng.usize(..CHANGES.len())]);
    texts
        .take(wanted)
        .filter_map(|text| text.parse().ok())
        .collect()
}

#[test]
fn every_text_is_read_or_refused_within_the_budget() {
    let (corpus, budget) = (corpus(), Budget::of_mebibytes(64));
    let (mut read, mut refused) = (0_u64, 0_u64);
    Campaign::from_environment().run(&corpus, |input, rng| {
        let text = String::from_utf8_lossy(input);
        match scene_file::read(&text, Path::new("folder/scene.toml"), &changes(rng)) {
            Ok(file) => {
                read += 1;
                let bytes = file.scene.encode_to_vec();
                let again = signorini_proto::v1::Scene::decode(&bytes[..]).unwrap();
                // As bytes, for NaN is not equal to itself.
                assert_eq!(again.encode_to_vec(), bytes);
            }
            Err(error) => {
                refused += 1;
                assert!(!error.to_string().is_empty());
            }
        }
        budget.check();
    });
    eprintln!("{read} texts read, {refused} refused");
    // Changes that only ever break the form would test nothing behind it.
    assert!(read > 0 || refused < 1000);
}

#[test]
fn every_override_is_read_or_refused() {
    let corpus = Corpus::new(Form::File, CHANGES.map(Vec::from).into(), &WORDS);
    let budget = Budget::of_mebibytes(64);
    Campaign::from_environment().run(&corpus, |input, _| {
        let text = String::from_utf8_lossy(input);
        if let Ok(change) = text.parse::<Override>() {
            let every_key = include_str!("../../src/scene_file/every_key.toml");
            scene_file::read(every_key, Path::new("scene.toml"), &[change]).ok();
        }
        budget.check();
    });
}
