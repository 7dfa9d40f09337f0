//! From prepared data to the body that they are for.

use std::sync::Arc;

use super::body::Body;
use super::taylor_hood::TaylorHoodBody;
use crate::compare;
use crate::mesh::Mesh;
use crate::plan::Plan;
use crate::prepare::{Prepared, PreparedBody};

/// The body of `plan` on the element of its prepared data.
pub(super) fn body(plan: Arc<Plan>, mesh: Arc<Mesh>, prepared: &Prepared) -> Box<dyn Body> {
    let mesh = plan.body_mesh(&mesh);
    match prepared.body() {
        PreparedBody::TaylorHood(data) => Box::new(TaylorHoodBody::new(plan, mesh, data)),
        PreparedBody::Comparison(data) => compare::body(plan, mesh, data),
    }
}
