//! The surface of the body: edges have the offsets of a second-order mesh, and those of arcs that
//! are fitted over the facets of obstacles that ask for them. Cells follow them. Cost: a copy of the
//! mesh where arcs are fitted, else nothing.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::Plan;
use crate::contact::smooth::smooth_offsets;
use crate::mesh::{EdgeOffset, Mesh};
use crate::scene::SurfaceGeometry;
use crate::scene::validate::ResolvedObstacle;

/// `mesh` with the arcs that `obstacles` ask for; none where they ask for none.
pub(super) fn fitted(mesh: &Mesh, obstacles: &[ResolvedObstacle]) -> Option<Mesh> {
    let asking = |one: &&ResolvedObstacle| one.surface == SurfaceGeometry::Smooth;
    let asked = obstacles.iter().filter(asking);
    let arcs = asked.flat_map(|obstacle| smooth_offsets(mesh, &obstacle.facets));
    let own = mesh.edge_offsets().iter().copied();
    let mut all: BTreeMap<[u32; 2], [f64; 3]> = own.map(|one| (one.ends, one.offset)).collect();
    let before = all.clone();
    all.extend(arcs.map(|one| (one.ends, one.offset)));
    let offset = |(ends, offset)| EdgeOffset { ends, offset };
    (all != before).then(|| mesh.with_offsets(all.into_iter().map(offset).collect()))
}

impl Plan {
    /// `mesh`, which the plan was made for, with the surface of the body.
    pub(crate) fn body_mesh(&self, mesh: &Arc<Mesh>) -> Arc<Mesh> {
        if self.problem.fitted.is_empty() {
            mesh.clone()
        } else {
            Arc::new(mesh.with_offsets(self.problem.fitted.clone()))
        }
    }
}
