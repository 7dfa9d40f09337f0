//! Changes of single keys from the command line: `PATH=VALUE`.
//!
//! A path is made of keys and, in arrays, of a `name` or a position from 0:
//! `obstacle.ball.shape.radius=2`, `step.0.increments=4`, or `step[0].increments=4`. Tables on the way that
//! do not exist are made. The value is read as TOML and taken as a string when
//! it is none.

use std::str::FromStr;

use toml::{Table, Value};

use crate::library::error::Violation;

/// Keys whose value is an array of tables.
const ARRAYS: &[&str] = &[
    "support", "traction", "pressure", "obstacle", "step", "probe", "gradient",
];

/// Most parts of a path: no key of a scene lies so deep, and a table nested
/// without end would exhaust the stack.
const DEEPEST: usize = 64;

/// One change.
#[derive(Clone, Debug, PartialEq)]
pub struct Override {
    path: Vec<String>,
    value: Value,
}

impl FromStr for Override {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (path, value) = text.split_once('=').ok_or("PATH=VALUE is expected")?;
        Self::new(path, read_value(value)).map_err(|error| format!("before \"=\": {error}"))
    }
}

/// A value as TOML writes it, else the text itself.
pub fn read_value(text: &str) -> Value {
    let text = text.trim();
    let parsed = format!("value = {text}").parse::<Table>().ok();
    parsed
        .filter(|table| table.len() == 1)
        .and_then(|mut table| table.remove("value"))
        .unwrap_or_else(|| Value::String(text.to_owned()))
}

impl Override {
    /// A change of the key at a path.
    ///
    /// # Errors
    /// What is wrong with the path.
    pub fn new(path: &str, value: Value) -> Result<Self, String> {
        let path = parts(path);
        if path.iter().any(String::is_empty) {
            return Err("the path has an empty part".to_owned());
        }
        if path.len() > DEEPEST {
            return Err(format!("the path has more than {DEEPEST} parts"));
        }
        Ok(Self { path, value })
    }

    /// The parts of its path.
    pub fn path(&self) -> &[String] {
        &self.path
    }

    /// What the key becomes.
    pub fn value(&self) -> &Value {
        &self.value
    }

    /// The same with a relative mesh beginning in a folder.
    #[must_use]
    pub fn beginning_in(mut self, folder: &std::path::Path) -> Self {
        if let Value::String(file) = &mut self.value
            && self.path == ["mesh"]
        {
            *file = folder.join(&*file).to_string_lossy().into_owned();
        }
        self
    }
}

/// The parts of a path: between dots, a part in quotation marks as a whole, an element as `step.0` or, as messages
/// name it, `step[0]`.
fn parts(path: &str) -> Vec<String> {
    let mut all = vec![String::new()];
    let mut is_quoted = false;
    for character in path.chars() {
        let last = all.last_mut();
        match (character, last) {
            ('"', _) => is_quoted = !is_quoted,
            ('.' | '[', _) if !is_quoted => all.push(String::new()),
            (']', _) if !is_quoted => {}
            (other, Some(last)) => last.push(other),
            (_, None) => {}
        }
    }
    all.iter().map(|part| part.trim().to_owned()).collect()
}

impl Override {
    /// Whether it replaces the mesh.
    pub(super) fn is_mesh(&self) -> bool {
        self.path == ["mesh"]
    }

    /// Changes the key in the tables of a scene file.
    pub(super) fn apply(&self, scene: &mut Table) -> Result<(), Violation> {
        self.make_array(scene);
        let Some((last, parents)) = self.path.split_last() else {
            return Ok(());
        };
        let Some((first, parents)) = parents.split_first() else {
            scene.insert(last.clone(), self.value.clone());
            return Ok(());
        };
        let mut place = entry(scene, first);
        for part in parents {
            place = self.step_into(place, part)?;
        }
        *self.step_into(place, last)? = self.value.clone();
        Ok(())
    }

    /// `step.0.…` of a file without steps makes the first one.
    fn make_array(&self, scene: &mut Table) {
        if let Some(first) = self
            .path
            .first()
            .filter(|first| ARRAYS.contains(&first.as_str()))
            && !scene.contains_key(first)
        {
            scene.insert(first.clone(), Value::Array(Vec::new()));
        }
    }

    fn step_into<'a>(&self, place: &'a mut Value, part: &str) -> Result<&'a mut Value, Violation> {
        match place {
            Value::Table(table) => Ok(entry(table, part)),
            Value::Array(array) => {
                let index = index_in(array, part).ok_or_else(|| self.no_element(array, part))?;
                if index == array.len() {
                    array.push(Value::Table(Table::new()));
                }
                let elements = array.len();
                array.get_mut(index).ok_or_else(|| {
                    self.violation(format!("there is no element {part}: there are {elements}"))
                })
            }
            Value::String(_)
            | Value::Integer(_)
            | Value::Float(_)
            | Value::Boolean(_)
            | Value::Datetime(_) => {
                Err(self.violation(format!("--set: \"{part}\" lies inside a single value")))
            }
        }
    }

    fn no_element(&self, array: &[Value], part: &str) -> Violation {
        let names: Vec<&str> = array.iter().filter_map(name).collect();
        let there = if names.is_empty() {
            format!("there are {} without names", array.len())
        } else {
            format!("there are {}", names.join(", "))
        };
        self.violation(format!("--set: no element \"{part}\"; {there}"))
    }

    fn violation(&self, message: String) -> Violation {
        Violation {
            path: self.path.join("."),
            message,
        }
    }
}

fn entry<'a>(table: &'a mut Table, key: &str) -> &'a mut Value {
    table
        .entry(key)
        .or_insert_with(|| Value::Table(Table::new()))
}

fn name(element: &Value) -> Option<&str> {
    element.get("name").and_then(Value::as_str)
}

/// The element called `part`, else the position that `part` is; one after the
/// last table is a new one.
fn index_in(array: &[Value], part: &str) -> Option<usize> {
    let named = array.iter().position(|element| name(element) == Some(part));
    let position = || part.parse().ok().filter(|index| *index <= array.len());
    named.or_else(position)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn changed(text: &str, change: &str) -> Result<Table, Violation> {
        let mut table: Table = text.parse().unwrap();
        change.parse::<Override>().unwrap().apply(&mut table)?;
        Ok(table)
    }

    const BALL: &str =
        "[[obstacle]]\nname = \"ball\"\nshape = { radius = 1.0, centre = [0, 0, 0] }\n";

    #[test]
    fn elements_are_found_by_name_or_position() {
        for change in [
            "obstacle.ball.shape.radius=2",
            "obstacle.0.shape.radius = 2",
            "obstacle[0].shape.radius=2",
        ] {
            let table = changed(BALL, change).unwrap();
            assert_eq!(table["obstacle"][0]["shape"]["radius"], Value::Integer(2));
        }
        let table = changed(BALL, "obstacle.ball.shape.centre.2=1.5").unwrap();
        assert_eq!(
            table["obstacle"][0]["shape"]["centre"][2],
            Value::Float(1.5)
        );
    }

    #[test]
    fn missing_tables_and_the_next_element_are_made() {
        assert_eq!(
            changed("", "solver.tolerance=1e-6").unwrap()["solver"]["tolerance"],
            Value::Float(1e-6)
        );
        assert_eq!(
            changed("", "step.0.increments=4").unwrap()["step"][0]["increments"],
            Value::Integer(4)
        );
    }

    #[test]
    fn a_value_that_is_not_toml_is_a_string() {
        let table = changed("", "mesh=meshes/a b.msh").unwrap();
        assert_eq!(table["mesh"].as_str(), Some("meshes/a b.msh"));
        assert_eq!(
            changed("", "name=1\nother = 2").unwrap()["name"].as_str(),
            Some("1\nother = 2")
        );
        assert_eq!(
            changed("", "on=[\"a\", \"b\"]").unwrap()["on"]
                .as_array()
                .map(Vec::len),
            Some(2)
        );
    }

    #[test]
    fn unknown_elements_name_those_that_exist() {
        let error = changed(BALL, "obstacle.bal.shape.radius=2").unwrap_err();
        assert_eq!(error.path, "obstacle.bal.shape.radius");
        assert!(
            error.message.contains("there are ball"),
            "{}",
            error.message
        );
        assert!(changed(BALL, "obstacle.2.shape.radius=2").is_err());
        assert!(changed("name = \"a\"", "name.b=2").is_err());
    }

    #[test]
    fn text_without_an_equals_sign_or_with_empty_parts_is_refused() {
        assert!("solver.tolerance".parse::<Override>().is_err());
        assert!("solver..tolerance=1".parse::<Override>().is_err());
    }

    #[test]
    fn paths_end_at_their_greatest_depth() {
        let path = |parts: usize| vec!["a"; parts].join(".") + "=1";
        assert!(changed("", &path(DEEPEST)).is_ok());
        assert!(path(DEEPEST + 1).parse::<Override>().is_err());
    }
}
