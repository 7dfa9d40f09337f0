//! Names of obstacles and fluids as parts of file names.

use std::collections::HashSet;

/// Bytes of a name in the name of a file: two and a number fit every file system.
const LONGEST_STEM: usize = 100;

/// A name as part of a file name.
pub(super) fn file_stem(name: &str) -> String {
    let safe = |c: char| {
        if c.is_alphanumeric() || matches!(c, '-' | '_' | '.') {
            c
        } else {
            '_'
        }
    };
    let stem: String = name.chars().map(safe).collect();
    let stem = stem.trim_start_matches('.');
    let end = (0..=LONGEST_STEM.min(stem.len()))
        .rev()
        .find(|end| stem.is_char_boundary(*end));
    match stem.get(..end.unwrap_or(0)) {
        None | Some("") => "scene".to_owned(),
        Some(stem) => stem.to_owned(),
    }
}

/// As [`file_stem`] for each name, no two alike, also where case does not count.
pub(super) fn unique_stems(names: impl Iterator<Item = String>) -> Vec<String> {
    let mut taken = HashSet::new();
    let unique = |name: String| {
        let plain = file_stem(&name);
        let numbered = (2..).map(|number| format!("{plain}_{number}"));
        let mut all = std::iter::once(plain.clone()).chain(numbered);
        let free = all.find(|stem| taken.insert(stem.to_lowercase()));
        // There is always a free number.
        free.unwrap_or(plain)
    };
    names.map(unique).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_become_safe_parts_of_file_names() {
        assert_eq!(file_stem("hertz-sphere 2/3"), "hertz-sphere_2_3");
        assert_eq!(file_stem("../../etc"), "_.._etc");
        assert_eq!(file_stem(""), "scene");
        assert_eq!(file_stem(&"\u{b5}".repeat(256)).len(), LONGEST_STEM);
    }

    #[test]
    fn no_two_names_share_a_file() {
        let names = ["a b", "a_b", "A_b", "a_b_2", "", "scene"];
        let stems = unique_stems(names.into_iter().map(str::to_owned));
        assert_eq!(
            stems,
            ["a_b", "a_b_2", "A_b_3", "a_b_2_2", "scene", "scene_2"]
        );
    }
}
