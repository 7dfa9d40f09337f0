//! From the element that a plan names to its prepared data.

use std::sync::Arc;

use super::{PrepareError, PreparedBody, TaylorHoodData};
use crate::compare;
use crate::mesh::Mesh;
use crate::plan::Plan;
use crate::report::CancelToken;

pub(crate) use crate::compare::ComparisonData;

/// The data of the element that `plan` names.
pub(crate) fn body(
    plan: &Plan,
    mesh: &Arc<Mesh>,
    cancel: &CancelToken,
) -> Result<PreparedBody, PrepareError> {
    let mesh = plan.body_mesh(mesh);
    Ok(match compare::prepared(plan, &mesh, cancel)? {
        Some(data) => PreparedBody::Comparison(Arc::new(data)),
        None => PreparedBody::TaylorHood(Arc::new(TaylorHoodData::build(plan, &mesh, cancel)?)),
    })
}
