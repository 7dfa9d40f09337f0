//! The part of JSON Schema that `result-lines.schema.json` uses.

use serde_json::Value;

/// The schema of result lines.
pub(crate) fn result_lines() -> Value {
    serde_json::from_str(include_str!("../../result-lines.schema.json")).unwrap()
}

/// The first place where a value does not match; none when it does.
pub(crate) fn fault(root: &Value, value: &Value) -> Option<String> {
    check(root, root, value, "line").err()
}

fn check(root: &Value, schema: &Value, value: &Value, path: &str) -> Result<(), String> {
    for (keyword, rule) in schema.as_object().expect("a schema is an object") {
        let matches = match keyword.as_str() {
            "$schema" | "title" | "$defs" | "properties" | "additionalProperties" => true,
            "$ref" => return check(root, resolve(root, rule), value, path),
            "oneOf" => return alternatives(root, rule, value, path, 1..=1),
            "anyOf" => return alternatives(root, rule, value, path, 1..=usize::MAX),
            "type" => is_of_type(rule, value),
            "const" => rule == value,
            "enum" => rule.as_array().unwrap().contains(value),
            "minimum" => value.as_f64() >= rule.as_f64(),
            "minItems" => {
                value.as_array().map(Vec::len) >= rule.as_u64().map(|count| count as usize)
            }
            "maxItems" => {
                value.as_array().map(Vec::len) <= rule.as_u64().map(|count| count as usize)
            }
            "required" => rule
                .as_array()
                .unwrap()
                .iter()
                .all(|key| value.get(key.as_str().unwrap()).is_some()),
            "items" => {
                for item in value.as_array().into_iter().flatten() {
                    check(root, rule, item, path)?;
                }
                true
            }
            other => unreachable!("keyword {other}"),
        };
        if !matches {
            return Err(format!(
                "{path}: {keyword} {rule} does not hold for {value}"
            ));
        }
    }
    properties(root, schema, value, path)
}

fn properties(root: &Value, schema: &Value, value: &Value, path: &str) -> Result<(), String> {
    for (key, item) in value.as_object().into_iter().flatten() {
        let path = format!("{path}.{key}");
        let own = schema
            .get("properties")
            .and_then(|properties| properties.get(key));
        match own.or_else(|| schema.get("additionalProperties")) {
            Some(Value::Bool(false)) => return Err(format!("{path}: not in the schema")),
            Some(rule @ Value::Object(_)) => check(root, rule, item, &path)?,
            _ => {}
        }
    }
    Ok(())
}

fn alternatives(
    root: &Value,
    rules: &Value,
    value: &Value,
    path: &str,
    wanted: std::ops::RangeInclusive<usize>,
) -> Result<(), String> {
    let rules = rules.as_array().unwrap().iter();
    let outcomes: Vec<_> = rules.map(|rule| check(root, rule, value, path)).collect();
    if wanted.contains(&outcomes.iter().filter(|outcome| outcome.is_ok()).count()) {
        return Ok(());
    }
    let faults: Vec<_> = outcomes.into_iter().filter_map(Result::err).collect();
    Err(faults.join(" | "))
}

fn resolve<'a>(root: &'a Value, reference: &Value) -> &'a Value {
    let pointer = reference.as_str().unwrap().strip_prefix('#').unwrap();
    root.pointer(pointer).expect("the reference exists")
}

fn is_of_type(rule: &Value, value: &Value) -> bool {
    let one = |name: &str| match name {
        "null" => value.is_null(),
        "number" => value.is_number(),
        "integer" => value.is_i64() || value.is_u64(),
        "string" => value.is_string(),
        "object" => value.is_object(),
        "array" => value.is_array(),
        other => unreachable!("type {other}"),
    };
    let names = rule
        .as_array()
        .map_or(std::slice::from_ref(rule), Vec::as_slice);
    names.iter().any(|name| one(name.as_str().unwrap()))
}
