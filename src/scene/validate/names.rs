//! Names: uniqueness, look-up, and the nearest name for a misspelt one.

use std::collections::BTreeSet;

use super::Faults;
use crate::mesh::{GroupKind, Mesh};

/// Names that a hint looks at, and of these the ones that it lists.
const HINT_CANDIDATES: usize = 1000;
const HINT_LISTED: usize = 20;
/// Longest name that is compared letter by letter, bytes.
const HINT_BYTES: usize = 64;

/// `; did you mean ...` for the nearest of `known`, or the first of them.
pub(crate) fn hint<'a>(name: &str, known: impl Iterator<Item = &'a str>) -> String {
    let known: Vec<&str> = known.take(HINT_CANDIDATES).collect();
    let short = |candidate: &&&str| name.len().max(candidate.len()) <= HINT_BYTES;
    let nearest = known
        .iter()
        .filter(short)
        .map(|candidate| (distance(name, candidate), candidate))
        .filter(|(distance, candidate)| 2 * distance <= name.len().max(candidate.len()))
        .min();
    match nearest {
        Some((_, candidate)) => format!("; did you mean `{candidate}`?"),
        None if known.is_empty() => "; there are none".to_owned(),
        None => format!("; known: {}", listed(&known)),
    }
}

fn listed(known: &[&str]) -> String {
    let (listed, rest) = known.split_at(known.len().min(HINT_LISTED));
    match rest.len() {
        0 => listed.join(", "),
        count => format!("{} and {count} more", listed.join(", ")),
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
    let mut seen = BTreeSet::new();
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
    // Each group once: a repeated one would take its memory again.
    let on: BTreeSet<&String> = on.iter().collect();
    for name in on {
        if faults.is_full() {
            break;
        }
        match mesh.group(name, kind) {
            Some(group) => members.extend_from_slice(&group.members),
            None => faults.add(path, missing(mesh, kind, name)),
        }
    }
    members.sort_unstable();
    members.dedup();
    members
}

/// Reports a facet that has the body on both sides.
pub(crate) fn refuse_inner_facets(mesh: &Mesh, facets: &[u32], path: String, faults: &mut Faults) {
    let mut inner = facets
        .iter()
        .filter(|&&f| !mesh.facet_is_boundary(f as usize));
    if let Some(facet) = inner.next() {
        let message = format!("facet {facet} lies inside the body, not on its surface");
        faults.add(path, message);
    }
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

    #[test]
    fn long_lists_and_long_names_are_cut_short() {
        let known: Vec<String> = (0..500).map(|index| format!("group-{index}")).collect();
        let hint = hint("zzz", known.iter().map(String::as_str));
        assert!(hint.ends_with("group-19 and 480 more"), "{hint}");
        let long = "z".repeat(HINT_BYTES + 1);
        assert_eq!(
            super::hint(&long, [long.as_str()].into_iter()),
            format!("; known: {long}")
        );
    }

    #[test]
    fn a_scene_full_of_faults_tells_the_first_hundred() {
        let mut faults = Faults::default();
        check_unique(&mut faults, "probe", std::iter::repeat_n("", 10_000));
        let Err(crate::scene::SceneError::Invalid(all)) = faults.result() else {
            panic!("empty names are faults");
        };
        assert_eq!(all.len(), 100);
        assert_eq!(all[99].path, "probe[99].name");
    }
}
