//! Contact between soft bodies: names, surfaces, and what is not solved beside it.
//!
//! Bodies are the connected parts of the mesh; the two surfaces of a contact lie on different ones or
//! on one, or are the same.

use std::collections::BTreeSet;

use super::obstacles::check_friction;
use super::{Faults, ResolvedPair, names, parts};
use crate::mesh::Mesh;
use crate::pairs::Meets;
use crate::scene::{ContactPair, ContactSpace, MaterialModel, Scene, SceneKind};

/// Contacts of a scene at most: each costs a search over its surfaces.
const MOST_CONTACTS: usize = 256;

/// The contacts on their facets.
pub(crate) fn resolve(
    scene: &Scene,
    (kind, mesh): (SceneKind, &Mesh),
    faults: &mut Faults,
) -> Vec<ResolvedPair> {
    if scene.contacts.is_empty() {
        return Vec::new();
    }
    check_names(scene, faults);
    refuse(scene, kind, faults);
    let of_vertex = parts(mesh);
    let contacts = scene.contacts.iter().take(MOST_CONTACTS);
    let contacts: Vec<ResolvedPair> = contacts
        .map(|contact| one(contact, (mesh, &of_vertex), faults))
        .collect();
    refuse_twice(&contacts, faults);
    contacts
}

/// Refuses facets that meet the same facets in two contacts, which would share their pressure at will.
fn refuse_twice(contacts: &[ResolvedPair], faults: &mut Faults) {
    let sets = contacts.iter();
    let sets = sets.map(|one| one.sides.each_ref().map(|side| side.iter().collect()));
    let sets: Vec<[BTreeSet<&u32>; 2]> = sets.collect();
    let meet = |[a, b]: &[BTreeSet<&u32>; 2], [c, d]: &[BTreeSet<&u32>; 2]| {
        let is_one = |a: &BTreeSet<&u32>, b: &BTreeSet<&u32>| !a.is_disjoint(b);
        (is_one(a, c) && is_one(b, d)) || (is_one(a, d) && is_one(b, c))
    };
    for (index, contact) in contacts.iter().enumerate() {
        let earlier = contacts.iter().zip(&sets).take(index);
        let mut twice = earlier.filter(|(_, own)| meet(own, &sets[index]));
        if let Some((other, _)) = twice.next() {
            let path = format!("contact.{}.between", contact.name);
            let message = format!(
                "facets that meet in contact `{}`, too: two surfaces meet in one contact",
                other.name
            );
            faults.add(path, message);
        }
    }
}

/// Names stand for one thing each: results and messages go by them.
fn check_names(scene: &Scene, faults: &mut Faults) {
    let all = scene.contacts.iter().map(|one| one.name.as_str());
    names::check_unique(faults, "contact", all);
    if scene.contacts.len() > MOST_CONTACTS {
        let count = scene.contacts.len();
        let message = format!("are {count}; at most {MOST_CONTACTS} are allowed");
        faults.add("contact", message);
    }
    let obstacles = scene.obstacles.iter().map(|one| &one.name);
    let supports = scene.supports.iter().map(|one| &one.name);
    let taken: BTreeSet<&String> = obstacles.chain(supports).collect();
    for contact in &scene.contacts {
        if taken.contains(&contact.name) {
            let path = format!("contact.{}.name", contact.name);
            faults.add(path, "is that of an obstacle or a support, too");
        }
    }
}

/// Refuses scenes that this version does not solve with several bodies.
fn refuse(scene: &Scene, kind: SceneKind, faults: &mut Faults) {
    let reason = match kind {
        SceneKind::PlaneStrain | SceneKind::Axisymmetric | SceneKind::Solid => None,
        SceneKind::PlaneStress => Some("contact between sheets is not solved yet"),
    };
    if let Some(reason) = reason {
        let message = format!("{reason}, bodies of plane strain, of revolution and in space are");
        faults.unsupported("contact", message);
    }
    if scene.solver.contact_space.named() == Some(ContactSpace::Linear) {
        let message = "of contacts between bodies pressures are quadratic: leave out `linear`";
        faults.add("solver.contact_space", message);
    }
    if scene.manufactured.is_some() {
        let message = "stands beside a manufactured field, which brings its own loads";
        faults.add("contact", message);
    }
    let flows = |model: &MaterialModel| matches!(model, MaterialModel::Stokes { .. });
    if scene.materials.iter().any(|one| flows(&one.model)) {
        faults.add("contact", "a flow has velocities, which close no gap");
    }
}

fn one(
    contact: &ContactPair,
    (mesh, of_vertex): (&Mesh, &[u32]),
    faults: &mut Faults,
) -> ResolvedPair {
    let path = format!("contact.{}", contact.name);
    let between = format!("{path}.between");
    let sides = [0, 1].map(|side| {
        let on = std::slice::from_ref(&contact.between[side]);
        let facets = names::facets(mesh, &between, on, faults);
        names::refuse_inner_facets(mesh, &facets, between.clone(), faults);
        facets
    });
    let bodies = [0, 1].map(|side: usize| bodies(mesh, of_vertex, &sides[side]));
    let meets = if contact.is_of_one_surface() {
        Meets::Itself
    } else if bodies[0].is_disjoint(&bodies[1]) {
        Meets::AnotherBody
    } else {
        refuse_common(&sides, between, faults);
        Meets::ItsBody
    };
    let named = contact.carries.as_ref().and_then(|carries| {
        if meets == Meets::Itself {
            let message = "stands beside `self`: the order along the surface says which part carries; name them as two groups to say which";
            faults.add(format!("{path}.carries"), message);
            return None;
        }
        let side = contact.between.iter().position(|name| name == carries);
        if side.is_none() {
            let [a, b] = &contact.between;
            let message = format!("`{carries}` is none of the groups `{a}` and `{b}`");
            faults.add(format!("{path}.carries"), message);
        }
        side
    });
    check_friction((contact.friction, contact.tresca), &path, faults);
    if meets != Meets::AnotherBody && mesh.cell_kind().dimension() == 3 {
        refuse_rubbing(contact, &path, faults);
    }
    ResolvedPair {
        name: contact.name.clone(),
        sides,
        meets,
        named,
        friction: contact.friction,
        tresca: contact.tresca,
    }
}

/// Refuses two groups of a contact with a common facet.
fn refuse_common([first, second]: &[Vec<u32>; 2], path: String, faults: &mut Faults) {
    if first
        .iter()
        .any(|facet| second.binary_search(facet).is_ok())
    {
        let message = "both groups have the same facets: name one group and `self = true` for a surface that meets itself";
        faults.add(path, message);
    }
}

/// The connected parts that facets lie on.
pub(super) fn bodies(mesh: &Mesh, of_vertex: &[u32], facets: &[u32]) -> BTreeSet<u32> {
    let corners = facets.iter().map(|&facet| mesh.facet(facet as usize));
    let first = corners.filter_map(|corners| corners.first());
    first.map(|&vertex| of_vertex[vertex as usize]).collect()
}

/// Refuses friction of a body on itself in space.
fn refuse_rubbing(contact: &ContactPair, path: &str, faults: &mut Faults) {
    let keys = [
        ("friction", contact.friction > 0.0),
        ("tresca", contact.tresca.is_some()),
    ];
    for (key, _) in keys.into_iter().filter(|(_, is_asked)| *is_asked) {
        let message = "friction of a body on itself in space is not solved yet, without it is";
        faults.unsupported(format!("{path}.{key}"), message);
    }
}
