//! Decisions: what a scene needs, by which method, at what predicted cost, and
//! what is left out. Cheap to make, printable, made before any expensive work.
//!
//! A plan holds the scene, its names resolved into items with facets and built shapes, the
//! units, and every choice with its reason; whatever reads names or positions of lists of
//! the scene does so here, once. Nothing later validates. Cost: one pass over cells, facets
//! and groups.

pub(crate) mod augmentation;
mod behind;
mod compared;
pub(crate) mod contact;
mod decisions;
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
pub(crate) mod pairs;
mod poses;
pub(crate) mod problem;
mod reach;
mod report;
pub(crate) mod response;
pub(crate) mod rubber;
pub(crate) mod saddle;
mod settings;
mod stability;
pub(crate) mod surfaces;
pub(crate) mod ties;
mod tools;
mod true_surface;
mod units;

use std::sync::Arc;

use crate::comparisons::Comparisons;
use crate::linalg::cholesky::Precision;
use crate::mesh::{Mesh, MeshId};
use crate::report::Unknowns;
use crate::scene::{ReportScope, Scene, SceneError, Step, Violation};

use decisions::Decisions;
use held::conflicts;
use problem::{Problem, Stated};
pub use report::{LaterBytes, LeftOut, PlanEntry, PlanReport};
use response::ResponseChoice;
use units::ScaledMesh;
pub use units::Units;

/// Mean quality of cells below which smoothing follows the short edges: cells
/// stretched 6 times and more. With node blocks of degree 8 flat cells of aspect
/// 100 did not converge in 600 iterations.
const STRETCHED: f64 = 0.4;
/// The same below which the compliance of contact follows them: cells stretched twice and more. By
/// nodes alone a layer of cells 2.5 : 2.5 : 1 takes 650 applications, along lines 14 to 31.
const UNEVEN: f64 = 0.7;
/// Ratio of shear moduli above which a factor in single precision may fail.
const MOST_CONTRAST: f64 = 1e3;

/// Names everything that [`Prepared`](crate::Prepared) depends on; equal keys share it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct PreparedKey(pub [u8; 32]);

/// A validated scene with its decisions.
#[derive(Clone, Debug)]
pub struct Plan {
    /// The scene, resolved.
    pub(crate) problem: Problem,
    /// What it is solved by.
    pub(crate) decisions: Decisions,
    /// What reports of the plan say beside the decisions.
    notes: Notes,
    /// Methods beside the solver's own, where the caller brought them.
    pub(crate) comparisons: Option<Arc<dyn Comparisons>>,
}

/// What reports of a plan say beside its decisions.
#[derive(Clone, Debug)]
struct Notes {
    /// What may touch each obstacle, and its path.
    tools: Vec<PlanEntry>,
    /// Sentences about what the caller should know.
    warnings: Vec<String>,
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
        let Stated {
            problem,
            fitted,
            surface_vertices,
        } = problem::state(scene, steps, mesh, comparisons.as_deref())?;
        let mesh = fitted.as_ref().unwrap_or(mesh);
        let decisions = Decisions::new(&problem, surface_vertices, steps, mesh)?;
        let mut plan = Self {
            notes: Notes::new(&problem, steps, mesh),
            problem,
            decisions,
            comparisons,
        };
        plan.decisions.response = plan.choose_response()?;
        Ok(plan)
    }

    fn choose_response(&self) -> Result<ResponseChoice, SceneError> {
        response::choose(self).map_err(|message| {
            let key = match self.problem.settings.report {
                ReportScope::Whole => "response",
                ReportScope::Contact => "report",
            };
            let path = format!("solver.{key}");
            SceneError::Unsupported(Violation { path, message })
        })
    }

    /// Facets of the surfaces that carry multipliers, in their order.
    pub(crate) fn surfaces(&self) -> impl Iterator<Item = &[u32]> {
        self.problem.surfaces()
    }

    /// Whether multipliers of quadratic functions are there.
    pub(crate) fn has_quadratic_multipliers(&self) -> bool {
        self.problem.has_quadratic_multipliers()
    }

    /// Number of contact pressures of all obstacles, which come first among the multipliers.
    pub(crate) fn normal_multipliers(&self) -> usize {
        self.problem.normal_multipliers()
    }

    /// Whether there is friction on some obstacle.
    pub(crate) fn has_friction(&self) -> bool {
        self.problem.has_friction()
    }

    /// Unknowns by kind.
    pub fn unknowns(&self) -> Unknowns {
        self.problem.unknowns
    }

    /// Whether a pressure unknown carries the volume constraint.
    pub fn is_mixed(&self) -> bool {
        self.problem.resolved.mixed
    }

    /// The scene this plan is for.
    pub fn scene(&self) -> &Scene {
        &self.problem.scene
    }

    /// The mesh this plan is for.
    pub fn mesh_id(&self) -> MeshId {
        self.problem.mesh_id
    }

    /// Weight r of the grad-div term of a linear body, in units of the shear modulus.
    pub(crate) fn penalty(&self) -> f64 {
        if self.problem.resolved.is_rubber() {
            0.0
        } else {
            self.problem.settings.penalty.unwrap_or(0.0)
        }
    }

    /// Whether cells are so stretched that node blocks do not smooth.
    pub(crate) fn smooths_along_lines(&self) -> bool {
        self.problem.quality < STRETCHED
    }

    /// Whether the compliance of contact lets nodes move with the lines that they are coupled to.
    pub(crate) fn has_compliance_along_lines(&self) -> bool {
        self.problem.unknowns.contact > 0 && self.problem.quality < UNEVEN
    }

    /// Whether supports leave rigid modes that only contact can hold.
    pub(crate) fn is_floating(&self) -> bool {
        self.problem.is_floating()
    }

    /// Whether the P1 block is shifted: rigid modes are left that only contact, or a tie, holds.
    pub(crate) fn is_shifted(&self) -> bool {
        self.problem.is_floating() || !self.problem.resolved.free_alone.is_empty()
    }

    /// Number type of a P1 factor and why: single precision costs half the time
    /// and memory where the block is well conditioned.
    pub(crate) fn factor_precision(&self) -> (Precision, &'static str) {
        if self.is_shifted() {
            (Precision::Double, "rigid modes are nearly free")
        } else if self.problem.contrast() > MOST_CONTRAST {
            (Precision::Double, "strong contrast of stiffness")
        } else if self.decisions.smoother_degree > 2 {
            (
                Precision::Double,
                "stretched cells or a stiff volume response",
            )
        } else {
            (Precision::Single, "well conditioned")
        }
    }
}

impl Notes {
    fn new(problem: &Problem, steps: &[Step], mesh: &Mesh) -> Self {
        let body = ScaledMesh {
            mesh,
            units: &problem.units,
        };
        let obstacles = &problem.obstacles;
        let own = conflicts(&problem.resolved, mesh);
        let doubts = doubts::doubts(problem, steps, mesh);
        let given = &problem.scene.obstacles[..];
        let of_tools = tools::doubts((given, &obstacles[..]), steps, body);
        let warnings = mesh.warnings().iter().cloned().chain(own);
        let mut tools =
            tools::entries(obstacles, &problem.contact_layouts, (steps, &problem.units));
        let layouts = problem.pair_layouts.iter();
        let multipliers = layouts.map(|layout| layout.multipliers.len());
        let contacts = &problem.scene.contacts;
        tools.extend(pairs::entries(&problem.pairs, contacts, multipliers));
        tools.extend(ties::entries(&problem.ties, &problem.scene.ties));
        Self {
            tools,
            warnings: warnings
                .chain(doubts)
                .chain(of_tools)
                .chain(ties::doubts(&problem.ties, &problem.scene.ties))
                .collect(),
        }
    }
}

#[cfg(test)]
mod tests;
