//! What varies: lists, ranges and tables, of which a study takes every combination.

use toml::Value;

use super::list::List;
use super::range::Range;
use super::sobol::Sobol;

/// Values of one key or several, by position.
#[derive(Clone, Debug)]
pub(crate) enum Axis {
    /// Rows of a table.
    List(List),
    /// Values of a key, as they stand in the file.
    Values(String, Vec<Value>),
    /// Numbers between two ends.
    Steps(String, Range, u64),
    /// Points that fill a box evenly.
    Points(Points),
}

/// Points of the Sobol sequence in the box of some ranges.
#[derive(Clone, Debug)]
pub(crate) struct Points {
    pub(crate) count: u64,
    pub(crate) ranges: Vec<(String, Range)>,
    pub(crate) sequence: Sobol,
}

impl Axis {
    /// Number of positions.
    pub(crate) fn count(&self) -> u64 {
        match self {
            Self::List(list) => list.rows,
            Self::Values(_, values) => values.len() as u64,
            Self::Steps(_, _, count) => *count,
            Self::Points(points) => points.count,
        }
    }

    /// Keys that it sets.
    pub(crate) fn keys(&self) -> Vec<&str> {
        match self {
            Self::List(list) => list.keys.iter().map(String::as_str).collect(),
            Self::Values(key, _) | Self::Steps(key, _, _) => vec![key],
            Self::Points(points) => points.ranges.iter().map(|(key, _)| key.as_str()).collect(),
        }
    }

    /// Of each key, whether all its values are numbers.
    pub(crate) fn numeric(&self) -> Vec<bool> {
        match self {
            Self::List(list) => list.numeric.clone(),
            Self::Values(_, values) => {
                let is_number = |value: &Value| value.is_float() || value.is_integer();
                vec![values.iter().all(is_number)]
            }
            Self::Steps(..) => vec![true],
            Self::Points(points) => vec![true; points.ranges.len()],
        }
    }

    /// Values of its keys at a position; `None` leaves a key as the scene has it.
    pub(crate) fn values(&self, position: u64) -> Vec<Option<Value>> {
        match self {
            Self::List(list) => list.cells(position),
            Self::Values(_, values) => {
                let value = usize::try_from(position).ok().and_then(|at| values.get(at));
                vec![value.cloned()]
            }
            Self::Steps(_, range, count) => vec![Some(range.step(position, *count))],
            Self::Points(points) => points.values(position),
        }
    }
}

impl Points {
    fn values(&self, position: u64) -> Vec<Option<Value>> {
        let ranges = self.ranges.iter().enumerate();
        let values = ranges.map(|(dimension, (_, range))| {
            let fraction = self.sequence.coordinate(position, dimension);
            Some(Value::Float(range.at(fraction)))
        });
        values.collect()
    }
}
