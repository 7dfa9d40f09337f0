//! Values over a part of the body, by nodes and by facets or cells:
//!
//! ```text
//! v(X) = sum_a v_a N_a(X) + v_part,   N_a the quadratic functions of the nodes
//! ```
//!
//! What has no row is zero. Cost: one search a value that is asked for.

use std::sync::Arc;

/// Rows by ascending numbers; no row stands for zeros.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Table {
    /// Ascending, each once.
    pub(crate) keys: Arc<[u32]>,
    /// One a key.
    pub(crate) rows: Arc<[[f64; 3]]>,
}

impl Table {
    /// The row of `key`, or zeros.
    pub(crate) fn at(&self, key: u32) -> [f64; 3] {
        let place = self.keys.binary_search(&key).ok();
        let row = place.and_then(|place| self.rows.get(place));
        row.copied().unwrap_or_default()
    }

    /// Whether every value is zero.
    pub(crate) fn is_zero(&self) -> bool {
        self.rows.as_flattened().iter().all(|&value| value == 0.0)
    }

    /// A fraction of the way to `end`, which has the same keys or none.
    fn towards(&self, end: &Self, fraction: f64) -> Self {
        let longer = if self.keys.is_empty() { end } else { self };
        let row = |(&key, place): (&u32, usize)| {
            let of = |table: &Self| {
                if table.keys.len() == longer.keys.len() {
                    table.rows.get(place).copied().unwrap_or_default()
                } else {
                    table.at(key)
                }
            };
            let (a, b) = (of(self), of(end));
            std::array::from_fn(|i| a[i] + fraction * (b[i] - a[i]))
        };
        Self {
            keys: longer.keys.clone(),
            rows: longer.keys.iter().zip(0..).map(row).collect(),
        }
    }

    /// Bytes held.
    fn bytes(&self) -> u64 {
        (size_of_val(&*self.keys) + size_of_val(&*self.rows)) as u64
    }
}

/// Values over a part of the body, in the caller's units.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Spread {
    /// By nodes of the space: used vertices, then edges after them.
    pub(crate) nodes: Table,
    /// By facets, or by cells.
    pub(crate) parts: Table,
}

impl Spread {
    /// Whether every value is zero.
    pub(crate) fn is_zero(&self) -> bool {
        self.nodes.is_zero() && self.parts.is_zero()
    }

    /// A fraction of the way to `end`.
    pub(crate) fn towards(&self, end: &Self, fraction: f64) -> Self {
        Self {
            nodes: self.nodes.towards(&end.nodes, fraction),
            parts: self.parts.towards(&end.parts, fraction),
        }
    }

    /// Numbers of rows by nodes and by parts.
    pub(crate) fn shape(&self) -> [usize; 2] {
        [self.nodes.rows.len(), self.parts.rows.len()]
    }

    /// All values one after the other.
    pub(crate) fn numbers(&self) -> impl Iterator<Item = f64> + '_ {
        let tables = [&self.nodes, &self.parts].into_iter();
        tables.flat_map(|table| table.rows.as_flattened().iter().copied())
    }

    /// Bytes held.
    pub(crate) fn bytes(&self) -> u64 {
        self.nodes.bytes() + self.parts.bytes()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(keys: &[u32], value: f64) -> Table {
        Table {
            keys: keys.into(),
            rows: keys
                .iter()
                .map(|&key| [f64::from(key), value, 0.0])
                .collect(),
        }
    }

    #[test]
    fn values_ramp_from_and_to_nothing() {
        let some = Spread {
            nodes: table(&[2, 5], 4.0),
            parts: Table::default(),
        };
        let none = Spread::default();
        let grown = none.towards(&some, 0.25);
        let expected = Table {
            keys: some.nodes.keys.clone(),
            rows: [[0.5, 1.0, 0.0], [1.25, 1.0, 0.0]].into(),
        };
        assert_eq!(grown.nodes, expected);
        assert!(grown.nodes.at(3).iter().all(|&value| value == 0.0));
        assert_eq!(some.towards(&none, 0.75), grown);
        assert!(none.is_zero() && !grown.is_zero());
        let other = Spread {
            parts: table(&[7], 1.0),
            ..Spread::default()
        };
        let half = some.towards(&other, 0.5);
        assert_eq!(
            (half.nodes.at(2), half.parts.at(7)),
            ([1.0, 2.0, 0.0], [3.5, 0.5, 0.0])
        );
        assert_eq!(half.shape(), [2, 1]);
        assert!((half.numbers().sum::<f64>() - 11.5).abs() < 1e-15);
    }
}
