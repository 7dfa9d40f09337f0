//! Columns that are computed from others of their row: keys that vary and results.

use serde_json::Value;

use super::expression::Expression;
use super::{At, COLUMNS_AFTER, COLUMNS_BEFORE, Case, TAKEN, Wanted, violation};
use crate::library::error::Violation;

/// A column to be computed, as a study says it.
#[derive(Debug)]
pub(crate) struct Sought {
    pub(crate) name: String,
    pub(crate) text: String,
}

/// A column that is computed.
#[derive(Clone, Debug)]
pub struct Derived {
    /// Its column.
    pub name: String,
    expression: Expression,
}

/// The columns of a study before the first that is computed, and whether a row has a number there.
pub(super) struct Columns<'a> {
    names: Vec<&'a str>,
    numeric: Vec<bool>,
}

impl<'a> Columns<'a> {
    /// Keys, and whether their values are numbers; results.
    pub(super) fn new(keys: &'a [String], numeric: Vec<bool>, wanted: &'a [Wanted]) -> Self {
        let results = wanted.iter().map(|one| one.name.as_str());
        let names = keys.iter().map(String::as_str).chain(results).collect();
        let are_numbers = wanted.iter().map(|one| one.at != At::Every);
        let numeric = numeric.into_iter().chain(are_numbers).collect();
        Self { names, numeric }
    }

    /// Reads what is sought; each may name those before it.
    ///
    /// # Errors
    /// What is wrong with each.
    pub(super) fn read(mut self, sought: &'a [Sought]) -> Result<Vec<Derived>, Vec<Violation>> {
        let (mut derived, mut faults) = (Vec::new(), Vec::new());
        for one in sought {
            let name = one.name.clone();
            if self.is_taken(&name) {
                faults.push(violation(&format!("result.{name}"), TAKEN));
            }
            match self.expression(&one.text) {
                Ok(expression) => derived.push(Derived { name, expression }),
                Err(fault) => faults.push(violation(&format!("result.{name}.expression"), fault)),
            }
            self.names.push(&one.name);
            self.numeric.push(true);
        }
        if faults.is_empty() {
            Ok(derived)
        } else {
            Err(faults)
        }
    }

    fn is_taken(&self, name: &str) -> bool {
        let mut fixed = COLUMNS_BEFORE.iter().chain(&COLUMNS_AFTER);
        fixed.any(|one| *one == name) || self.names.contains(&name)
    }

    fn expression(&self, text: &str) -> Result<Expression, String> {
        let expression = Expression::read(text, &self.names)?;
        let wrong = expression
            .columns()
            .find(|at| self.numeric.get(*at) == Some(&false));
        match wrong.and_then(|at| self.names.get(at)) {
            Some(name) => Err(format!("the column \"{name}\" has no numbers")),
            None => Ok(expression),
        }
    }
}

/// The values of the columns of a row that are computed; none where one that they are made from
/// lacks, or that are no finite numbers.
pub(super) fn values(derived: &[Derived], case: &Case, results: &[Value]) -> Vec<Option<f64>> {
    let keys = case.values.iter().map(|value| {
        let value = value.as_ref()?;
        value
            .as_float()
            .or(value.as_integer().map(|whole| whole as f64))
    });
    let mut columns: Vec<Option<f64>> = keys.chain(results.iter().map(Value::as_f64)).collect();
    let before = columns.len();
    for one in derived {
        columns.push(one.expression.value(&columns));
    }
    columns.split_off(before)
}
