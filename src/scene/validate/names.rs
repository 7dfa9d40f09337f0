//! Names of a scene: uniqueness, and look-up in the mesh.

use std::collections::BTreeSet;

use super::Faults;
use crate::mesh::{GroupKind, Mesh};
use crate::scene::names::hint;

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

/// Facets of the groups `on`, ascending and without repeats.
pub(crate) fn facets(mesh: &Mesh, path: &str, on: &[String], faults: &mut Faults) -> Vec<u32> {
    if on.is_empty() {
        faults.add(path, "names no group");
    }
    let mut facets = Vec::new();
    // Each group once: a repeated one would take its memory again.
    let on: BTreeSet<&String> = on.iter().collect();
    for name in on {
        if faults.is_full() {
            break;
        }
        match mesh.group(name, GroupKind::Facets) {
            Some(group) => facets.extend_from_slice(&group.members),
            None => faults.add(path, missing(mesh, GroupKind::Facets, name)),
        }
    }
    facets.sort_unstable();
    facets.dedup();
    facets
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
