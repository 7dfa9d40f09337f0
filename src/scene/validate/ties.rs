//! Ties between bodies: names, surfaces, and what cannot be tied.
//!
//! Bodies are the connected parts of the mesh; the two surfaces of a tie lie on different ones. A
//! facet is tied once, and meets nothing else.

use std::collections::{BTreeMap, BTreeSet};

use super::pairs::bodies;
use super::{Faults, Placed, ResolvedFluid, ResolvedPair, names, parts};
use crate::mesh::Mesh;
use crate::pairs::Meets;
use crate::scene::{MaterialModel, Obstacle, Scene, Tie};

/// Ties of a scene at most; chosen, scenes have a few.
const MOST_TIES: usize = 256;

/// What the facets of a scene meet besides.
pub(crate) struct Others<'a> {
    pub(crate) obstacles: &'a [Placed<'a, Obstacle>],
    pub(crate) contacts: &'a [ResolvedPair],
    pub(crate) fluids: &'a [ResolvedFluid],
}

impl<'a> Others<'a> {
    pub(crate) fn of(
        obstacles: &'a [Placed<'a, Obstacle>],
        contacts: &'a [ResolvedPair],
        fluids: &'a [ResolvedFluid],
    ) -> Self {
        Self {
            obstacles,
            contacts,
            fluids,
        }
    }
}

/// The ties on their facets.
pub(crate) fn resolve(
    scene: &Scene,
    mesh: &Mesh,
    others: Others<'_>,
    faults: &mut Faults,
) -> Vec<ResolvedPair> {
    if scene.ties.is_empty() {
        return Vec::new();
    }
    check_names(scene, faults);
    refuse(scene, faults);
    let of_vertex = parts(mesh);
    let ties = scene.ties.iter().take(MOST_TIES);
    let ties: Vec<ResolvedPair> = ties
        .map(|tie| one(tie, (mesh, &of_vertex), faults))
        .collect();
    refuse_shared(&ties, others, faults);
    ties
}

/// Names stand for one thing each: results and messages go by them.
fn check_names(scene: &Scene, faults: &mut Faults) {
    names::check_unique(
        faults,
        "tie",
        scene.ties.iter().map(|one| one.name.as_str()),
    );
    if scene.ties.len() > MOST_TIES {
        let count = scene.ties.len();
        faults.add(
            "tie",
            format!("are {count}; at most {MOST_TIES} are allowed"),
        );
    }
    let contacts = scene.contacts.iter().map(|one| &one.name);
    let obstacles = scene.obstacles.iter().map(|one| &one.name);
    let supports = scene.supports.iter().map(|one| &one.name);
    let taken: BTreeSet<&String> = contacts.chain(obstacles).chain(supports).collect();
    for tie in &scene.ties {
        if taken.contains(&tie.name) {
            let path = format!("tie.{}.name", tie.name);
            faults.add(path, "is that of a contact, an obstacle or a support, too");
        }
    }
}

/// Refuses scenes that are not solved with ties.
fn refuse(scene: &Scene, faults: &mut Faults) {
    if scene.manufactured.is_some() {
        let message = "stands beside a manufactured field, which brings its own loads";
        faults.add("tie", message);
    }
    let flows = |model: &MaterialModel| matches!(model, MaterialModel::Stokes { .. });
    if scene.materials.iter().any(|one| flows(&one.model)) {
        faults.add("tie", "a flow has no surfaces that are bonded");
    }
}

fn one(tie: &Tie, (mesh, of_vertex): (&Mesh, &[u32]), faults: &mut Faults) -> ResolvedPair {
    let path = format!("tie.{}", tie.name);
    let between = format!("{path}.between");
    let sides = [0, 1].map(|side| {
        let on = std::slice::from_ref(&tie.between[side]);
        let facets = names::facets(mesh, &between, on, faults);
        names::refuse_inner_facets(mesh, &facets, between.clone(), faults);
        facets
    });
    let bodies = [0, 1].map(|side: usize| bodies(mesh, of_vertex, &sides[side]));
    if let Some(body) = bodies[0].intersection(&bodies[1]).next() {
        let message = if tie.between[0] == tie.between[1] {
            "names the same group twice".to_owned()
        } else {
            format!(
                "both groups have facets on part {body} of the mesh: bodies that share nodes are bonded already, and a body tied to itself is not solved yet"
            )
        };
        faults.unsupported(between, message);
    }
    let named = tie.carries.as_ref().and_then(|carries| {
        let side = tie.between.iter().position(|name| name == carries);
        if side.is_none() {
            let [a, b] = &tie.between;
            let message = format!("`{carries}` is none of the groups `{a}` and `{b}`");
            faults.add(format!("{path}.carries"), message);
        }
        side
    });
    ResolvedPair {
        name: tie.name.clone(),
        sides,
        meets: Meets::AnotherBody,
        named,
        friction: 0.0,
        tresca: None,
    }
}

/// Refuses facets that are tied twice, or meet something else as well.
fn refuse_shared(ties: &[ResolvedPair], others: Others<'_>, faults: &mut Faults) {
    let mut holders: BTreeMap<u32, String> = BTreeMap::new();
    let mut hold = |facets: &[u32], what: String| {
        for &facet in facets {
            holders.entry(facet).or_insert_with(|| what.clone());
        }
    };
    for one in others.obstacles {
        hold(
            &one.facets,
            format!("may touch obstacle `{}`", one.item.name),
        );
    }
    for one in others.contacts {
        let what = format!("belong to contact `{}`", one.name);
        one.sides.iter().for_each(|side| hold(side, what.clone()));
    }
    for one in others.fluids {
        hold(
            &one.facets,
            format!("may be reached by fluid `{}`", one.name),
        );
    }
    for tie in ties {
        for side in &tie.sides {
            if let Some(what) = side.iter().find_map(|facet| holders.get(facet)) {
                let path = format!("tie.{}.between", tie.name);
                let message = format!("facets {what}, too: a facet meets one thing");
                faults.add(path, message);
            }
            for &facet in side {
                let what = || format!("belong to tie `{}`", tie.name);
                holders.entry(facet).or_insert_with(what);
            }
        }
    }
}
