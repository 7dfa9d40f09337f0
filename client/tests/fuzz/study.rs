//! No text makes the readers of studies and their tables panic or take memory beyond a budget.

use std::path::PathBuf;

use crate::fuzz::memory::Budget;
use crate::fuzz::{Campaign, Corpus, Form};
use signorini_client::study::Study;

const WORDS: [&str; 20] = [
    "\n[[grid]]\n",
    "[list]\nfile = \"cases.csv\"\n",
    "[sobol]\npoints = 8\n",
    "[[sobol.range]]\n",
    "key = ",
    "\"mesh_scale\"",
    "values = [",
    "from = ",
    "to = ",
    "count = ",
    "spacing = \"logarithmic\"",
    "9223372036854775807",
    "-1e308",
    "1e308",
    "nan",
    "\"step.99999999999.load\"",
    "[[result]]\nof = \"obstacles.ball.force.z\"\n",
    "of = \"seconds\"",
    "\"\"",
    "\u{feff}",
];

const STUDY: &str = "scene = \"scene.toml\"\nset = [\"mesh_scale=2\"]\n[[grid]]\n\
    key = \"obstacle.ball.shape.radius\"\nvalues = [1.0, 2.0]\n[[grid]]\nkey = \"mesh_scale\"\n\
    from = 1\nto = 4\ncount = 5\nspacing = \"linear\"\n[list]\nfile = \"cases.csv\"\n\
    [sobol]\npoints = 64\nseed = 7\n[[sobol.range]]\nkey = \"material.body.shear_modulus\"\nfrom = 0.1\nto = 10\n\
    spacing = \"logarithmic\"\n[[result]]\nname = \"force\"\nof = \"obstacles.ball.force.z\"\nat = \"max\"\n";

const TABLE: &str = "name,step.0.increments\nfirst,1\n\"the \"\"second\"\"\n\",2\n,\n";

fn place(test: &str) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(test);
    std::fs::create_dir_all(&folder).unwrap();
    let scene = include_str!("../../examples/hertz-sphere.toml");
    std::fs::write(folder.join("scene.toml"), scene).unwrap();
    std::fs::write(folder.join("cases.csv"), TABLE).unwrap();
    folder
}

/// Reads a study and some of its cases; whether it is one.
fn read(text: &str, folder: &std::path::Path) -> bool {
    let study = match Study::read(text, &folder.join("study.toml"), &[]) {
        Ok(study) => study,
        Err(error) => {
            assert!(!error.to_string().is_empty());
            return false;
        }
    };
    for index in [0, study.count() / 2, study.count() - 1] {
        let case = study.case(index).unwrap();
        assert_eq!(case.values.len(), study.keys().len());
        // Refused or read: both are answers.
        study.scene(&case).ok();
    }
    assert!(study.case(study.count()).is_none());
    true
}

/// A tenth of the cases: each writes files.
fn fewer() -> Campaign {
    let all = Campaign::from_environment();
    let cases = all.cases.div_ceil(10);
    Campaign { cases, ..all }
}

#[test]
fn every_study_is_read_or_refused_within_the_budget() {
    let folder = place("fuzz_study");
    assert!(read(STUDY, &folder));
    let example = include_str!("../../examples/studies/hertz.toml");
    let seeds = vec![Vec::from(STUDY), Vec::from(example)];
    let (corpus, budget) = (
        Corpus::new(Form::File, seeds, &WORDS),
        Budget::of_mebibytes(64),
    );
    let mut studies = 0;
    fewer().run(&corpus, |input, _| {
        studies += u32::from(read(&String::from_utf8_lossy(input), &folder));
        budget.check();
    });
    eprintln!("{studies} studies read");
}

#[test]
fn every_table_is_read_or_refused_within_the_budget() {
    let folder = place("fuzz_table");
    let words = [
        "\"", "\"\"", ",", "\r\n", "\n", "[1, 2]", "{", "nan", "name", "\u{feff}", "\0",
    ];
    let corpus = Corpus::new(Form::File, vec![Vec::from(TABLE)], &words);
    let budget = Budget::of_mebibytes(64);
    let study = "scene = \"scene.toml\"\n[list]\nfile = \"cases.csv\"\n";
    assert!(read(study, &folder));
    fewer().run(&corpus, |input, _| {
        std::fs::write(folder.join("cases.csv"), input).unwrap();
        read(study, &folder);
        budget.check();
    });
}
