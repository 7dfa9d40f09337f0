//! Decisions: what a scene needs, by which method, at what predicted cost, and
//! what is left out. Cheap to make, printable, made before any expensive work.
//!
//! A plan holds the scene, its names resolved into items with facets and built shapes, the
//! units, and every choice with its reason; whatever reads names or positions of lists of
//! the scene does so here, once. Nothing later validates. Cost: one pass over cells, facets
//! and groups.

pub(crate) mod augmentation;
mod compared;
pub(crate) mod contact;
pub(crate) mod displacement;
mod doubts;
pub(crate) mod element;
pub(crate) mod estimate;
mod factor;
mod friction;
pub(crate) mod held;
pub(crate) mod held_nodes;
mod key;
mod near;
mod overlap;
pub(crate) mod p1;
mod poses;
mod reach;
mod report;
pub(crate) mod response;
pub(crate) mod rubber;
pub(crate) mod saddle;
mod settings;
mod stability;
pub(crate) mod surfaces;
mod tools;
mod true_surface;
mod units;

use std::sync::Arc;

use crate::comparisons::Comparisons;
use crate::linalg::cholesky::Precision;
use crate::mesh::{EdgeOffset, Mesh, MeshId};
use crate::report::Unknowns;
use crate::scene::validate::{Resolved, ResolvedObstacle, build, resolve};
use crate::scene::{
    ContactSpace, DisplacementMethod, MetricKind, ReportScope, Scene, SceneError, Step, Violation,
};
use crate::space::TaylorHood;

use contact::ContactSizes;
use held::{conflicts, held_unknowns};
use p1::P1Sizes;
pub use report::{LeftOut, PlanEntry, PlanReport};
use response::ResponseChoice;
use saddle::{Demand, SaddleChoice, SaddleNeeds};
use settings::Settings;
use stability::StabilityChoice;
use surfaces::{ContactLayout, Surfaces};
pub use units::Units;

/// Names everything that [`Prepared`](crate::Prepared) depends on; equal keys share it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct PreparedKey(pub [u8; 32]);

/// A validated scene with its decisions.
#[derive(Clone, Debug)]
pub struct Plan {
    /// The scene as it was given.
    pub(crate) scene: Scene,
    /// What the scene's names stand for: items with facets, values and built shapes.
    pub(crate) resolved: Resolved,
    /// Obstacles in the order of the scene, shapes non-dimensional.
    pub(crate) obstacles: Vec<ResolvedObstacle>,
    /// What the scene asks of every increment: tolerance, limits, options.
    pub(crate) settings: Settings,
    /// Reference length and stress, by which everything is made non-dimensional.
    pub(crate) units: Units,
    /// Digest of the mesh that the plan was made for.
    pub(crate) mesh_id: MeshId,
    /// Number of unknowns by kind.
    pub(crate) unknowns: Unknowns,
    /// Number of mesh vertices.
    pub(crate) vertices: usize,
    /// Number of mesh cells.
    pub(crate) cells: usize,
    /// Held unknown and the support that holds it ([`held::AXIS`] where none does),
    /// ascending by unknown.
    pub(crate) held: Vec<(u32, u16)>,
    /// Nodes that planes hold, ascending.
    pub(crate) held_nodes: Vec<held_nodes::HeldByPlanes>,
    /// Functions of the contact pressure.
    pub(crate) contact_space: ContactSpace,
    /// Functions and multipliers of each obstacle's surface.
    pub(crate) contact_layouts: Vec<ContactLayout>,
    /// Tractions of friction, behind the pressures of all obstacles.
    pub(crate) tangential_multipliers: usize,
    /// Multipliers of supports that hold their normal component, behind those of
    /// obstacles.
    pub(crate) guided_multipliers: usize,
    /// Method and metric for contact.
    pub(crate) contact: contact::ContactChoice,
    /// Mesh vertices of all candidate faces, ascending; none where the metric is
    /// not their compliance.
    pub(crate) contact_vertices: Vec<u32>,
    /// Preconditioner of the displacement block.
    pub(crate) displacement: DisplacementMethod,
    /// Degree of the Chebyshev smoother in the preconditioner.
    pub(crate) smoother_degree: usize,
    /// Mean quality of the cells, in (0, 1]; low values ask for smoothing along short
    /// edges.
    quality: f64,
    /// Solver of the P1 block.
    pub(crate) p1: p1::P1Choice,
    /// Method of the linear systems.
    pub(crate) saddle: SaddleChoice,
    /// How equilibria of rubber are certified.
    pub(crate) stability: StabilityChoice,
    /// Number of edges of the surface that have an offset.
    pub(crate) curved_edges: usize,
    /// Offsets of all edges where arcs are fitted over some of them, else empty.
    fitted: Vec<EdgeOffset>,
    /// From which step on the body is solved by its response at the contact surface.
    pub(crate) response: ResponseChoice,
    /// What may touch each obstacle, and its way, for reports of the plan.
    pub(crate) tools: Vec<PlanEntry>,
    /// Sentences about what the caller should know, for reports of the plan.
    pub(crate) warnings: Vec<String>,
    /// Methods beside the solver's own, where the caller brought them.
    pub(crate) comparisons: Option<Arc<dyn Comparisons>>,
}

impl Plan {
    /// Validates `scene` and `steps` against `mesh` and decides.
    ///
    /// # Errors
    /// [`SceneError`] with the path of every faulty key, or of the first one
    /// that this version does not support.
    pub fn new(scene: &Scene, steps: &[Step], mesh: &Mesh) -> Result<Self, SceneError> {
        Self::with_comparisons(scene, steps, mesh, None)
    }

    /// The same for scenes that may name methods of `comparisons`, too.
    ///
    /// # Errors
    /// As [`Plan::new`].
    pub fn with_comparisons(
        scene: &Scene,
        steps: &[Step],
        mesh: &Mesh,
        comparisons: Option<Arc<dyn Comparisons>>,
    ) -> Result<Self, SceneError> {
        let (resolved, obstacles) = resolve(scene, steps, mesh)?;
        compared::check(&scene.solver, comparisons.as_deref())?;
        let units = usable_units(scene, &resolved, mesh)?;
        let mut obstacles = build(obstacles, units.length)?;
        let fitted = true_surface::fitted(mesh, &obstacles);
        let mesh = fitted.as_ref().unwrap_or(mesh);
        overlap::refuse((&scene.obstacles, &obstacles), (mesh, &units))?;
        friction::roughen(&mut obstacles, steps);
        let space = TaylorHood::new(mesh);
        let natural = ContactSpace::Quadratic;
        let contact_space = scene.solver.contact_space.named().unwrap_or(natural);
        let held = held_unknowns(&resolved, mesh, &space);
        let held_nodes = held_nodes::held_nodes(&resolved, (mesh, &space), &held);
        let body = surfaces::Body {
            mesh,
            space: &space,
            held: &held,
        };
        let surfaces = Surfaces::of(body, &obstacles, &resolved, contact_space);
        let tangential =
            friction::tangential_multipliers(&obstacles, &surfaces.layouts, units.dimension);
        let unknowns = Unknowns {
            contact: (surfaces.contacts + tangential + surfaces.guided) as u64,
            ..element::unknowns(&space, &resolved)
        };
        let sizes = ContactSizes {
            dimension: units.dimension as u64,
            multipliers: unknowns.contact,
            vertices: surfaces.vertices.len() as u64,
            needs_one_level: !resolved.free_modes.is_empty()
                || surfaces.guided > 0
                || tangential > 0,
            is_rough: tangential > 0,
            known: None,
        };
        let known = match sizes.vertices_to_know() {
            None => None,
            Some(most) => {
                let patches = resolved
                    .supports
                    .iter()
                    .flat_map(|support| &support.patches);
                let guided = surfaces::vertices_of(mesh, patches);
                near::near((mesh, &units), (&obstacles, steps), &guided, most)
            }
        };
        let sizes = ContactSizes {
            known: known.as_ref().map(|vertices| vertices.len() as u64),
            ..sizes
        };
        let contact = contact::choose(&scene.solver, sizes).map_err(SceneError::Unsupported)?;
        let contact_vertices = match contact.metric {
            MetricKind::Compliance => known.unwrap_or(surfaces.vertices),
            MetricKind::Mass | MetricKind::Fractional => Vec::new(),
        };
        let sizes = P1Sizes {
            dimension: units.dimension,
            vertices: space.vertices as u64,
            is_rough: tangential > 0,
            contrast: contrast(&resolved),
            quality: mesh.quality().mean,
        };
        let p1 = p1::choose(scene.solver.p1_solver, sizes);
        let displacement = displacement::choose(scene.solver.displacement_preconditioner);
        let saddle = saddle_for(scene, unknowns, [displacement.demand(), p1.solver.demand()]);
        let tools = tools::entries(&obstacles, &surfaces.layouts, (steps, &units));
        let mut own = conflicts(&resolved, mesh);
        own.extend(doubts::doubts(
            (scene, steps),
            (&resolved, &obstacles),
            (mesh, &units),
        ));
        let of_tools = (&scene.obstacles[..], &obstacles[..]);
        own.extend(tools::doubts(of_tools, steps, (mesh, &units)));
        let mut plan = Self {
            tools,
            curved_edges: mesh.edge_offsets().len(),
            fitted: fitted.as_ref().map_or(&[][..], Mesh::edge_offsets).to_vec(),
            warnings: mesh.warnings().iter().cloned().chain(own).collect(),
            units,
            mesh_id: mesh.id(),
            unknowns,
            comparisons,
            vertices: space.vertices,
            cells: mesh.cell_count(),
            held,
            held_nodes,
            contact_space,
            contact_layouts: surfaces.layouts,
            tangential_multipliers: tangential,
            guided_multipliers: surfaces.guided,
            contact,
            contact_vertices,
            displacement,
            smoother_degree: smoother_degree(&resolved, mesh),
            quality: mesh.quality().mean,
            p1,
            saddle,
            response: ResponseChoice::default(),
            stability: stability::choose(
                (scene.solver.stability.named(), tangential > 0),
                estimate::saddle_factor(units.dimension, unknowns).1,
            ),
            settings: Settings::new(&scene.solver),
            scene: scene.clone(),
            resolved,
            obstacles,
        };
        plan.response = response::choose(&plan).map_err(|message| {
            let key = match plan.settings.report {
                ReportScope::Whole => "response",
                ReportScope::Contact => "report",
            };
            let path = format!("solver.{key}");
            SceneError::Unsupported(Violation { path, message })
        })?;
        Ok(plan)
    }

    /// Facets of the surfaces that carry multipliers, in their order: those that may
    /// touch each obstacle, then the smooth patches of supports along their normal.
    pub(crate) fn surfaces(&self) -> impl Iterator<Item = &[u32]> {
        let candidates = self.obstacles.iter().map(|obstacle| &obstacle.facets[..]);
        let supports = self.resolved.supports.iter();
        candidates
            .chain(supports.flat_map(|support| support.patches.iter().map(|patch| &patch[..])))
    }

    /// Whether multipliers of quadratic functions are there.
    pub(crate) fn has_quadratic_multipliers(&self) -> bool {
        let contacts = self.normal_multipliers();
        let is_quadratic = self.contact_space == ContactSpace::Quadratic;
        self.guided_multipliers > 0 || (is_quadratic && contacts > 0)
    }

    /// Number of contact pressures of all obstacles, which come first among the multipliers.
    pub(crate) fn normal_multipliers(&self) -> usize {
        let others = self.tangential_multipliers + self.guided_multipliers;
        self.unknowns.contact as usize - others
    }

    /// Whether there is friction on some obstacle.
    pub(crate) fn has_friction(&self) -> bool {
        self.tangential_multipliers > 0
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

    /// Weight r of the grad-div term of a linear body, in units of the shear modulus.
    pub(crate) fn penalty(&self) -> f64 {
        if self.resolved.is_rubber() {
            0.0
        } else {
            self.settings.penalty.unwrap_or(0.0)
        }
    }

    /// Whether cells are so stretched that node blocks do not smooth.
    pub(crate) fn smooths_along_lines(&self) -> bool {
        self.quality < STRETCHED
    }

    /// Whether the compliance of contact lets nodes move with the lines that they are coupled to.
    pub(crate) fn has_compliance_along_lines(&self) -> bool {
        self.unknowns.contact > 0 && self.quality < UNEVEN
    }

    /// Whether supports leave rigid modes that only contact can hold.
    pub(crate) fn is_floating(&self) -> bool {
        !self.resolved.free_modes.is_empty()
    }
}

/// The units of a scene.
///
/// # Errors
/// [`SceneError::Invalid`] where they leave the range of numbers.
fn usable_units(scene: &Scene, resolved: &Resolved, mesh: &Mesh) -> Result<Units, SceneError> {
    let units = Units::new(scene, resolved, mesh);
    if units.are_usable() {
        return Ok(units);
    }
    Err(SceneError::Invalid(vec![Violation {
        path: "mesh_scale".to_owned(),
        message: format!(
            "a body of length {:e} with a {} of {:e} leaves the range of numbers",
            units.length,
            resolved.modulus_name(),
            units.stress
        ),
    }]))
}

/// The method of the linear systems, from what both preconditioners ask of it.
fn saddle_for(scene: &Scene, unknowns: Unknowns, demands: [Demand; 2]) -> SaddleChoice {
    let needs = SaddleNeeds {
        has_multipliers: unknowns.pressure + unknowns.contact > 0,
        demand: if demands.contains(&Demand::Flexible) {
            Demand::Flexible
        } else {
            Demand::None
        },
    };
    saddle::choose(scene.solver.saddle, needs)
}

/// Mean quality of cells below which smoothing follows the short edges: cells
/// stretched 6 times and more. With node blocks of degree 8 flat cells of aspect
/// 100 did not converge in 600 iterations.
const STRETCHED: f64 = 0.4;
/// The same below which the compliance of contact follows them: cells stretched twice and more. By
/// nodes alone a layer of cells 2.5 : 2.5 : 1 takes 650 applications, along lines 14 to 31.
const UNEVEN: f64 = 0.7;
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

impl Plan {
    /// Largest over smallest shear modulus of the body.
    pub(crate) fn contrast(&self) -> f64 {
        contrast(&self.resolved)
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
