//! What a run of a trial said, and what is known of it otherwise.

use std::process::Output;

use serde_json::Value;

/// A number that is known without the run, and what errors are relative to.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Known {
    pub(super) number: f64,
    pub(super) scale: f64,
}

impl Known {
    /// A number, errors relative to its size.
    pub(super) fn of(number: f64) -> Self {
        let scale = number.abs();
        Self { number, scale }
    }

    /// The relative error of another number.
    pub(super) fn error(self, found: f64) -> f64 {
        (found - self.number).abs() / self.scale
    }
}

/// What a process said.
#[derive(Clone, Debug, Default)]
pub(super) struct Lines {
    /// One a result.
    pub(super) steps: Vec<Value>,
    pub(super) summary: Value,
}

impl Lines {
    pub(super) fn read(output: &Output) -> Self {
        let text = String::from_utf8_lossy(&output.stdout);
        let lines = text.lines();
        let mut read = Self::default();
        for line in lines.filter_map(|line| serde_json::from_str::<Value>(line).ok()) {
            match line.get("event").and_then(Value::as_str) {
                Some("step") => read.steps.push(line),
                Some("summary") => read.summary = line,
                _ => {}
            }
        }
        read
    }

    /// A number of the last result.
    pub(super) fn last(&self, pointer: &str) -> Option<f64> {
        self.steps.last()?.pointer(pointer)?.as_f64()
    }

    /// A number at the end of a step.
    pub(super) fn of_step(&self, step: u64, pointer: &str) -> Option<f64> {
        let is_of = |line: &&Value| line.get("step").and_then(Value::as_u64) == Some(step);
        let line = self.steps.iter().rfind(is_of)?;
        line.pointer(pointer)?.as_f64()
    }

    /// These results.
    #[cfg(test)]
    pub(super) fn of(steps: Vec<Value>) -> Self {
        Self {
            steps,
            ..Self::default()
        }
    }

    /// Kinds of the warnings of all results.
    pub(super) fn warnings(&self) -> Vec<String> {
        let warnings = self
            .steps
            .iter()
            .filter_map(|line| line.get("warnings")?.as_array());
        each_once(warnings.flatten().map(|warning| warning.get("kind")))
    }

    /// A word of the last result; empty where there is none.
    pub(super) fn word(&self, key: &str) -> &str {
        let last = self.steps.last().and_then(|line| line.get(key));
        last.and_then(Value::as_str).unwrap_or_default()
    }

    pub(super) fn falls(&self) -> usize {
        let fell = |line: &&Value| line.get("snapped").is_some_and(Value::is_object);
        self.steps.iter().filter(fell).count()
    }

    pub(super) fn total(&self, path: &str) -> Option<&Value> {
        self.summary.pointer(&format!("/totals/{path}"))
    }
}

/// The words among these, in their order.
fn each_once<'a>(words: impl Iterator<Item = Option<&'a Value>>) -> Vec<String> {
    let mut found: Vec<String> = Vec::new();
    for word in words.filter_map(|word| word?.as_str()) {
        if !found.iter().any(|known| known == word) {
            found.push(word.to_owned());
        }
    }
    found
}
