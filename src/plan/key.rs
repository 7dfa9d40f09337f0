//! The key of the prepared data: a digest of mesh, held unknowns, non-dimensional materials, kind,
//! formulation and candidate surface. Loads, obstacles, prescribed values and units are no part
//! of it. Cost: one pass over held unknowns, cells and contact faces.

use sha2::{Digest, Sha256};

use super::ties::PlannedTie;
use super::{Plan, PreparedKey};
use crate::scene::{Named, SceneKind};

impl Plan {
    /// Key of the prepared data.
    pub fn key(&self) -> PreparedKey {
        let mut hash = Sha256::new();
        hash.update(self.problem.mesh_id.as_bytes());
        // Where other elements once had their numbers.
        hash.update([0]);
        hash.update([
            u8::from(self.problem.resolved.mixed),
            self.decisions.smoother_degree as u8,
        ]);
        hash.update([u8::from(self.is_shifted()), self.decisions.p1.solver as u8]);
        hash.update([self.decisions.displacement as u8]);
        hash.update(self.penalty().to_le_bytes());
        hash.update(self.key_of_inverse());
        self.hash_held(&mut hash);
        hash.update(u64::MAX.to_le_bytes());
        if self.problem.resolved.kind == SceneKind::Axisymmetric {
            hash.update(b"axisymmetric");
        }
        self.hash_materials(&mut hash);
        self.hash_surfaces(&mut hash);
        PreparedKey(hash.finalize().into())
    }

    /// What supports hold.
    fn hash_held(&self, hash: &mut Sha256) {
        for (unknown, _) in &self.problem.held {
            hash.update(unknown.to_le_bytes());
        }
        for one in &self.problem.held_nodes {
            hash.update(one.held.node.to_le_bytes());
            let directions = one.held.directions().as_flattened();
            directions.iter().for_each(|x| hash.update(x.to_le_bytes()));
        }
    }

    /// The laws, and which of them each cell has.
    fn hash_materials(&self, hash: &mut Sha256) {
        let stress = self.problem.units.stress;
        for material in &self.problem.resolved.materials {
            hash.update((material.law.shear_modulus / stress).to_le_bytes());
            hash.update((material.law.inverse_lame * stress).to_le_bytes());
            if material.law.direct_lame != 0.0 {
                hash.update((material.law.direct_lame / stress).to_le_bytes());
            }
            if let Some(rubber) = &material.rubber {
                rubber.over(stress).isochoric.hash_into(hash);
                hash.update(self.strain_degree().to_le_bytes());
            }
        }
        for material in &self.problem.resolved.cell_material {
            hash.update(material.to_le_bytes());
        }
    }

    /// Contact vertices, functions of the contact pressure, fitted edges, facets with friction and
    /// those that supports guide.
    fn hash_surfaces(&self, hash: &mut Sha256) {
        for vertex in &self.decisions.contact_vertices {
            hash.update(vertex.to_le_bytes());
        }
        if self.has_quadratic_multipliers() {
            hash.update(self.problem.contact_space.name());
        }
        for one in &self.problem.fitted {
            hash.update(b"arc");
            let ends = one.ends.iter();
            ends.for_each(|end| hash.update(end.to_le_bytes()));
            one.offset.iter().for_each(|x| hash.update(x.to_le_bytes()));
        }
        for obstacle in self
            .problem
            .obstacles
            .iter()
            .filter(|obstacle| obstacle.is_frictional)
        {
            hash.update(b"rough");
            let facets = obstacle.facets.iter();
            facets.for_each(|facet| hash.update(facet.to_le_bytes()));
        }
        let rough = self.problem.pairs.iter();
        for pair in rough.filter(|pair| pair.is_frictional()) {
            hash.update(b"rough pair");
            let facets = pair.carrier.iter().chain(&pair.other);
            facets.for_each(|facet| hash.update(facet.to_le_bytes()));
        }
        let pairs = self.problem.pairs.iter();
        for side in pairs.flat_map(|pair| [&pair.carrier, &pair.other]) {
            hash.update(b"pair");
            side.iter()
                .for_each(|facet| hash.update(facet.to_le_bytes()));
        }
        for side in self.problem.ties.iter().flat_map(PlannedTie::sides) {
            hash.update(b"tied");
            side.iter()
                .for_each(|facet| hash.update(facet.to_le_bytes()));
        }
        let supports = self.problem.resolved.supports.iter();
        for patch in supports.flat_map(|support| &support.patches) {
            hash.update(b"guided");
            let facets = patch.iter();
            facets.for_each(|facet| hash.update(facet.to_le_bytes()));
        }
    }
}
