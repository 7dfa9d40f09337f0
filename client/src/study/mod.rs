//! Studies: one scene, solved for many values of its keys.
//!
//! A study file names a scene, what varies and what is to be known of each case. What varies
//! are axes: a table of cases, lists and ranges of single keys, points that fill a box; the
//! cases are all combinations, the first axis varying slowest. A case is made when it is asked
//! for, by its number, so that a study of any size takes no memory for those to come.
//! Its identifier tells the number and a digest of what is set, and is the same wherever
//! the study is read.

pub mod asked;
mod axis;
mod derived;
mod error;
mod expression;
mod list;
mod range;
mod read;
mod sobol;
mod wanted;

#[cfg(test)]
mod tests;

use std::path::{Path, PathBuf};

use sha2::{Digest as _, Sha256};
use signorini_proto::digest::hex;
use toml::Value;

pub use derived::Derived;
pub use error::StudyError;
pub use wanted::{At, Gathered, Wanted};

use crate::library::bounded_file;
use crate::library::error::Violation;
use crate::scene_file::{self, Override, SceneFile, SceneFileError, Template};
use axis::Axis;
use derived::Sought;

/// Cases of a study at most: one bit of memory each tells which are done.
pub const MOST_CASES: u64 = 100_000_000;

/// Columns of every table of results before the keys, and after them.
pub const COLUMNS_BEFORE: [&str; 2] = ["case", "id"];
/// See [`COLUMNS_BEFORE`].
pub const COLUMNS_AFTER: [&str; 6] = [
    "termination",
    "cause",
    "message",
    "attempts",
    "increments",
    "seconds",
];

/// What is wrong with a second column of one name.
const TAKEN: &str = "there is another column of that name; give a \"name\"";

/// Bytes of a study file, and of its scene.
const MOST_BYTES: u64 = 64 << 20;

/// Cases that are tried when the first one cannot be read: values of a case may be wrong, keys
/// are wrong in all.
const TRIED: u64 = 16;

/// A study that has been read.
#[derive(Debug)]
pub struct Study {
    template: Template,
    /// Where a relative mesh among the values begins.
    folder: PathBuf,
    changes: Vec<Override>,
    axes: Vec<Axis>,
    wanted: Vec<Wanted>,
    derived: Vec<Derived>,
    keys: Vec<String>,
    count: u64,
    digest: String,
    list: Option<PathBuf>,
}

/// One case of a study.
#[derive(Clone, Debug)]
pub struct Case {
    /// From 0.
    pub index: u64,
    /// The number and a digest of what is set.
    pub id: String,
    /// Of each key that varies; `None` where the scene's value holds.
    pub values: Vec<Option<Value>>,
}

impl Study {
    /// Reads a study file, its scene and its table; `overrides` change the scene of every case
    /// before what the study sets.
    ///
    /// # Errors
    /// [`StudyError`], with every key that is wrong, or the line of the table.
    pub fn open(path: &Path, overrides: &[Override]) -> Result<Self, StudyError> {
        Self::read(&text(path)?, path, overrides)
    }

    /// As [`Study::open`] from the text of the study file.
    ///
    /// # Errors
    /// As there.
    pub fn read(text: &str, path: &Path, overrides: &[Override]) -> Result<Self, StudyError> {
        let mut file = read::read(text, path)?;
        let scene = &file.scene;
        let template = Template::parse(&self::text(scene)?, scene);
        let template = template.map_err(|source| StudyError::Scene {
            path: scene.clone(),
            source,
        })?;
        file.changes.extend_from_slice(overrides);
        let keys = file.axes.iter().flat_map(Axis::keys).map(str::to_owned);
        let mut study = Self {
            digest: digest(&file, &template),
            template,
            folder: path.parent().unwrap_or(Path::new("")).to_owned(),
            changes: file.changes,
            keys: keys.collect(),
            axes: file.axes,
            wanted: file.wanted,
            derived: Vec::new(),
            count: 0,
            list: file.list,
        };
        study.check_keys()?;
        study.count = study.product()?;
        study.check_scene()?;
        study.derive_from(&file.sought)?;
        Ok(study)
    }

    /// Keys are paths, and each varies once.
    fn check_keys(&self) -> Result<(), StudyError> {
        let mut seen = Vec::new();
        let mut faults = Vec::new();
        for key in &self.keys {
            match Override::new(key, Value::Boolean(false)) {
                Ok(change) if seen.contains(&change.path().to_vec()) => {
                    faults.push(violation(key, "varies twice"));
                }
                Ok(change) => seen.push(change.path().to_vec()),
                Err(fault) => faults.push(violation(key, fault)),
            }
        }
        if faults.is_empty() {
            Ok(())
        } else {
            Err(StudyError::Invalid(faults))
        }
    }

    fn product(&self) -> Result<u64, StudyError> {
        let mut counts = self.axes.iter().map(Axis::count);
        let product = counts.try_fold(1_u64, u64::checked_mul);
        let small = product.filter(|product| *product <= MOST_CASES);
        small.ok_or_else(|| {
            let message = format!("has more than {MOST_CASES} cases");
            StudyError::Invalid(vec![violation("", message)])
        })
    }

    /// One of the first cases can be read, and has what is wanted.
    fn check_scene(&mut self) -> Result<(), StudyError> {
        let first = self.readable().next();
        if let Some(file) = first {
            return self.check_wanted(&file);
        }
        let faults = match self.case(0).map(|case| self.scene(&case)) {
            Some(Err(SceneFileError::Invalid(faults))) => faults,
            Some(Err(SceneFileError::Syntax(message))) => vec![violation("", message)],
            Some(Ok(_)) | None => vec![violation("", "has no case")],
        };
        Err(StudyError::Invalid(faults))
    }

    /// Scenes of the first cases that can be read: at least one, of at most 16.
    pub fn readable(&self) -> impl Iterator<Item = SceneFile> {
        let cases = (0..self.count.min(TRIED)).filter_map(|index| self.case(index));
        cases.filter_map(|case| self.scene(&case).ok())
    }

    fn check_wanted(&mut self, file: &SceneFile) -> Result<(), StudyError> {
        if self.wanted.is_empty() {
            self.wanted = Wanted::forces(&file.scene);
        }
        let fixed = COLUMNS_BEFORE.into_iter().chain(COLUMNS_AFTER);
        let mut columns: Vec<&str> = fixed.chain(self.keys.iter().map(String::as_str)).collect();
        let mut faults = Vec::new();
        for one in &self.wanted {
            if let Some(fault) = one.fault(&file.scene) {
                faults.push(violation(&format!("result.{}.of", one.name), fault));
            }
            if columns.contains(&one.name.as_str()) {
                faults.push(violation(&format!("result.{}", one.name), TAKEN));
            }
            columns.push(&one.name);
        }
        if faults.is_empty() {
            Ok(())
        } else {
            Err(StudyError::Invalid(faults))
        }
    }

    /// Reads what is computed from the other columns.
    fn derive_from(&mut self, sought: &[Sought]) -> Result<(), StudyError> {
        let columns = derived::Columns::new(&self.keys, self.numeric(), &self.wanted);
        self.derived = columns.read(sought).map_err(StudyError::Invalid)?;
        Ok(())
    }

    /// Number of cases.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// Keys that vary, in the order of the columns.
    pub fn keys(&self) -> &[String] {
        &self.keys
    }

    /// Of each key, whether all its values are numbers.
    pub fn numeric(&self) -> Vec<bool> {
        self.axes.iter().flat_map(Axis::numeric).collect()
    }

    /// What is taken from the results of each case.
    pub fn wanted(&self) -> &[Wanted] {
        &self.wanted
    }

    /// What is computed for each case from its other columns, after those.
    pub fn derived(&self) -> &[Derived] {
        &self.derived
    }

    /// The values of what is computed; none where it has none.
    pub fn derive(&self, case: &Case, results: &[serde_json::Value]) -> Vec<Option<f64>> {
        derived::values(&self.derived, case, results)
    }

    /// The table that cases are taken from.
    pub fn list(&self) -> Option<&Path> {
        self.list.as_deref()
    }

    /// Lower-case hexadecimal digits that are the same for the same study of the same scene;
    /// files that the scene names are told apart by their paths only.
    pub fn digest(&self) -> &str {
        &self.digest
    }

    /// A case by its number, if there is one.
    pub fn case(&self, index: u64) -> Option<Case> {
        if index >= self.count {
            return None;
        }
        let mut rest = index;
        let mut parts = Vec::new();
        for axis in self.axes.iter().rev() {
            parts.push(axis.values(rest % axis.count().max(1)));
            rest /= axis.count().max(1);
        }
        let values: Vec<Option<Value>> = parts.into_iter().rev().flatten().collect();
        let digits = self.count.saturating_sub(1).max(1).ilog10() as usize + 1;
        let id = format!("{index:0digits$}-{}", self.digest_of(&values));
        Some(Case { index, id, values })
    }

    fn digest_of(&self, values: &[Option<Value>]) -> String {
        let mut hash = Sha256::new();
        for (key, value) in self.keys.iter().zip(values) {
            if let Some(value) = value {
                hash.update(format!("{key}\0{value}\n"));
            }
        }
        short(&hash.finalize().into())
    }

    /// The scene of a case, with its values read from their files; meshes and surfaces are
    /// still named by path.
    ///
    /// # Errors
    /// Every key that is wrong.
    pub fn scene(&self, case: &Case) -> Result<SceneFile, SceneFileError> {
        let mut changes = self.changes.clone();
        for (key, value) in self.keys.iter().zip(&case.values) {
            if let Some(value) = value {
                let change = Override::new(key, value.clone());
                let change = change.map_err(|fault| invalid(key, fault))?;
                changes.push(change.beginning_in(&self.folder));
            }
        }
        let mut file = self.template.read(&changes)?;
        scene_file::read_values(&mut file).map_err(SceneFileError::Invalid)?;
        Ok(file)
    }
}

/// A value as a cell of a table: texts without quotes.
pub fn cell(value: &Value) -> String {
    match value {
        Value::String(text) => text.clone(),
        Value::Integer(_)
        | Value::Float(_)
        | Value::Boolean(_)
        | Value::Datetime(_)
        | Value::Array(_)
        | Value::Table(_) => value.to_string(),
    }
}

fn violation(path: &str, message: impl Into<String>) -> Violation {
    let (path, message) = (path.to_owned(), message.into());
    Violation { path, message }
}

fn invalid(key: &str, message: String) -> SceneFileError {
    SceneFileError::Invalid(vec![violation(key, message)])
}

fn text(path: &Path) -> Result<String, StudyError> {
    let told = |source| StudyError::File {
        path: path.to_owned(),
        source,
    };
    let bytes = bounded_file::read(path, MOST_BYTES).map_err(told)?;
    let wrong = |_| std::io::Error::new(std::io::ErrorKind::InvalidData, "no UTF-8");
    String::from_utf8(bytes).map_err(|error| told(wrong(error)))
}

/// Of everything that decides what a case is.
fn digest(file: &read::StudyFile, template: &Template) -> String {
    let mut hash = Sha256::new();
    let table = toml::to_string(&file.table).unwrap_or_default();
    for part in ["signorini-study-v1", &table, &template.canonical()] {
        hash.update((part.len() as u64).to_le_bytes());
        hash.update(part);
    }
    for change in &file.changes {
        hash.update(format!("{}\0{}\n", change.path().join("."), change.value()));
    }
    if let Some(Axis::List(list)) = file.axes.first() {
        list.hash(&mut hash);
    }
    short(&hash.finalize().into())
}

/// The first 12 digits: 48 bits.
fn short(digest: &[u8; 32]) -> String {
    let mut digits = hex(digest);
    digits.truncate(12);
    digits
}
