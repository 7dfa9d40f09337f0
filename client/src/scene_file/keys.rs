//! Walks a TOML table with its list of known keys and collects every fault
//! with its path.

use std::cell::RefCell;

use toml::{Table, Value};

use super::suggest::nearest;
use crate::library::error::Violation;

/// Faults that are told, as many as the server looks for.
const MOST: usize = 100;
/// Elements of one list of tables, as many as the server takes of the longest.
const MOST_TABLES: usize = 10_000;

/// Faults found so far.
#[derive(Debug, Default)]
pub(crate) struct Faults(RefCell<Vec<Violation>>);

impl Faults {
    /// Whether no further fault is told, so that none needs to be looked for.
    pub(crate) fn is_full(&self) -> bool {
        self.0.borrow().len() > MOST
    }

    pub(crate) fn add(&self, path: String, message: String) {
        let mut all = self.0.borrow_mut();
        match all.len() {
            0..MOST => all.push(Violation { path, message }),
            MOST => all.push(Violation {
                path: String::new(),
                message: format!("there are more than these {MOST} faults"),
            }),
            _ => {}
        }
    }

    pub(crate) fn finish(self) -> Result<(), Vec<Violation>> {
        let faults = self.0.into_inner();
        if faults.is_empty() {
            Ok(())
        } else {
            Err(faults)
        }
    }
}

/// One table of the file.
pub(crate) struct Keys<'a> {
    path: String,
    table: &'a Table,
    faults: &'a Faults,
}

impl<'a> Keys<'a> {
    /// A table; keys that are not known are faults.
    pub(crate) fn new(path: String, table: &'a Table, known: &[&str], faults: &'a Faults) -> Self {
        let keys = Self {
            path,
            table,
            faults,
        };
        let unknown = table.keys().filter(|key| !known.contains(&key.as_str()));
        for key in unknown.take_while(|_| !faults.is_full()) {
            faults.add(keys.at(key), unknown_key(key, known));
        }
        keys
    }

    fn at(&self, key: &str) -> String {
        join(&self.path, key)
    }

    pub(crate) fn fault(&self, key: &str, message: impl Into<String>) {
        self.faults.add(self.at(key), message.into());
    }

    /// A fault of the table as a whole.
    pub(crate) fn fault_here(&self, message: impl Into<String>) {
        self.faults.add(self.path.clone(), message.into());
    }

    pub(crate) fn has(&self, key: &str) -> bool {
        self.table.contains_key(key)
    }

    /// Whether a key has a text for its value.
    pub(crate) fn has_text(&self, key: &str) -> bool {
        self.table.get(key).is_some_and(Value::is_str)
    }

    fn wrong_type(&self, key: &str, expected: &str, found: &Value) {
        self.fault(
            key,
            format!("{expected} is expected, found {}", type_name(found)),
        );
    }

    /// The value as `read` takes it; a fault when it does not.
    pub(crate) fn read<T>(
        &self,
        key: &str,
        expected: &str,
        read: impl FnOnce(&'a Value) -> Option<T>,
    ) -> Option<T> {
        let value = self.table.get(key)?;
        let taken = read(value);
        if taken.is_none() {
            self.wrong_type(key, expected, value);
        }
        taken
    }

    /// Whether a key is there and a number.
    pub(crate) fn has_number(&self, key: &str) -> bool {
        self.table
            .get(key)
            .is_some_and(|value| as_number(value).is_some())
    }

    /// Its keys, whatever they are, at most as many as a list may have elements.
    pub(crate) fn names_of_keys(&self) -> Vec<String> {
        self.table.keys().take(MOST_TABLES).cloned().collect()
    }

    /// Reports a required key that is missing.
    pub(crate) fn require(&self, key: &str) {
        if !self.has(key) {
            self.fault(key, "required key is missing");
        }
    }

    pub(crate) fn number(&self, key: &str) -> Option<f64> {
        self.read(key, "a number", as_number)
    }

    pub(crate) fn required_number(&self, key: &str) -> Option<f64> {
        self.require(key);
        self.number(key)
    }

    pub(crate) fn integer(&self, key: &str) -> Option<i32> {
        let value = self.read(key, "an integer", Value::as_integer)?;
        let small = i32::try_from(value);
        if small.is_err() {
            self.fault(key, format!("{value} is out of range"));
        }
        small.ok()
    }

    pub(crate) fn boolean(&self, key: &str) -> Option<bool> {
        self.read(key, "true or false", Value::as_bool)
    }

    pub(crate) fn text(&self, key: &str) -> Option<String> {
        self.read(key, "a string", Value::as_str).map(str::to_owned)
    }

    pub(crate) fn required_text(&self, key: &str) -> String {
        self.require(key);
        self.text(key).unwrap_or_default()
    }

    /// Another type than text, or one word that stands for leaving the key out.
    pub(crate) fn text_or<T>(
        &self,
        key: &str,
        word: &str,
        read: impl FnOnce(&Self, &str) -> Option<T>,
    ) -> Option<T> {
        let given = self.table.get(key).and_then(Value::as_str);
        if given == Some(word) {
            None
        } else {
            read(self, key)
        }
    }

    /// One of some words.
    pub(crate) fn choice<T: Copy>(&self, key: &str, choices: &[(&str, T)]) -> Option<T> {
        let word = self.text(key)?;
        let found = choices.iter().find(|(name, _)| *name == word);
        if found.is_none() {
            self.unknown_word(key, &word, choices.iter().map(|(name, _)| *name));
        }
        found.map(|(_, value)| *value)
    }

    pub(crate) fn unknown_word<'w>(
        &self,
        key: &str,
        word: &str,
        known: impl Iterator<Item = &'w str> + Clone,
    ) {
        let message = match nearest(word, known.clone()) {
            Some(near) => format!("\"{word}\" is not known; did you mean \"{near}\"?"),
            None => {
                let known: Vec<_> = known.collect();
                format!("\"{word}\" is not known; known are {}", known.join(", "))
            }
        };
        self.fault(key, message);
    }

    /// A string or a list of strings.
    pub(crate) fn names(&self, key: &str) -> Vec<String> {
        let names = self.read(key, "a string or a list of strings", |value| match value {
            Value::String(name) => Some(vec![name.clone()]),
            Value::Array(names) => names
                .iter()
                .map(|name| name.as_str().map(str::to_owned))
                .collect(),
            Value::Integer(_)
            | Value::Float(_)
            | Value::Boolean(_)
            | Value::Datetime(_)
            | Value::Table(_) => None,
        });
        names.unwrap_or_default()
    }

    pub(crate) fn required_names(&self, key: &str) -> Vec<String> {
        self.require(key);
        self.names(key)
    }

    /// Numbers in any count.
    pub(crate) fn numbers(&self, key: &str) -> Vec<f64> {
        let numbers = self.read(key, "a list of numbers", |value| {
            value
                .as_array()?
                .iter()
                .map(as_number)
                .collect::<Option<Vec<f64>>>()
        });
        numbers.unwrap_or_default()
    }

    /// Three numbers; empty when the key is left out.
    pub(crate) fn vector(&self, key: &str) -> Vec<f64> {
        let numbers = self.read(key, "a list of three numbers", |value| {
            let numbers = value.as_array()?;
            numbers.iter().map(as_number).collect::<Option<Vec<f64>>>()
        });
        let Some(numbers) = numbers else {
            return Vec::new();
        };
        let count = numbers.len();
        if count == 3 {
            return numbers;
        }
        let more = if count == 2 { ": add a third, 0" } else { "" };
        self.fault(
            key,
            format!("a list of three numbers is expected, found {count}{more}"),
        );
        Vec::new()
    }

    pub(crate) fn required_vector(&self, key: &str) -> Vec<f64> {
        self.require(key);
        self.vector(key)
    }

    fn raw_table(&self, key: &str) -> Option<&'a Table> {
        self.read(key, "a table", Value::as_table)
    }

    /// A table of known keys.
    pub(crate) fn table(&self, key: &str, known: &[&str]) -> Option<Keys<'a>> {
        let table = self.raw_table(key)?;
        Some(Keys::new(self.at(key), table, known, self.faults))
    }

    /// A table whose keys are not checked before more of it is known.
    pub(crate) fn open_table(&self, key: &str) -> Option<Keys<'a>> {
        let (path, table) = (self.at(key), self.raw_table(key)?);
        Some(Keys {
            path,
            table,
            faults: self.faults,
        })
    }

    pub(crate) fn required_open_table(&self, key: &str) -> Option<Keys<'a>> {
        self.require(key);
        self.open_table(key)
    }

    /// Checks the keys of a table made by [`Keys::open_table`].
    pub(crate) fn check(&self, known: &[&str]) {
        Keys::new(self.path.clone(), self.table, known, self.faults);
    }

    /// Whether a list is no longer than any that a server takes; a fault where it is, before
    /// anybody looks at what is in it.
    fn is_short(&self, key: &str, count: usize) -> bool {
        if count > MOST_TABLES {
            let message = format!("has {count} elements; at most {MOST_TABLES} are allowed");
            self.fault(key, message);
        }
        count <= MOST_TABLES
    }

    /// The tables in a table, by name.
    pub(crate) fn named_tables(&self, key: &str) -> Vec<(String, Keys<'a>)> {
        let Some(outer) = self.open_table(key) else {
            return Vec::new();
        };
        if !self.is_short(key, outer.table.len()) {
            return Vec::new();
        }
        let names = outer.table.keys();
        names
            .take_while(|_| !self.faults.is_full())
            .filter_map(|name| Some((name.clone(), outer.open_table(name)?)))
            .collect()
    }

    /// An array of tables. Those with a `name` are called by it in paths, the
    /// others by their position.
    pub(crate) fn tables(&self, key: &str, known: &[&str]) -> Vec<Keys<'a>> {
        let count = self
            .table
            .get(key)
            .and_then(Value::as_array)
            .map_or(0, Vec::len);
        if !self.is_short(key, count) {
            return Vec::new();
        }
        let expected = format!("an array of tables ([[{key}]], once for each, not [{key}])");
        let tables = self.read(key, &expected, |value| {
            value
                .as_array()?
                .iter()
                .map(Value::as_table)
                .collect::<Option<Vec<_>>>()
        });
        let tables = tables.unwrap_or_default().into_iter().enumerate();
        tables
            .take_while(|_| !self.faults.is_full())
            .map(|(index, table)| {
                let path = match table.get("name").and_then(Value::as_str) {
                    Some(name) => join(&self.at(key), name),
                    None => format!("{}[{index}]", self.at(key)),
                };
                Keys::new(path, table, known, self.faults)
            })
            .collect()
    }
}

/// What is told of a key that nobody knows.
fn unknown_key(key: &str, known: &[&str]) -> String {
    let mut units = ["_degrees", "_degree", "_deg"].into_iter();
    let bare = units.find_map(|unit| key.strip_suffix(unit));
    if let Some(near) = bare.and_then(|bare| known.iter().find(|known| **known == bare)) {
        return format!(
            "unknown key; did you mean \"{near}\"? It is in radians: 90 degrees are 1.5708"
        );
    }
    match nearest(key, known.iter().copied()) {
        Some(near) => format!("unknown key; did you mean \"{near}\"?"),
        None => format!("unknown key; known keys are {}", known.join(", ")),
    }
}

fn join(path: &str, key: &str) -> String {
    if path.is_empty() {
        key.to_owned()
    } else {
        format!("{path}.{key}")
    }
}

#[allow(clippy::cast_precision_loss)]
fn as_number(value: &Value) -> Option<f64> {
    value
        .as_float()
        .or_else(|| value.as_integer().map(|integer| integer as f64))
}

fn type_name(value: &Value) -> &'static str {
    match value {
        Value::String(_) => "a string",
        Value::Integer(_) => "an integer",
        Value::Float(_) => "a number",
        Value::Boolean(_) => "true or false",
        Value::Datetime(_) => "a date",
        Value::Array(_) => "a list",
        Value::Table(_) => "a table",
    }
}
