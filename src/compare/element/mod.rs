//! Bodies of the elements that Taylor-Hood is compared with: prepared data, the body at
//! a state, its contacts, and results.

mod body;
mod contact;
mod increment;
pub(crate) mod prepared;
mod report;
mod solve;
mod values;

use std::sync::Arc;

use crate::compare::space::enriched::{Enriched, Enrichment};
use crate::mesh::Mesh;
use crate::plan::Plan;
use crate::prepare::PrepareError;
use crate::report::CancelToken;
use crate::scene::ElementKind;
use crate::session::body::Body;
use body::EnrichedBody;
use prepared::ComparisonData;

/// What an element adds to P1; nothing for Taylor-Hood.
fn enrichment(element: ElementKind) -> Option<Enrichment> {
    match element {
        ElementKind::TaylorHood => None,
        ElementKind::Mini => Some(Enrichment::CellBubbles),
        ElementKind::BernardiRaugel => Some(Enrichment::FacetBubbles),
    }
}

/// Displacement and pressure unknowns of `element` on `mesh`; none for Taylor-Hood.
pub(crate) fn unknowns(element: ElementKind, mesh: &Mesh) -> Option<(usize, usize)> {
    let space = Enriched::new(mesh, enrichment(element)?);
    Some((space.displacement_unknowns(), space.pressure_unknowns()))
}

/// The data of the element that `plan` names; none for Taylor-Hood.
pub(crate) fn prepared(
    plan: &Plan,
    mesh: &Arc<Mesh>,
    cancel: &CancelToken,
) -> Result<Option<ComparisonData>, PrepareError> {
    let build = |enrichment| ComparisonData::build(plan, enrichment, mesh, cancel);
    enrichment(plan.element).map(build).transpose()
}

/// The body of `plan` on its prepared data.
pub(crate) fn body(plan: Arc<Plan>, mesh: Arc<Mesh>, data: Arc<ComparisonData>) -> Box<dyn Body> {
    Box::new(EnrichedBody::new(plan, mesh, data))
}
