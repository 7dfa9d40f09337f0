//! Files of values that a scene names: where they belong in its message, and their rows there.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use signorini_proto::v1;
use toml::{Table, Value};

use super::SceneFile;
use crate::formats::values;
use crate::library::bounded_file;
use crate::library::error::Violation;

/// Where values belong; positions from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ValuesPlace {
    /// Of a support.
    Support(usize),
    /// Of a traction.
    Traction(usize),
    /// Of the body force.
    BodyForce,
    /// Of a support in a step.
    StepSupport(usize, usize),
    /// Of a traction in a step.
    StepTraction(usize, usize),
    /// Of the body force in a step.
    StepBodyForce(usize),
}

/// A file of values.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NamedValues {
    /// Its key, such as `support.base.values`.
    pub key: String,
    /// Where its rows belong.
    pub place: ValuesPlace,
    /// The file.
    pub path: PathBuf,
}

/// The files that the tables of a scene name, relative to `folder`; keys that are wrong have
/// been told before.
pub(super) fn named(table: &Table, folder: &Path) -> Vec<NamedValues> {
    let mut found = Vec::new();
    let mut note = |key: String, place, keys: Option<&Value>| {
        if let Some(file) = keys.and_then(|keys| keys.get("values")?.as_str()) {
            let (key, path) = (format!("{key}.values"), folder.join(file));
            found.push(NamedValues { key, place, path });
        }
    };
    let array = |key: &str| {
        table
            .get(key)
            .and_then(Value::as_array)
            .into_iter()
            .flatten()
    };
    for (index, keys) in array("support").enumerate() {
        let key = called("support", index, keys);
        note(key, ValuesPlace::Support(index), Some(keys));
    }
    for (index, keys) in array("traction").enumerate() {
        let key = called("traction", index, keys);
        note(key, ValuesPlace::Traction(index), Some(keys));
    }
    let force = table.get("body_force");
    note("body_force".to_owned(), ValuesPlace::BodyForce, force);
    for (step, keys) in array("step").enumerate() {
        let named = |kind: &str| {
            keys.get(kind)
                .and_then(Value::as_table)
                .into_iter()
                .flatten()
        };
        for (index, (name, keys)) in named("support").enumerate() {
            let key = format!("step[{step}].support.{name}");
            note(key, ValuesPlace::StepSupport(step, index), Some(keys));
        }
        for (index, (name, keys)) in named("traction").enumerate() {
            let key = format!("step[{step}].traction.{name}");
            note(key, ValuesPlace::StepTraction(step, index), Some(keys));
        }
        let (key, force) = (format!("step[{step}].body_force"), keys.get("body_force"));
        note(key, ValuesPlace::StepBodyForce(step), force);
    }
    found
}

/// What an element is called in paths.
fn called(kind: &str, index: usize, keys: &Value) -> String {
    match keys.get("name").and_then(Value::as_str) {
        Some(name) => format!("{kind}.{name}"),
        None => format!("{kind}[{index}]"),
    }
}

/// Reads the files of values that a scene names, into its message.
///
/// # Errors
/// Every file that cannot be read, with its key, its path, the line and the node.
pub fn read_values(file: &mut SceneFile) -> Result<(), Vec<Violation>> {
    let mut faults = Vec::new();
    for one in &file.values {
        match read(&one.path) {
            Ok(values) => put(&mut file.scene, one.place, values),
            Err(why) => faults.push(Violation {
                path: one.key.clone(),
                message: format!("{}: {why}", one.path.display()),
            }),
        }
    }
    if faults.is_empty() {
        Ok(())
    } else {
        Err(faults)
    }
}

fn read(path: &Path) -> Result<v1::Values, String> {
    let told = |error: std::io::Error| {
        if error.kind() == ErrorKind::InvalidInput {
            error.to_string()
        } else {
            format!("cannot be read: {error}")
        }
    };
    let bytes = bounded_file::read(path, values::MOST_BYTES).map_err(told)?;
    let file = values::read(&bytes).map_err(|error| error.to_string())?;
    Ok(file.to_wire())
}

/// Puts values where they belong.
fn put(scene: &mut v1::Scene, place: ValuesPlace, values: v1::Values) {
    let slot = match place {
        ValuesPlace::Support(index) => (scene.supports.get_mut(index)).map(|one| &mut one.values),
        ValuesPlace::Traction(index) => (scene.tractions.get_mut(index)).map(|one| &mut one.values),
        ValuesPlace::BodyForce => Some(&mut scene.body_force_values),
        ValuesPlace::StepSupport(step, index) => (scene.steps.get_mut(step))
            .and_then(|step| step.supports.get_mut(index))
            .map(|one| &mut one.values),
        ValuesPlace::StepTraction(step, index) => (scene.steps.get_mut(step))
            .and_then(|step| step.tractions.get_mut(index))
            .map(|one| &mut one.values),
        ValuesPlace::StepBodyForce(step) => {
            (scene.steps.get_mut(step)).map(|step| &mut step.body_force)
        }
    };
    if let Some(slot) = slot {
        *slot = Some(values);
    }
}
