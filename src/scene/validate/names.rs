//! Names: uniqueness, look-up, and the nearest name for a misspelt one.

use super::Faults;
use crate::mesh::{GroupKind, Mesh};

/// `; did you mean ...` for the nearest of `known`, or the list of all.
pub(crate) fn hint<'a>(name: &str, known: impl Iterator<Item = &'a str>) -> String {
    let known: Vec<&str> = known.collect();
    let nearest = known
        .iter()
        .map(|candidate| (distance(name, candidate), candidate))
        .filter(|(distance, candidate)| 2 * distance <= name.len().max(candidate.len()))
        .min();
    match nearest {
        Some((_, candidate)) => format!("; did you mean `{candidate}`?"),
        None if known.is_empty() => "; there are none".to_owned(),
        None => format!("; known: {}", known.join(", ")),
    }
}

/// Levenshtein distance.
fn distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, y) in b.iter().enumerate() {
            let replace = diagonal + usize::from(x != *y);
            diagonal = row[j + 1];
            row[j + 1] = replace.min(row[j] + 1).min(row[j + 1] + 1);
        }
    }
    row[b.len()]
}

/// Reports empty and repeated names.
pub(crate) fn check_unique<'a>(
    faults: &mut Faults,
    kind: &str,
    names: impl Iterator<Item = &'a str>,
) {
    let mut seen = std::collections::BTreeSet::new();
    for (index, name) in names.enumerate() {
        if name.is_empty() {
            faults.add(format!("{kind}[{index}].name"), "must not be empty");
        } else if !seen.insert(name) {
            faults.add(
                format!("{kind}[{index}].name"),
                format!("`{name}` is used twice"),
            );
        }
    }
}

/// Members of the groups `on`, ascending and without repeats.
pub(crate) fn members(
    mesh: &Mesh,
    kind: GroupKind,
    path: &str,
    on: &[String],
    faults: &mut Faults,
) -> Vec<u32> {
    if on.is_empty() {
        faults.add(path, "names no group");
    }
    let mut members = Vec::new();
    for name in on {
        match mesh.group(name, kind) {
            Some(group) => members.extend_from_slice(&group.members),
            None => faults.add(path, missing(mesh, kind, name)),
        }
    }
    members.sort_unstable();
    members.dedup();
    members
}

/// The message for a group that the mesh does not have.
pub(crate) fn missing(mesh: &Mesh, kind: GroupKind, name: &str) -> String {
    let what = match kind {
        GroupKind::Cells => "cells",
        GroupKind::Facets => "surface facets",
    };
    let groups = mesh.groups().iter().filter(|group| group.kind == kind);
    let hint = hint(name, groups.map(|group| group.name.as_str()));
    format!("the mesh has no group of {what} named `{name}`{hint}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_misspelt_name_gets_the_nearest_one() {
        let known = ["contact", "top", "body"];
        assert_eq!(
            hint("contct", known.into_iter()),
            "; did you mean `contact`?"
        );
        assert_eq!(
            hint("zzz", known.into_iter()),
            "; known: contact, top, body"
        );
    }
}
