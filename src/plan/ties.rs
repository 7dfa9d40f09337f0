//! Ties between bodies: which surface carries the tractions, its functions, and the rows.
//!
//! The carrier is chosen as that of a contact ([`super::pairs`]). All is found at rest and holds for
//! good. Cost: that of [`crate::ties::seam`].

use std::collections::BTreeSet;
use std::sync::Arc;

use super::PlanEntry;
use super::held_nodes::HeldByPlanes;
use super::pairs::{self, PlannedPair};
use crate::contact::ContactSurface;
use crate::contact::basis::Bernstein;
use crate::contact::layout::Layout;
use crate::geometry::vector3::{norm, sub};
use crate::mesh::Mesh;
use crate::scene::validate::Resolved;
use crate::scene::{SceneError, SceneKind, Tie, Violation};
use crate::space::TaylorHood;
use crate::ties::{Lost, Seam, Sides, layout_of};

/// Share of the carrier, and of the other surface, that may have no partner unsaid: facets in the
/// place of curved surfaces are not equally large.
const UNSAID: [f64; 2] = [0.01, 0.1];
/// Part of what is tied that may lie under functions tied by less than half, of the surface that carries: their
/// neighbours take them over. Without unit; chosen: of a block of .3 on facets of .5 nothing was carried at all.
const SHORT: f64 = 0.25;
/// Pairs of vertices that are looked at, at most, to say how far surfaces are apart; chosen.
const MOST_LOOKED_AT: usize = 10_000_000;

/// A tie with its carrier chosen.
#[derive(Clone, Debug)]
pub(crate) struct PlannedTie {
    /// Its surfaces.
    pub(crate) pair: PlannedPair,
    /// Rows of all functions.
    pub(crate) seam: Arc<Seam>,
    /// Functions and multipliers of each component `[components]`.
    pub(crate) layouts: Vec<Layout>,
    /// Parts of the carrier and of the other surface that have a partner.
    shares: [f64; 2],
    /// The part of what is tied under functions of the carrier that are tied by less than half.
    short: f64,
}

impl PlannedTie {
    /// Number of multipliers of all components.
    pub(crate) fn multipliers(&self) -> usize {
        let layouts = self.layouts.iter();
        layouts.map(|layout| layout.shares.multipliers()).sum()
    }

    /// Facets of both sides.
    pub(crate) fn sides(&self) -> [&Vec<u32>; 2] {
        [&self.pair.carrier, &self.pair.other]
    }
}

/// What ties are planned on.
#[derive(Clone, Copy)]
pub(super) struct Ground<'a> {
    pub(super) mesh: &'a Mesh,
    pub(super) space: &'a TaylorHood,
    /// Units of the scaled body over those of the mesh.
    pub(super) scale: f64,
    /// Held unknowns, ascending.
    pub(super) held: &'a [(u32, u16)],
    /// Nodes that planes hold, ascending.
    pub(super) held_nodes: &'a [HeldByPlanes],
    /// Facets on which other multipliers act.
    pub(super) others: &'a [&'a [u32]],
}

/// All ties of a scene.
///
/// # Errors
/// [`SceneError::Invalid`] where two surfaces do not meet.
pub(super) fn choose(
    resolved: &Resolved,
    ground: Ground<'_>,
) -> Result<Vec<PlannedTie>, SceneError> {
    let mut planned: Vec<PlannedTie> = Vec::new();
    let mut taken = nodes_of(ground, ground.others.iter().copied().flatten());
    taken.extend(ground.held_nodes.iter().map(|one| one.held.node));
    for pair in pairs::choose(&resolved.ties, resolved, ground.mesh) {
        let tie = best(pair, resolved.kind, (ground, &taken))?;
        taken.extend(nodes_of(ground, &tie.pair.carrier));
        planned.push(tie);
    }
    Ok(planned)
}

fn nodes_of<'a>(ground: Ground<'_>, facets: impl IntoIterator<Item = &'a u32>) -> BTreeSet<u32> {
    let facets = facets.into_iter();
    let nodes = facets.flat_map(|&facet| {
        let corners = ground.mesh.facet(facet as usize);
        ground.space.facet_nodes(corners)
    });
    nodes.collect()
}

/// The tie with the carrier that a contact has, or the other one where that holds what the first does not:
/// a large facet that is tied in part has no function for the part, nor has a surface that is held.
fn best(
    pair: PlannedPair,
    kind: SceneKind,
    at: (Ground<'_>, &BTreeSet<u32>),
) -> Result<PlannedTie, SceneError> {
    let first = one(pair.clone(), kind, at)?;
    if pair.is_named() || (first.short <= SHORT && first.lacking(at.0).is_empty()) {
        return first.checked(at.0);
    }
    let second = one(
        pair.turned("the other one has no functions for the tied part"),
        kind,
        at,
    )?;
    let lack = |tie: &PlannedTie| tie.lacking(at.0).len();
    let [ours, theirs] = [&first, &second].map(lack);
    if theirs < ours || (theirs == ours && second.short < first.short) {
        second.checked(at.0)
    } else {
        first.checked(at.0)
    }
}

impl PlannedTie {
    /// Components along which no traction acts though the bodies may come apart.
    fn lacking(&self, ground: Ground<'_>) -> Vec<usize> {
        let count = self.layouts.len();
        let other = nodes_of(ground, &self.pair.other);
        let is_free = |component: usize| {
            let unknowns = other.iter().map(|node| *node as usize * count + component);
            let is_held = |unknown: usize| {
                let found = |(held, _): &(u32, u16)| *held as usize;
                ground.held.binary_search_by_key(&unknown, found).is_ok()
            };
            unknowns.into_iter().any(|unknown| !is_held(unknown))
        };
        let has_none = |component: &usize| self.layouts[*component].shares.multipliers() == 0;
        let all = (0..count).filter(has_none);
        all.filter(|component| is_free(*component)).collect()
    }

    /// # Errors
    /// [`SceneError::Invalid`] where no traction acts along a component.
    fn checked(self, ground: Ground<'_>) -> Result<Self, SceneError> {
        let Some(&component) = self.lacking(ground).first() else {
            return Ok(self);
        };
        let axis = ["x", "y", "z"].get(component).unwrap_or(&"z");
        Err(SceneError::Invalid(vec![Violation {
            path: format!("tie.{}.between", self.pair.name),
            message: format!(
                "no traction along {axis} can act: the surface that carries it is held or guided there, or less \
                 than half of each of its facets is tied; name the other surface in `carries`, or refine this one"
            ),
        }]))
    }
}

fn one(
    pair: PlannedPair,
    kind: SceneKind,
    (ground, taken): (Ground<'_>, &BTreeSet<u32>),
) -> Result<PlannedTie, SceneError> {
    let Ground { mesh, space, .. } = ground;
    let base = Layout::of_sides(mesh, space, &pair.carrier);
    let surface = surface_of(ground, kind, &pair.carrier);
    let surface = surface.with_layout(&Bernstein, base.clone());
    let sides = Sides {
        surface: &surface,
        other: &pair.other,
    };
    let seam = Seam::new((mesh, space), sides);
    let covered = seam.share(&surface);
    if covered <= 0.0 {
        return Err(apart(&pair, mesh));
    }
    let components = space.components as u32;
    let layout = |component: u32| {
        let is_taken = |node: u32| {
            let unknown = node * components + component;
            let held = ground
                .held
                .binary_search_by_key(&unknown, |(held, _)| *held);
            held.is_ok() || taken.contains(&node)
        };
        let lost = Lost {
            seam: &seam,
            surface: &surface,
            is_taken: &is_taken,
        };
        layout_of((mesh, space), (&pair.carrier, &base), lost)
    };
    let is_taken = |_: u32| false;
    let lost = Lost {
        seam: &seam,
        surface: &surface,
        is_taken: &is_taken,
    };
    let short = lost.short_share();
    let whole = |surface: &ContactSurface| surface.weights.iter().sum::<f64>();
    let [carrier, other] = [&pair.carrier, &pair.other].map(|side| {
        whole(
            &surface_of(ground, kind, side)
                .with_layout(&Bernstein, Layout::of_sides(mesh, space, side)),
        )
    });
    Ok(PlannedTie {
        layouts: (0..components).map(layout).collect(),
        shares: [covered, (covered * carrier / other).min(1.0)],
        short,
        seam: Arc::new(seam),
        pair,
    })
}

/// The surface of a tie at rest, one function a node.
fn surface_of(ground: Ground<'_>, kind: SceneKind, facets: &[u32]) -> ContactSurface {
    let facets = facets.iter();
    let facets = facets.map(|&facet| ground.mesh.facet(facet as usize).to_vec());
    let facets: Vec<Vec<u32>> = facets.collect();
    let (mesh, space, scale) = (ground.mesh, ground.space, ground.scale);
    match kind {
        SceneKind::Axisymmetric => ContactSurface::about_axis(mesh, space, scale, &facets),
        SceneKind::Solid | SceneKind::PlaneStress | SceneKind::PlaneStrain => {
            ContactSurface::new(mesh, space, scale, &facets)
        }
    }
}

/// The fault of surfaces of which no part has a partner.
fn apart(pair: &PlannedPair, mesh: &Mesh) -> SceneError {
    let vertices = |side: &[u32]| -> BTreeSet<u32> {
        let corners = side.iter().flat_map(|&facet| mesh.facet(facet as usize));
        corners.copied().collect()
    };
    let [first, second] = [&pair.carrier, &pair.other].map(|side| vertices(side));
    let at = |vertex: &u32| mesh.coordinates()[*vertex as usize];
    let all = first
        .iter()
        .flat_map(|a| second.iter().map(move |b| (at(a), norm(sub(at(a), at(b))))));
    let nearest = all.take(MOST_LOOKED_AT).min_by(|a, b| a.1.total_cmp(&b.1));
    let nearest = nearest.map_or(String::new(), |([x, y, z], distance)| {
        format!(": their nearest vertices are {distance:.3e} apart, at ({x:.4}, {y:.4}, {z:.4}) in units of the mesh")
    });
    SceneError::Invalid(vec![Violation {
        path: format!("tie.{}.between", pair.name),
        message: format!(
            "the surfaces do not meet: no part of one lies within a quarter of a facet of the other and faces it{nearest}"
        ),
    }])
}

/// What a plan says of its ties.
pub(super) fn entries(planned: &[PlannedTie], given: &[Tie]) -> Vec<PlanEntry> {
    let all = planned.iter().zip(given);
    all.map(|(tie, given)| {
        let carrier = &given.between[tie.pair.side()];
        let gap = tie.seam.gap.map_or(0.0, |gap| gap.width);
        PlanEntry {
            what: format!("tie {}", tie.pair.name),
            choice: format!(
                "`{carrier}` carries {} tractions; surfaces at most {gap:.1e} apart",
                tie.multipliers()
            ),
            reason: tie.pair.reason().to_owned(),
        }
    })
    .collect()
}

/// Sentences about parts of surfaces that are not tied.
pub(super) fn doubts(planned: &[PlannedTie], given: &[Tie]) -> Vec<String> {
    let mut all = Vec::new();
    for (tie, given) in planned.iter().zip(given) {
        let side = tie.pair.side();
        let order = [side, 1 - side];
        for ((name, share), unsaid) in order.into_iter().zip(tie.shares).zip(UNSAID) {
            if share < 1.0 - unsaid {
                let part = 100.0 * (1.0 - share);
                all.push(format!(
                    "tie `{}`: {part:.0} % of `{}` has no partner on `{}` and is free",
                    tie.pair.name,
                    given.between[name],
                    given.between[1 - name]
                ));
            }
        }
    }
    all
}
