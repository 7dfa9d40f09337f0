//! Values on the meshes of the families, shipped in `references.csv`, and the
//! limits that follow from them.

use std::collections::BTreeMap;

use crate::commented::reader;
use crate::family::{Level, Quantity};
use crate::limit::{Limit, Sample, extrapolate};

const TABLE: &str = include_str!("references.csv");

/// One row of the table: the solution of the discrete problem on one mesh, or a limit.
#[derive(Clone, Copy, Debug)]
enum Entry {
    Mesh(Level, Sample),
    /// Of a mesh that was refined by the quantity, with its bound.
    Refined(Limit),
}

impl Entry {
    fn mesh(&self) -> Option<(Level, Sample)> {
        match self {
            Self::Mesh(level, sample) => Some((*level, *sample)),
            Self::Refined(_) => None,
        }
    }

    fn refined(&self) -> Option<Limit> {
        match self {
            Self::Refined(limit) => Some(*limit),
            Self::Mesh(..) => None,
        }
    }
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
        let entries = self.of(family, quantity);
        let meshes = entries.iter().filter_map(Entry::mesh);
        let samples: Vec<_> = meshes.map(|(_, sample)| sample).collect();
        let refined = entries.iter().find_map(Entry::refined);
        refined.or_else(|| extrapolate(&samples))
    }

    fn of(&self, family: &str, quantity: Quantity) -> &[Entry] {
        let entries = self.entries.get(&(family.to_owned(), quantity));
        entries.map_or(&[], Vec::as_slice)
    }

    /// The size of a mesh where it is finest, length.
    pub(crate) fn size(&self, family: &str, level: Level) -> Option<f64> {
        let of_family = self.entries.iter().filter(|(key, _)| key.0 == family);
        let mut meshes = of_family.flat_map(|(_, entries)| entries.iter().filter_map(Entry::mesh));
        let (_, sample) = meshes.find(|(own, _)| *own == level)?;
        Some(sample.h)
    }

    /// What a limit rests on, for small print.
    pub(crate) fn origin(&self, family: &str, quantity: Quantity) -> String {
        let entries = self.of(family, quantity);
        if entries.iter().any(|entry| entry.refined().is_some()) {
            return "of a mesh that was refined by the quantity, with its bound".to_owned();
        }
        let finest = entries.iter().filter_map(Entry::mesh).next_back();
        let finest = finest.map_or_else(String::new, |(level, _)| format!(" (to {level})"));
        format!("extrapolated from the meshes of the family{finest}")
    }

    /// The relative error that the exact solution of the discrete problem has on
    /// a mesh, whoever solves it.
    pub(crate) fn error(&self, family: &str, quantity: Quantity, level: Level) -> Option<f64> {
        let mut meshes = self.of(family, quantity).iter().filter_map(Entry::mesh);
        let (_, sample) = meshes.find(|(own, _)| *own == level)?;
        self.relative(family, quantity, sample.value)
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
    let value = record.get(4)?.parse().ok()?;
    let entry = if record.get(1)? == "refined" {
        let uncertainty = record.get(6)?.parse().ok()?;
        Entry::Refined(Limit { value, uncertainty })
    } else {
        let h = record.get(2)?.parse().ok()?;
        Entry::Mesh(record.get(1)?.parse().ok()?, Sample { h, value })
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
    fn the_limit_of_a_refined_mesh_is_its_value_with_its_bound_near_that_of_the_family() {
        let references = References::shipped().unwrap();
        for family in ["hertz-plane", "hertz-sphere"] {
            let limit = references.limit(family, Quantity::Force).unwrap();
            assert!(limit.relative() < 5e-4, "{limit:?}");
            let meshes = references.of(family, Quantity::Force).iter();
            let samples: Vec<_> = meshes.filter_map(Entry::mesh).map(|own| own.1).collect();
            let of_family = extrapolate(&samples).unwrap();
            let apart = (of_family.value - limit.value).abs();
            assert!(apart < of_family.uncertainty, "{of_family:?} {limit:?}");
        }
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
