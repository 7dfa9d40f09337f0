//! How much a scene names in all, checked before any of it is copied: lists are
//! short, but each name in them may stand for millions of facets.

use std::collections::HashMap;

use super::Faults;
use crate::mesh::{GroupKind, Mesh};
use crate::scene::Scene;

/// Names of groups in all lists together.
const MOST_NAMES: usize = 100_000;
/// Times that the lists together may name each facet of the mesh, on average.
const MOST_TIMES: usize = 8;
/// Facets that the lists of a scene on any mesh may name.
const ALWAYS: usize = 100_000;

/// Refuses a scene whose lists name far more than its mesh has.
pub(super) fn check(scene: &Scene, mesh: &Mesh, faults: &mut Faults) {
    let supports = scene.supports.iter().map(|one| &one.on);
    let tractions = scene.tractions.iter().map(|one| &one.on);
    let pressures = scene.pressures.iter().map(|one| &one.on);
    let obstacles = scene.obstacles.iter().map(|one| &one.on);
    let fluids = scene.fluids.iter();
    let fluids = fluids.flat_map(|one| [&one.on, &one.from, &one.dry]);
    let lists = || {
        supports
            .clone()
            .chain(tractions.clone())
            .chain(pressures.clone())
            .chain(obstacles.clone())
            .chain(fluids.clone())
    };
    let names: usize = lists().map(Vec::len).sum();
    if names > MOST_NAMES {
        let message = format!("lists name {names} groups in all; at most {MOST_NAMES} are allowed");
        return faults.add("on", message);
    }
    let groups = mesh.groups().iter();
    let facets = groups.filter(|group| group.kind == GroupKind::Facets);
    let sizes: HashMap<&str, usize> = facets
        .map(|group| (group.name.as_str(), group.members.len()))
        .collect();
    let named = |name: &String| sizes.get(name.as_str()).copied().unwrap_or(0);
    let facets: usize = lists().flatten().map(named).sum();
    let most = MOST_TIMES * mesh.facet_count() + ALWAYS;
    if facets > most {
        let message = format!("lists name {facets} facets in all; at most {most} are allowed");
        faults.add("on", message);
    }
}
