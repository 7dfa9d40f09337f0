//! Values on the meshes of the families, shipped in `references.csv`, and the
//! limits that follow from them.

use std::collections::BTreeMap;

use crate::commented::reader;
use crate::family::{Level, Quantity};
use crate::limit::{Limit, Sample, extrapolate};

const TABLE: &str = include_str!("references.csv");

/// One row of the table: the solution of the discrete problem on one mesh.
#[derive(Clone, Copy, Debug)]
struct Entry {
    level: Level,
    sample: Sample,
}

/// The table by family and quantity, coarsest mesh first.
#[derive(Debug, Default)]
pub(crate) struct References {
    entries: BTreeMap<(String, Quantity), Vec<Entry>>,
}

impl References {
    /// The shipped table.
    ///
    /// # Errors
    /// The row that cannot be read.
    pub(crate) fn shipped() -> Result<Self, String> {
        Self::read(TABLE)
    }

    fn read(text: &str) -> Result<Self, String> {
        let mut table = Self::default();
        let mut reader = reader(text.as_bytes());
        for record in reader.records() {
            let record = record.map_err(|error| error.to_string())?;
            let entry = entry(&record).ok_or_else(|| format!("references: {record:?}"))?;
            table.entries.entry(entry.0).or_default().push(entry.1);
        }
        Ok(table)
    }

    /// The limit of a quantity and its uncertainty.
    pub(crate) fn limit(&self, family: &str, quantity: Quantity) -> Option<Limit> {
        let entries = self.entries.get(&(family.to_owned(), quantity))?;
        let samples: Vec<_> = entries.iter().map(|entry| entry.sample).collect();
        extrapolate(&samples)
    }

    /// The size of a mesh where it is finest, length.
    pub(crate) fn size(&self, family: &str, level: Level) -> Option<f64> {
        let of_family = self.entries.iter().filter(|(key, _)| key.0 == family);
        let mut entries = of_family.flat_map(|(_, entries)| entries);
        let entry = entries.find(|entry| entry.level == level)?;
        Some(entry.sample.h)
    }

    /// The name of the finest mesh that a limit rests on; empty without one.
    pub(crate) fn finest(&self, family: &str, quantity: Quantity) -> String {
        let entries = self.entries.get(&(family.to_owned(), quantity));
        let last = entries.and_then(|entries| entries.last());
        last.map_or_else(String::new, |entry| entry.level.to_string())
    }

    /// The relative error that the exact solution of the discrete problem has on
    /// a mesh, whoever solves it.
    pub(crate) fn error(&self, family: &str, quantity: Quantity, level: Level) -> Option<f64> {
        let entries = self.entries.get(&(family.to_owned(), quantity))?;
        let entry = entries.iter().find(|entry| entry.level == level)?;
        self.relative(family, quantity, entry.sample.value)
    }

    /// The relative error of a value: an error norm is divided by that of the
    /// exact field, any other value compared with its limit.
    pub(crate) fn relative(&self, family: &str, quantity: Quantity, value: f64) -> Option<f64> {
        match quantity.exact_norm() {
            Some(norm) => Some(value / norm),
            None => Some(self.limit(family, quantity)?.error(value)),
        }
    }
}

fn entry(record: &csv::StringRecord) -> Option<((String, Quantity), Entry)> {
    let mut quantities = Quantity::ALL.into_iter();
    let quantity = quantities.find(|quantity| Some(quantity.name()) == record.get(3))?;
    let entry = Entry {
        level: record.get(1)?.parse().ok()?,
        sample: Sample {
            h: record.get(2)?.parse().ok()?,
            value: record.get(4)?.parse().ok()?,
        },
    };
    Some(((record.get(0)?.to_owned(), quantity), entry))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::families::FAMILIES;

    #[test]
    fn every_family_has_its_limits() {
        let references = References::shipped().unwrap();
        for family in FAMILIES {
            for quantity in family.quantities {
                if quantity.exact_norm().is_some() {
                    continue;
                }
                let limit = references.limit(family.name, *quantity).unwrap();
                let name = (family.name, quantity.name());
                assert!(limit.relative() < 0.2, "{name:?} {limit:?}");
                assert_eq!(limit.is_exact(), family.name == "mr-uniax", "{name:?}");
            }
        }
    }

    #[test]
    fn the_limit_of_the_bent_cube_is_that_of_its_finest_meshes() {
        let references = References::shipped().unwrap();
        let limit = references
            .limit("cube-bend", Quantity::StrainEnergy)
            .unwrap();
        // Half of the compliance 2.2674 +- 0.0005 that other codes give.
        assert!((limit.value - 1.1337).abs() < 0.000_25, "{limit:?}");
        assert!(limit.relative() < 6e-4, "{limit:?}");
    }

    #[test]
    fn errors_fall_with_the_mesh_size() {
        let references = References::shipped().unwrap();
        let error = |number| {
            let level = Level {
                letter: 'n',
                number,
            };
            references
                .error("A1m", Quantity::DisplacementL2, level)
                .unwrap()
        };
        assert!(error(6) > error(10) && error(10) > error(16));
        assert!((error(6) - 2.362_524_16e-3 / 1.220_536_6).abs() < 1e-9);
    }
}
