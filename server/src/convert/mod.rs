//! Between wire and domain, one file per proto file: the only place that sees both.
//!
//! Conversion checks form (lengths, presence, limits) and names faulty keys as
//! the scene file spells them; meaning is checked by the library.

pub(crate) mod field;
#[cfg(test)]
mod fuzz;
mod grid;
pub(crate) mod local;
mod material;
pub(crate) mod mesh;
pub(crate) mod refinement;
pub(crate) mod report;
pub(crate) mod scene;
pub(crate) mod shape;
pub(crate) mod step;
pub(crate) mod surface;
pub(crate) mod uploaded;
pub(crate) mod values;

use signorini::scene::Violation;
use signorini_proto::v1 as wire;

use crate::fault::{Fault, violation};

/// Longest name of anything, bytes.
pub(crate) const MAXIMUM_NAME_BYTES: usize = 256;

/// Most faults of one message that are told.
const MOST_FAULTS: usize = 100;

/// Faults found while a message is converted, at most [`MOST_FAULTS`].
#[derive(Debug, Default)]
pub(crate) struct Faults {
    invalid: Vec<Violation>,
    unsupported: Option<Violation>,
    misnamed: Vec<Violation>,
    negative: Vec<Violation>,
}

impl Faults {
    pub(crate) fn add(&mut self, path: impl Into<String>, message: impl Into<String>) {
        if self.invalid.len() < MOST_FAULTS {
            self.invalid.push(violation(path, message));
        }
    }

    /// A name that nobody knows. Such a message is well formed: the fault is told
    /// with those that planning finds.
    pub(crate) fn misnamed(&mut self, path: impl Into<String>, message: impl Into<String>) {
        self.misnamed.push(violation(path, message));
    }

    /// A key of a capability that is not there yet; the first one is reported.
    pub(crate) fn later(&mut self, path: impl Into<String>, message: impl Into<String>) {
        self.unsupported
            .get_or_insert_with(|| violation(path, message));
    }

    /// A list of at most `limit` entries.
    pub(crate) fn at_most<T>(&mut self, list: &[T], limit: usize, path: &str) {
        if list.len() > limit {
            self.add(
                path,
                format!("has {} entries, at most {limit} are allowed", list.len()),
            );
        }
    }

    /// Exactly three components.
    pub(crate) fn vector(&mut self, values: &[f64], path: &str) -> [f64; 3] {
        values.try_into().unwrap_or_else(|_| {
            self.add(
                path,
                format!("has {} components, 3 are needed", values.len()),
            );
            [0.0; 3]
        })
    }

    /// Three components or none.
    pub(crate) fn optional_vector(&mut self, values: &[f64], path: &str) -> Option<[f64; 3]> {
        (!values.is_empty()).then(|| self.vector(values, path))
    }

    /// A number that must be there.
    pub(crate) fn required(&mut self, value: Option<f64>, path: &str) -> f64 {
        value.unwrap_or_else(|| {
            self.add(path, "is required");
            0.0
        })
    }

    /// A number that may not be negative. The library finds one that is, with its other
    /// faults; here it is kept so that it comes before keys of later versions.
    pub(crate) fn not_negative(&mut self, value: Option<f64>, path: &str) -> Option<f64> {
        if let Some(number) = value.filter(|number| !(number.is_finite() && *number >= 0.0)) {
            let message = format!("must be at least zero and finite, not {number}");
            if self.negative.len() < MOST_FAULTS {
                self.negative.push(violation(path, message));
            }
        }
        value
    }

    /// A name of allowed length that a terminal shows as it is.
    pub(crate) fn name(&mut self, name: &str, path: &str) -> String {
        if name.len() > MAXIMUM_NAME_BYTES {
            self.add(path, format!("is longer than {MAXIMUM_NAME_BYTES} bytes"));
            return String::new();
        }
        if name.chars().any(char::is_control) {
            self.add(path, "has a control character");
            return String::new();
        }
        name.to_owned()
    }

    /// Takes what was found, if anything is malformed, so that a message beyond
    /// its limits is not converted.
    ///
    /// # Errors
    /// `SceneInvalid`.
    pub(crate) fn refuse(&mut self) -> Result<(), Fault> {
        if self.invalid.is_empty() {
            Ok(())
        } else {
            Err(Fault::SceneInvalid(std::mem::take(&mut self.invalid)))
        }
    }

    /// What was found, if anything: as in the library, faults come before keys
    /// of later versions. Names that nobody knows are not among it.
    pub(crate) fn outcome(mut self) -> Result<(), Fault> {
        self.refuse()?;
        match self.unsupported {
            Some(_) if !self.negative.is_empty() => Err(Fault::SceneInvalid(self.negative)),
            Some(one) => Err(Fault::Unsupported(one)),
            None => Ok(()),
        }
    }
}

/// `obstacle.ball`, or `obstacle[2]` for one without a name.
fn named(kind: &str, name: &str, index: usize) -> String {
    if name.is_empty() {
        return format!("{kind}[{index}]");
    }
    let shown: String = name.chars().take(MAXIMUM_NAME_BYTES).collect();
    format!("{kind}.{shown}")
}

fn components(values: Option<wire::Components>) -> [Option<f64>; 3] {
    values.map_or([None; 3], |values| [values.x, values.y, values.z])
}

/// Counts on the wire are signed.
pub(crate) fn wide(count: u64) -> i64 {
    i64::try_from(count).unwrap_or(i64::MAX)
}

/// Counts on the wire are signed.
pub(crate) fn narrow(count: u32) -> i32 {
    i32::try_from(count).unwrap_or(i32::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faulty_keys_come_before_keys_of_later_versions() {
        let mut faults = Faults::default();
        faults.later("pressure", "comes later");
        faults.add("name", "is too long");
        let expected = vec![violation("name", "is too long")];
        assert_eq!(faults.outcome(), Err(Fault::SceneInvalid(expected)));
        let mut faults = Faults::default();
        faults.later("pressure", "comes later");
        assert!(matches!(faults.outcome(), Err(Fault::Unsupported(_))));
    }

    #[test]
    fn negative_friction_comes_before_a_shape_of_a_later_version() {
        let mut faults = Faults::default();
        assert_eq!(faults.not_negative(Some(-0.3), "friction"), Some(-0.3));
        faults.later("shape.kind", "comes later");
        match faults.outcome() {
            Err(Fault::SceneInvalid(all)) => assert_eq!(all[0].path, "friction"),
            other => panic!("{other:?}"),
        }
        // The library tells it otherwise, with whatever else is wrong.
        let mut faults = Faults::default();
        faults.not_negative(Some(f64::NAN), "friction");
        assert_eq!(faults.outcome(), Ok(()));
    }
}
