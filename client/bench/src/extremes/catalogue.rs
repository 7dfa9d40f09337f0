//! What is tried: the files of `rows/`, one a family, each row a scene with a body and what is
//! known of its result without this solver.
//!
//! Nothing in it is a number that this solver gave: what is expected is a closed form,
//! the number of another solver, the same body by another path, or a statement about
//! the body that follows from mechanics. A row without any says so.

use std::collections::BTreeMap;

use serde::Deserialize;

use super::body::Body;
use super::of_tests::OF_TESTS;

/// One file a family, in the order of the page.
const ROWS: &[&str] = &[
    include_str!("rows/poisson-ratio-to-1-2.toml"),
    include_str!("rows/stiffness-contrast.toml"),
    include_str!("rows/aspect-ratio-and-slivers.toml"),
    include_str!("rows/thin-layers.toml"),
    include_str!("rows/confined-rubber.toml"),
    include_str!("rows/closed-and-full-bodies.toml"),
    include_str!("rows/units-and-scales.toml"),
    include_str!("rows/tiny-huge-and-grazing.toml"),
    include_str!("rows/grooves-corners-loose-bodies.toml"),
    include_str!("rows/motions-and-history.toml"),
    include_str!("rows/buckling-snapping-limits.toml"),
    include_str!("rows/seals-and-bushes.toml"),
    include_str!("rows/poor-input.toml"),
];

/// Scene files by name; `$WORD` stands for what a row gives it.
const SCENES: &[(&str, &str)] = &[
    ("arch", include_str!("scenes/arch.toml")),
    ("balloon", include_str!("scenes/balloon.toml")),
    ("bend", include_str!("scenes/bend.toml")),
    ("bonded", include_str!("scenes/bonded.toml")),
    ("bush", include_str!("scenes/bush.toml")),
    ("carried", include_str!("scenes/carried.toml")),
    ("clamped", include_str!("scenes/clamped.toml")),
    ("column", include_str!("scenes/column.toml")),
    ("confined", include_str!("scenes/confined.toml")),
    ("far-wall", include_str!("scenes/far-wall.toml")),
    ("filled", include_str!("scenes/filled.toml")),
    ("friction", include_str!("scenes/friction.toml")),
    ("grazing", include_str!("scenes/grazing.toml")),
    ("groove", include_str!("scenes/groove.toml")),
    ("indent", include_str!("scenes/indent.toml")),
    ("ring", include_str!("scenes/ring.toml")),
    ("ring-half", include_str!("scenes/ring-half.toml")),
    ("shear", include_str!("scenes/shear.toml")),
    ("side-by-side", include_str!("scenes/side-by-side.toml")),
    ("slab", include_str!("scenes/slab.toml")),
    ("squeezed", include_str!("scenes/squeezed.toml")),
    ("standing", include_str!("scenes/standing.toml")),
    ("strip", include_str!("scenes/strip.toml")),
    ("turned", include_str!("scenes/turned.toml")),
    ("twins", include_str!("scenes/twins.toml")),
    ("walls", include_str!("scenes/walls.toml")),
    ("weighed", include_str!("scenes/weighed.toml")),
];

/// A row as the file has it.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Trial {
    /// Of its files; what other rows name it by.
    pub(crate) id: String,
    /// That of its file.
    #[serde(skip)]
    pub(crate) family: String,
    /// What is extreme.
    pub(crate) case: String,
    scene: String,
    body: String,
    /// Words of the scene.
    #[serde(default)]
    with: BTreeMap<String, String>,
    /// Pointer to what is compared, in the last result.
    #[serde(default)]
    pub(crate) value: String,
    /// See [`Expected`].
    #[serde(default)]
    expected: String,
    /// Largest error that the known value allows.
    #[serde(default = "exact")]
    pub(crate) within: f64,
    /// Where the known value comes from.
    pub(crate) known: String,
    /// Whether a quick run has it.
    #[serde(default)]
    pub(crate) quick: bool,
}

fn exact() -> f64 {
    1e-6
}

/// What is known of a result without this solver.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Expected {
    /// Nothing: whether it converges is all that is asked.
    Convergence,
    /// `1.5`, or `0 of 0.5`: a number, and what its error is relative to.
    Number(f64, f64),
    /// `step 1`: what the value was at the end of an earlier step.
    Step(u64),
    /// `row ID` or `row ID times 1e18`: the value of the row with this name, times a factor.
    Row(String, f64),
    /// `peer`: the number that a direct solver of another program gives on the same mesh.
    Peer,
    /// `cause a|b`: the step must end early, for one of these causes; `cause a at 0.8`: at
    /// this part of the load.
    Cause(Vec<String>, Option<f64>),
    /// `warning a|b`: converged, with one of these warnings in a result.
    Warning(Vec<String>),
    /// `said a|b`: one of these warnings, however it ends.
    Said(Vec<String>),
    /// `stability minimum`: the verdict of the last result.
    Stability(String),
    /// `refused`: the scene must not be accepted.
    Refusal,
}

impl Expected {
    fn read(text: &str) -> Option<Self> {
        let list = |text: &str| text.split('|').map(str::to_owned).collect();
        Some(match text.split(' ').collect::<Vec<_>>().as_slice() {
            [""] => Self::Convergence,
            ["refused"] => Self::Refusal,
            ["step", number] => Self::Step(number.parse().ok()?),
            ["row", id] => Self::Row((*id).to_owned(), 1.0),
            ["row", id, "times", factor] => Self::Row((*id).to_owned(), factor.parse().ok()?),
            ["peer"] => Self::Peer,
            ["cause", causes] => Self::Cause(list(causes), None),
            ["cause", causes, "at", part] => Self::Cause(list(causes), part.parse().ok()),
            ["warning", kinds] => Self::Warning(list(kinds)),
            ["said", kinds] => Self::Said(list(kinds)),
            ["stability", verdict] => Self::Stability((*verdict).to_owned()),
            [number, "of", scale] => Self::Number(number.parse().ok()?, scale.parse().ok()?),
            [number] => {
                let number: f64 = number.parse().ok()?;
                Self::Number(number, number.abs())
            }
            _ => return None,
        })
    }
}

impl Trial {
    /// What is known; a test excludes rows that cannot be read.
    pub(crate) fn expected(&self) -> Expected {
        Expected::read(&self.expected).unwrap_or(Expected::Convergence)
    }

    /// Its body.
    ///
    /// # Errors
    /// Words that are none.
    pub(crate) fn body(&self) -> Result<Body, String> {
        self.body.parse()
    }

    /// The scene file, for a mesh file beside it.
    ///
    /// # Errors
    /// A scene that is not there, or a word without a text.
    pub(crate) fn scene(&self, mesh: &str) -> Result<String, String> {
        let fault = |what: &str| format!("row {}: no {what}", self.id);
        let of_tests = OF_TESTS.iter().map(|(name, scene, _)| (name, scene));
        let scenes = SCENES.iter().map(|(name, scene)| (name, scene));
        let found = scenes.chain(of_tests).find(|scene| *scene.0 == self.scene);
        let mut rest: &str = found.ok_or_else(|| fault(&self.scene))?.1;
        let mut text = String::new();
        while let Some((before, after)) = rest.split_once('$') {
            let end = after.find(|c: char| !c.is_ascii_lowercase());
            let (word, behind) = after.split_at(end.unwrap_or(after.len()));
            text.push_str(before);
            text.push_str(match word {
                "mesh" => mesh,
                word => self.with.get(word).ok_or_else(|| fault(word))?,
            });
            rest = behind;
        }
        text.push_str(rest);
        Ok(text)
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    family: String,
    trial: Vec<Trial>,
}

/// All rows, in the order of the page.
///
/// # Errors
/// What is wrong with the file, which a test excludes.
pub(crate) fn trials() -> Result<Vec<Trial>, String> {
    let mut trials = Vec::new();
    for text in ROWS {
        let file: File = toml::from_str(text).map_err(|error| error.to_string())?;
        let of_family = |trial| Trial {
            family: file.family.clone(),
            ..trial
        };
        trials.extend(file.trial.into_iter().map(of_family));
    }
    Ok(trials)
}

/// A row whose strain energy is expected to be this.
#[cfg(test)]
pub(super) fn trial(expected: &str) -> Trial {
    let words = "id = 'a'\ncase = 'c'\nscene = 's'\nbody = 'cell'\nknown = 'k'";
    let rest = format!("value = '/strain_energy'\nexpected = '{expected}'\nwithin = 1e-3");
    toml::from_str(&format!("{words}\n{rest}")).unwrap()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_row_has_a_body_a_scene_and_something_known() {
        let all = trials().unwrap();
        assert!(all.len() > 60, "{}", all.len());
        for (index, trial) in all.iter().enumerate() {
            let id = &trial.id;
            trial.body().unwrap_or_else(|fault| panic!("{id}: {fault}"));
            trial
                .scene("m.msh")
                .unwrap_or_else(|fault| panic!("{fault}"));
            assert!(Expected::read(&trial.expected).is_some(), "{id}");
            assert!(!trial.known.is_empty() && trial.within > 0.0, "{id}");
            assert!(!all[..index].iter().any(|other| other.id == *id), "{id}");
        }
    }

    #[test]
    fn a_row_that_another_one_is_compared_with_stands_before_it() {
        let all = trials().unwrap();
        for (index, trial) in all.iter().enumerate() {
            let Expected::Row(id, _) = trial.expected() else {
                continue;
            };
            let other = all[..index].iter().find(|other| other.id == id);
            let other = other.unwrap_or_else(|| panic!("{id}"));
            assert!(other.quick || !trial.quick, "{id}");
        }
    }

    #[test]
    fn rows_of_a_family_stand_together() {
        let mut families: Vec<String> = trials().unwrap().into_iter().map(|t| t.family).collect();
        families.dedup();
        let count = families.len();
        families.sort_unstable();
        families.dedup();
        assert_eq!(families.len(), count);
    }

    #[test]
    fn what_is_known_is_read_from_words() {
        let read = |text| Expected::read(text).unwrap();
        assert_eq!(read("-1.5"), Expected::Number(-1.5, 1.5));
        assert_eq!(read("0 of 0.5"), Expected::Number(0.0, 0.5));
        assert_eq!(read("row a times 10"), Expected::Row("a".into(), 10.0));
        let causes = vec!["a".into(), "b".into()];
        assert_eq!(read("cause a|b"), Expected::Cause(causes.clone(), None));
        assert_eq!(read("cause a|b at 0.8"), Expected::Cause(causes, Some(0.8)));
        assert_eq!(Expected::read("soon"), None);
    }
}
