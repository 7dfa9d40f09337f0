//! The key that somebody meant who wrote another one.

/// What is wrong with a text, and which key an unknown one is nearest to.
pub(super) fn told(error: &toml::de::Error) -> String {
    match unknown(error.message()).and_then(|(key, known)| nearest(key, &known)) {
        Some(meant) => format!("{error}did you mean `{meant}`?\n"),
        None => error.to_string(),
    }
}

/// The unknown key of a message, and all known ones.
fn unknown(message: &str) -> Option<(&str, Vec<&str>)> {
    let quoted = message.strip_prefix("unknown field ")?;
    let mut words = quoted.split('`').skip(1).step_by(2);
    Some((words.next()?, words.collect()))
}

/// The known key that differs least, if it is near enough to be meant.
fn nearest<'a>(key: &str, known: &[&'a str]) -> Option<&'a str> {
    let changes = |one: &&str| strsim::levenshtein(key, one);
    let nearest = known.iter().copied().min_by_key(changes)?;
    (changes(&nearest) <= 1 + key.len() / 3).then_some(nearest)
}

#[cfg(test)]
mod tests {
    use super::super::Config;

    #[test]
    fn a_misspelt_key_is_told_with_the_one_that_was_meant() {
        for (written, meant) in [
            ("solver_slot = 3", "did you mean `solver_slots`?"),
            ("token = \"a\"", "did you mean `tokens`?"),
            (
                "memory_budget_byte = 3",
                "did you mean `memory_budget_bytes`?",
            ),
        ] {
            let said = Config::from_toml(written).unwrap_err().to_string();
            assert!(said.contains(meant), "{said}");
        }
        let said = Config::from_toml("colour = 3").unwrap_err().to_string();
        assert!(!said.contains("did you mean"), "{said}");
        let said = Config::from_toml("solver_slots = true")
            .unwrap_err()
            .to_string();
        assert!(!said.contains("did you mean"), "{said}");
    }
}
