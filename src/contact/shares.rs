//! Which multipliers stand for which functions of a contact surface:
//!
//! ```text
//! psi_m = sum_k S_mk phi_k,   lambda = sum_m lambda_m psi_m,   sum_m S_mk = 1
//! ```
//!
//! phi_k: the functions of the basis `[functions]`; psi_m: those of the multipliers
//! `[multipliers]`. Where supports hold the normal displacement of a node, its function
//! has no trace to act on; the multipliers of its neighbours take it over in equal
//! parts, so that the functions still add up to one and stay positive. Elsewhere S is
//! the identity, and nothing is copied. Cost: one pass over the functions.

use std::borrow::Cow;

/// S, column by column.
#[derive(Clone, Debug, PartialEq)]
pub struct Shares {
    /// Number of multipliers.
    multipliers: usize,
    /// Multipliers that take over each function, with their shares `[functions]`; none
    /// where every function has the multiplier of its own number.
    columns: Option<Vec<Vec<(u32, f64)>>>,
    /// The function whose multiplier each was made, where not all have their own `[multipliers]`; none
    /// where that is on another part of the surface.
    functions: Vec<Option<u32>>,
}

impl Shares {
    /// Every function has a multiplier of its own.
    pub fn identity(functions: usize) -> Self {
        Self {
            multipliers: functions,
            columns: None,
            functions: Vec::new(),
        }
    }

    /// `takers[k]`: the functions that take over function k in equal parts; `None` where
    /// it has a multiplier of its own. Takers have their own; a function without any is
    /// lost.
    pub(super) fn new(takers: &[Option<Vec<u32>>]) -> Self {
        if takers.iter().all(Option::is_none) {
            return Self::identity(takers.len());
        }
        let mut next = 0;
        let own: Vec<u32> = takers
            .iter()
            .map(|taken| {
                next += u32::from(taken.is_none());
                next.saturating_sub(1)
            })
            .collect();
        let column = |(k, taken): (usize, &Option<Vec<u32>>)| match taken {
            None => vec![(own[k], 1.0)],
            Some(takers) => {
                let share = 1.0 / takers.len() as f64;
                let takers = takers.iter();
                takers.map(|&taker| (own[taker as usize], share)).collect()
            }
        };
        let all = (0..).zip(takers).filter(|(_, taken)| taken.is_none());
        Self {
            multipliers: next as usize,
            columns: Some(takers.iter().enumerate().map(column).collect()),
            functions: all.map(|(k, _)| Some(k)).collect(),
        }
    }

    /// Those of some `functions` alone, and the multipliers that occur there, ascending:
    /// they are numbered by their places in this list.
    pub(super) fn of_some(&self, functions: &[u32]) -> (Self, Vec<u32>) {
        let all = functions.iter().flat_map(|&function| self.of(function));
        let mut occurring: Vec<u32> = all.map(|(multiplier, _)| multiplier).collect();
        occurring.sort_unstable();
        occurring.dedup();
        let column = |&function: &u32| -> Vec<(u32, f64)> {
            let place = |m: u32| occurring.partition_point(|&other| other < m) as u32;
            let own = self.of(function);
            own.map(|(m, share)| (place(m), share)).collect()
        };
        let columns: Vec<Vec<(u32, f64)>> = functions.iter().map(column).collect();
        let is_identity = (0..).zip(&columns).all(|(k, column)| *column == [(k, 1.0)]);
        let own = |&m: &u32| -> Option<u32> {
            let function = self.function(m)?;
            let place = functions.iter().position(|&other| other == function)?;
            Some(place as u32)
        };
        let all = occurring.iter().map(own);
        let part = Self {
            multipliers: occurring.len(),
            functions: if is_identity {
                Vec::new()
            } else {
                all.collect()
            },
            columns: (!is_identity).then_some(columns),
        };
        (part, occurring)
    }

    /// The same where `takers[m]` take over multiplier m in equal parts; it keeps its number, and no
    /// function. Takers keep their own.
    pub(super) fn lending(&self, takers: &[Option<Vec<u32>>]) -> Self {
        if takers.iter().all(Option::is_none) {
            return self.clone();
        }
        let functions = self.columns.as_ref().map_or(self.multipliers, Vec::len);
        let column = |function: usize| -> Vec<(u32, f64)> {
            let own = self.of(function as u32);
            let mut column: Vec<(u32, f64)> = own
                .flat_map(|(m, share)| match &takers[m as usize] {
                    None => vec![(m, share)],
                    Some(takers) => {
                        let part = share / takers.len() as f64;
                        takers.iter().map(|&taker| (taker, part)).collect()
                    }
                })
                .collect();
            add_equal_columns(&mut column);
            column
        };
        let all = 0..self.multipliers as u32;
        Self {
            multipliers: self.multipliers,
            columns: Some((0..functions).map(column).collect()),
            functions: all.map(|m| self.function(m)).collect(),
        }
    }

    /// Number of multipliers.
    pub fn multipliers(&self) -> usize {
        self.multipliers
    }

    /// The function whose multiplier this was made; none where that is on another part of the surface.
    pub fn function(&self, multiplier: u32) -> Option<u32> {
        match self.functions.get(multiplier as usize) {
            Some(function) => *function,
            None => Some(multiplier),
        }
    }

    /// Multipliers of a function with their shares.
    pub fn of(&self, function: u32) -> impl Iterator<Item = (u32, f64)> + '_ {
        let columns = self.columns.as_ref();
        let own = columns.map(|columns| columns[function as usize].iter().copied());
        let itself = own.is_none().then_some((function, 1.0));
        itself.into_iter().chain(own.into_iter().flatten())
    }

    /// Coefficients of the functions `[functions]` from those of the multipliers.
    pub fn spread<'a>(&self, multipliers: &'a [f64]) -> Cow<'a, [f64]> {
        let Some(columns) = &self.columns else {
            return Cow::Borrowed(multipliers);
        };
        let coefficient = |column: &Vec<(u32, f64)>| -> f64 {
            let parts = column.iter();
            parts
                .map(|&(m, share)| share * multipliers[m as usize])
                .sum()
        };
        columns.iter().map(coefficient).collect()
    }

    /// Integrals over the functions of the multipliers from those over the functions of
    /// the basis `[functions]`.
    pub fn gather(&self, functions: Vec<f64>) -> Vec<f64> {
        let Some(columns) = &self.columns else {
            return functions;
        };
        let mut sums = vec![0.0; self.multipliers];
        for (column, value) in columns.iter().zip(functions) {
            for &(m, share) in column {
                sums[m as usize] += share * value;
            }
        }
        sums
    }

    /// The same for sparse rows, columns ascending.
    pub fn gather_rows(&self, functions: Vec<Vec<(u32, f64)>>) -> Vec<Vec<(u32, f64)>> {
        let Some(columns) = &self.columns else {
            return functions;
        };
        let mut rows: Vec<Vec<(u32, f64)>> = vec![Vec::new(); self.multipliers];
        for (column, entries) in columns.iter().zip(functions) {
            for &(m, share) in column {
                let row = &mut rows[m as usize];
                row.extend(
                    entries
                        .iter()
                        .map(|&(unknown, value)| (unknown, share * value)),
                );
            }
        }
        rows.iter_mut().for_each(add_equal_columns);
        rows
    }
}

/// Sorts a row and adds up entries of the same column, in their order.
pub(crate) fn add_equal_columns(row: &mut Vec<(u32, f64)>) {
    row.sort_by_key(|entry| entry.0);
    row.dedup_by(|later, first| {
        let is_same = later.0 == first.0;
        if is_same {
            first.1 += later.1;
        }
        is_same
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Function 0 goes to 1 and 3, function 2 is lost.
    fn shares() -> Shares {
        Shares::new(&[Some(vec![1, 3]), None, Some(Vec::new()), None])
    }

    #[test]
    fn a_held_function_goes_to_its_takers_in_equal_parts() {
        let shares = shares();
        assert_eq!(shares.multipliers(), 2);
        assert_eq!(shares.spread(&[2.0, 4.0])[..], [3.0, 2.0, 0.0, 4.0]);
        assert_eq!(shares.gather(vec![1.0, 2.0, 4.0, 8.0]), [2.5, 8.5]);
        assert_eq!(shares.of(0).collect::<Vec<_>>(), [(0, 0.5), (1, 0.5)]);
        assert_eq!([0, 1].map(|m| shares.function(m)), [Some(1), Some(3)]);
    }

    #[test]
    fn a_multiplier_that_lends_its_functions_keeps_its_number() {
        let lending = shares().lending(&[None, Some(vec![0])]);
        assert_eq!(lending.multipliers(), 2);
        assert_eq!(lending.spread(&[2.0, 4.0])[..], [2.0, 2.0, 0.0, 2.0]);
        assert_eq!(lending.gather(vec![1.0, 2.0, 4.0, 8.0]), [11.0, 0.0]);
        let alone = Shares::identity(3).lending(&[None, Some(vec![0, 2]), None]);
        assert_eq!(alone.gather(vec![1.0, 2.0, 4.0]), [2.0, 0.0, 5.0]);
    }

    #[test]
    fn rows_add_up_by_column() {
        let rows = vec![
            vec![(0, 2.0), (5, 4.0)],
            vec![(0, 1.0), (3, 1.0)],
            vec![(9, 1.0)],
            vec![(7, 1.0)],
        ];
        let gathered = shares().gather_rows(rows);
        assert_eq!(gathered[0], [(0, 2.0), (3, 1.0), (5, 2.0)]);
        assert_eq!(gathered[1], [(0, 1.0), (5, 2.0), (7, 1.0)]);
    }

    #[test]
    fn the_identity_copies_nothing() {
        let shares = Shares::new(&[None, None]);
        assert_eq!(shares, Shares::identity(2));
        let values = [1.0, 2.0];
        assert!(matches!(shares.spread(&values), Cow::Borrowed(_)));
        assert_eq!(shares.of(1).collect::<Vec<_>>(), [(1, 1.0)]);
    }
}
