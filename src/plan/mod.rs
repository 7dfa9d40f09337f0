//! Decisions: what a scene needs, by which method, at what predicted cost, and
//! what is left out. Cheap to make, printable, made before any expensive work.

mod approximation;
mod comparison;
mod contact;
mod data;
mod displacement;
mod element;
mod estimate;
mod held;
mod p1;
mod prepared;
mod report;
mod rings;
mod rubber;
mod saddle;
mod units;

use sha2::{Digest, Sha256};

use crate::inequality::MetricKind;
use crate::linalg::cholesky::Precision;
use crate::mesh::{Mesh, MeshId};
use crate::report::Unknowns;
use crate::scene::validate::{Resolved, resolve};
use crate::scene::{Scene, SceneError, SceneKind, Step, Violation};
use crate::space::TaylorHood;

pub(crate) use approximation::{Approximation, Deformed};
pub(crate) use comparison::ComparisonData;
use contact::ContactSizes;
pub use data::Prepared;
pub(crate) use data::PreparedBody;
use displacement::DisplacementMethod;
use element::Element;
use held::{conflicts, held_unknowns};
use p1::P1Sizes;
pub use prepared::PrepareError;
pub(crate) use prepared::Prepared as TaylorHoodData;
pub use report::{LeftOut, PlanEntry, PlanReport};
pub(crate) use saddle::SaddleMethod;
use saddle::{Demand, SaddleChoice, SaddleNeeds};
pub use units::Units;

/// Names everything that [`Prepared`] depends on; equal keys share it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct PreparedKey(pub [u8; 32]);

/// A validated scene with its decisions.
#[derive(Clone, Debug)]
pub struct Plan {
    pub(crate) scene: Scene,
    pub(crate) resolved: Resolved,
    pub(crate) units: Units,
    pub(crate) mesh_id: MeshId,
    pub(crate) unknowns: Unknowns,
    pub(crate) element: Element,
    pub(crate) vertices: usize,
    pub(crate) cells: usize,
    /// Held unknown and the support that holds it ([`held::AXIS`] where none does),
    /// ascending by unknown.
    pub(crate) held: Vec<(u32, u16)>,
    pub(crate) contact: contact::ContactChoice,
    /// Mesh vertices of all candidate faces, ascending; none where the metric is
    /// not their compliance.
    pub(crate) contact_vertices: Vec<u32>,
    pub(crate) displacement: DisplacementMethod,
    pub(crate) smoother_degree: usize,
    /// Mean quality of the cells.
    quality: f64,
    pub(crate) p1: p1::P1Choice,
    pub(crate) saddle: SaddleChoice,
    pub(crate) warnings: Vec<String>,
}

impl Plan {
    /// Validates `scene` and `steps` against `mesh` and decides.
    ///
    /// # Errors
    /// [`SceneError`] with the path of every faulty key, or of the first one
    /// that this version does not support.
    pub fn new(scene: &Scene, steps: &[Step], mesh: &Mesh) -> Result<Self, SceneError> {
        let resolved = resolve(scene, steps, mesh)?;
        let units = Units::new(scene, &resolved, mesh);
        if !units.are_usable() {
            return Err(SceneError::Invalid(vec![Violation {
                path: "mesh_scale".to_owned(),
                message: format!(
                    "a body of length {:e} with a {} of {:e} leaves the range of numbers",
                    units.length,
                    resolved.modulus_name(),
                    units.stress
                ),
            }]));
        }
        let space = TaylorHood::new(mesh);
        let mut contact_vertices = vertices_of(mesh, resolved.obstacle_facets.iter());
        let multipliers: usize = resolved
            .obstacle_facets
            .iter()
            .map(|facets| vertices_of(mesh, std::iter::once(facets)).len())
            .sum();
        let element = Element::from_name(&scene.solver.element);
        let unknowns = Unknowns {
            contact: multipliers as u64,
            ..element.unknowns(mesh, &resolved)
        };
        let sizes = ContactSizes {
            dimension: units.dimension as u64,
            multipliers: unknowns.contact,
            vertices: contact_vertices.len() as u64,
            factor_flops: estimate::factor(units.dimension, space.vertices as u64).1,
            needs_one_level: !resolved.free_modes.is_empty()
                || !matches!(element, Element::TaylorHood),
        };
        let contact = contact::choose(&scene.solver, sizes).map_err(SceneError::Unsupported)?;
        if contact.metric != MetricKind::Compliance {
            contact_vertices.clear();
        }
        let held = held_unknowns(scene, &resolved, mesh, &space);
        let smoother_degree = smoother_degree(&resolved, mesh);
        let sizes = P1Sizes {
            dimension: units.dimension,
            vertices: space.vertices as u64,
            contact_vertices: contact_vertices.len(),
            contrast: contrast(&resolved),
            quality: mesh.quality().mean,
        };
        let p1 = p1::choose(&scene.solver.p1_solver, sizes);
        let displacement = DisplacementMethod::choose(&scene.solver.displacement_preconditioner);
        let demands = [displacement.demand(), p1.solver.demand()];
        let needs = SaddleNeeds {
            has_multipliers: unknowns.pressure + unknowns.contact > 0,
            demand: match demands.contains(&Demand::Flexible) {
                true => Demand::Flexible,
                false => Demand::None,
            },
        };
        let saddle = saddle::choose(&scene.solver.saddle, needs);
        let mut warnings = mesh.warnings().to_vec();
        warnings.extend(conflicts(scene, &resolved, mesh));
        Ok(Self {
            units,
            mesh_id: mesh.id(),
            unknowns,
            element,
            vertices: space.vertices,
            cells: mesh.cell_count(),
            held,
            contact,
            contact_vertices,
            displacement,
            smoother_degree,
            quality: mesh.quality().mean,
            p1,
            saddle,
            warnings,
            scene: scene.clone(),
            resolved,
        })
    }

    /// Unknowns by kind.
    pub fn unknowns(&self) -> Unknowns {
        self.unknowns
    }

    /// Whether a pressure unknown carries the volume constraint.
    pub fn is_mixed(&self) -> bool {
        self.resolved.mixed
    }

    /// The scene this plan is for.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The mesh this plan is for.
    pub fn mesh_id(&self) -> MeshId {
        self.mesh_id
    }

    /// Key of the prepared data: mesh, held unknowns, non-dimensional
    /// materials, kind, formulation, candidate surface. Loads, obstacles, prescribed
    /// values and units are not part of it.
    pub fn key(&self) -> PreparedKey {
        let mut hash = Sha256::new();
        hash.update(self.mesh_id.as_bytes());
        hash.update([self.element.number()]);
        hash.update([u8::from(self.resolved.mixed), self.smoother_degree as u8]);
        hash.update([u8::from(self.is_floating()), self.p1.solver as u8]);
        hash.update([self.displacement as u8]);
        hash.update(self.penalty().to_le_bytes());
        for (unknown, _) in &self.held {
            hash.update(unknown.to_le_bytes());
        }
        hash.update(u64::MAX.to_le_bytes());
        if self.resolved.kind == SceneKind::Axisymmetric {
            hash.update(b"axisymmetric");
        }
        for material in &self.resolved.materials {
            let shear = material.law.shear_modulus / self.units.stress;
            let inverse = material.law.inverse_lame * self.units.stress;
            hash.update(shear.to_le_bytes());
            hash.update(inverse.to_le_bytes());
            if let Some(rubber) = &material.rubber {
                rubber::hash(rubber, self.units.stress, &mut hash);
                hash.update(self.strain_degree().to_le_bytes());
            }
        }
        for material in &self.resolved.cell_material {
            hash.update(material.to_le_bytes());
        }
        for vertex in &self.contact_vertices {
            hash.update(vertex.to_le_bytes());
        }
        PreparedKey(hash.finalize().into())
    }

    /// Weight r of the grad-div term of a linear body, in units of the shear modulus.
    pub(crate) fn penalty(&self) -> f64 {
        match self.resolved.is_rubber() {
            true => 0.0,
            false => self.scene.solver.penalty.unwrap_or(0.0),
        }
    }

    pub(crate) fn has_body_force(&self) -> bool {
        self.scene.body_force.iter().any(|&force| force != 0.0)
    }

    /// Whether cells are so stretched that node blocks do not smooth.
    pub(crate) fn smooths_along_lines(&self) -> bool {
        self.quality < STRETCHED
    }

    /// Whether supports leave rigid modes that only contact can hold.
    pub(crate) fn is_floating(&self) -> bool {
        !self.resolved.free_modes.is_empty()
    }
}

fn vertices_of<'a>(mesh: &Mesh, facets: impl Iterator<Item = &'a Vec<u32>>) -> Vec<u32> {
    let mut vertices: Vec<u32> = facets
        .flatten()
        .flat_map(|&facet| mesh.facet(facet as usize).iter().copied())
        .collect();
    vertices.sort_unstable();
    vertices.dedup();
    vertices
}

/// Mean quality of cells below which smoothing follows the short edges: cells
/// stretched 6 times and more. With node blocks of degree 8 flat cells of aspect
/// 100 did not converge in 600 iterations.
const STRETCHED: f64 = 0.4;
/// Ratio of shear moduli above which a factor in single precision may fail.
const MOST_CONTRAST: f64 = 1e3;

impl Plan {
    /// Number type of a P1 factor and why: single precision costs half the time
    /// and memory where the block is well conditioned.
    pub(crate) fn factor_precision(&self) -> (Precision, &'static str) {
        if self.is_floating() {
            (Precision::Double, "rigid modes are nearly free")
        } else if contrast(&self.resolved) > MOST_CONTRAST {
            (Precision::Double, "strong contrast of stiffness")
        } else if self.smoother_degree > 2 {
            (
                Precision::Double,
                "stretched cells or a stiff volume response",
            )
        } else {
            (Precision::Single, "well conditioned")
        }
    }
}

/// Largest over smallest shear modulus.
fn contrast(resolved: &Resolved) -> f64 {
    let shear = resolved.materials.iter().map(|m| m.law.shear_modulus);
    shear.clone().fold(0.0, f64::max) / shear.fold(f64::INFINITY, f64::min)
}

/// Chebyshev steps of the smoother: more where the P1 correction is weak, that
/// is for displacement forms near the volume constraint and for poor cells.
fn smoother_degree(resolved: &Resolved, mesh: &Mesh) -> usize {
    let stiffest = resolved
        .materials
        .iter()
        .map(|material| material.law.lame() / material.law.shear_modulus)
        .fold(0.0, f64::max);
    let softest = resolved
        .materials
        .iter()
        .map(|material| material.law.lame() / material.law.shear_modulus)
        .fold(0.0, f64::min);
    let by_volume = match resolved.mixed {
        // Auxetic: the volume response nearly cancels the shear response.
        false if softest < -0.55 => 6,
        false if stiffest > 4.0 => 4,
        false if stiffest > 2.0 => 3,
        _ => 2,
    };
    let by_shape = match mesh.quality().mean {
        mean if mean < 0.28 => 8,
        mean if mean < 0.4 => 6,
        mean if mean < 0.58 => 4,
        _ => 2,
    };
    by_volume.max(by_shape)
}

#[cfg(test)]
mod tests;
