//! A session that goes on upon the refined mesh of another one, at its state.

use std::sync::Arc;

use thiserror::Error;

use super::{Reuse, Session};
use crate::mesh::Mesh;
use crate::model::given::Given;
use crate::plan::Plan;
use crate::plan::problem::Problem;
use crate::prepare::Prepared;
use crate::refinement::Lineage;
use crate::refinement::carried::carried;

/// Why a state does not go over to a refined mesh.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum NotCarried {
    /// The lineage belongs to other meshes, or the plan to another scene.
    #[error(
        "{0} is another one: a state goes over to a refinement of its own mesh, in its own scene"
    )]
    Foreign(&'static str),
    /// Values by nodes, which the refined mesh has more of.
    #[error("values at nodes cannot be refined: give them anew for the nodes of the refined mesh")]
    ValuesAtNodes,
    /// Contact or ties between bodies, whose carriers may change with the mesh.
    #[error(
        "a state with contact or ties between bodies is not carried to a refined mesh yet: solve on the refined mesh from the start"
    )]
    ContactPairs,
}

impl Session {
    /// A session on the refined mesh at the state of this one: displacement and pressure are the
    /// same functions, contact pressures too and not negative; what drives the body is the same. A
    /// step goes on from there, or from the steps' first one in a session of its own.
    ///
    /// `plan`, `mesh` and `prepared` are of the refined mesh, `lineage` leads to it from the mesh
    /// that this session follows. Fitted arcs (`smooth`) are fitted anew to the finer facets, so
    /// that the surface is then another one. What the body does inside is found first where the
    /// last increment was on contact alone. Cost: [`Session::new`] and some operations a node.
    ///
    /// # Errors
    /// [`NotCarried`]; this session is as before.
    pub fn refined(
        &mut self,
        plan: Arc<Plan>,
        (mesh, lineage): (Arc<Mesh>, &Lineage),
        (prepared, reuse): (Arc<Prepared>, Reuse),
    ) -> Result<Self, NotCarried> {
        self.check_lineage(&plan, &mesh, lineage)?;
        self.complete();
        let mut next = Self::new(plan, mesh, prepared, reuse);
        let lending = self.body.lending(&self.state);
        let from = (&self.body.model_with(&lending), &self.state);
        next.state = carried(from, &next.body.model(), lineage);
        next.target.clone_from(&self.target);
        next.begun.clone_from(&self.begun);
        next.steps = self.steps;
        next.moved = self.moved;
        Ok(next)
    }

    /// Whether a lineage leads from the mesh of this session to `mesh`, and the scene is the same.
    fn check_lineage(&self, plan: &Plan, mesh: &Mesh, lineage: &Lineage) -> Result<(), NotCarried> {
        let sizes = |mesh: &Mesh| [mesh.coordinates().len(), mesh.edges().len()];
        if lineage.sizes() != [sizes(self.body.mesh()), sizes(mesh)] {
            return Err(NotCarried::Foreign("the mesh"));
        }
        let [own, other] = [self.plan(), plan].map(|plan| &plan.problem);
        let names = own.obstacles.iter().map(|one| &one.name);
        let supports = own.resolved.supports.iter().map(|one| &one.name);
        let is_same = names.eq(other.obstacles.iter().map(|one| &one.name))
            && supports.eq(other.resolved.supports.iter().map(|one| &one.name))
            && own.resolved.fluids.len() == other.resolved.fluids.len();
        if !is_same {
            return Err(NotCarried::Foreign("the scene"));
        }
        let has_several = |problem: &Problem| !problem.pairs.is_empty() || !problem.ties.is_empty();
        if has_several(own) || has_several(other) {
            return Err(NotCarried::ContactPairs);
        }
        if self.state.drive.given != Given::default() || self.target.given != Given::default() {
            return Err(NotCarried::ValuesAtNodes);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
