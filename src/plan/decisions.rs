//! The decisions about a problem: which method serves each part of it, and why.

use super::contact::{self, ContactChoice, ContactSizes};
use super::p1::{self, P1Choice, P1Sizes};
use super::problem::Problem;
use super::response::ResponseChoice;
use super::saddle::{self, Demand, SaddleChoice, SaddleNeeds};
use super::stability::{self, StabilityChoice};
use super::ties::PlannedTie;
use super::units::ScaledMesh;
use super::{displacement, estimate, near, surfaces};
use crate::mesh::Mesh;
use crate::scene::validate::Resolved;
use crate::scene::{DisplacementMethod, MetricKind, SceneError, Step};

/// What a scene is solved by.
#[derive(Clone, Debug)]
pub(crate) struct Decisions {
    /// Method and metric for contact.
    pub(crate) contact: ContactChoice,
    /// Mesh vertices of all candidate faces, ascending; none where the metric is
    /// not their compliance.
    pub(crate) contact_vertices: Vec<u32>,
    /// Preconditioner of the displacement block.
    pub(crate) displacement: DisplacementMethod,
    /// Degree of the Chebyshev smoother in the preconditioner.
    pub(crate) smoother_degree: usize,
    /// Solver of the P1 block.
    pub(crate) p1: P1Choice,
    /// Method of the linear systems.
    pub(crate) saddle: SaddleChoice,
    /// How equilibria of rubber are certified.
    pub(crate) stability: StabilityChoice,
    /// From which step on the body is solved by its response at the contact surface.
    pub(crate) response: ResponseChoice,
}

impl Decisions {
    /// Those about `problem` with `steps` on `mesh`, of whose vertices `surface_vertices` may
    /// touch something; the response, which rests on all others, is not yet among them.
    ///
    /// # Errors
    /// [`SceneError::Unsupported`] where a method that the scene names does not serve it.
    pub(super) fn new(
        problem: &Problem,
        surface_vertices: Vec<u32>,
        steps: &[Step],
        mesh: &Mesh,
    ) -> Result<Self, SceneError> {
        let options = &problem.scene.solver;
        let mut sizes = contact_sizes(problem, surface_vertices.len());
        let known = known_vertices(problem, sizes, steps, mesh);
        sizes.known = known.as_ref().map(|vertices| vertices.len() as u64);
        let contact = contact::choose(options, sizes).map_err(SceneError::Unsupported)?;
        let contact_vertices = match contact.metric {
            MetricKind::Compliance => known.unwrap_or(surface_vertices),
            MetricKind::Mass | MetricKind::Fractional => Vec::new(),
        };
        let p1 = p1::choose(options.p1_solver, p1_sizes(problem));
        let displacement = displacement::choose(options.displacement_preconditioner);
        let saddle = saddle_for(problem, [displacement.demand(), p1.solver.demand()]);
        let (dimension, unknowns) = (problem.units.dimension, problem.unknowns);
        Ok(Self {
            contact,
            contact_vertices,
            displacement,
            smoother_degree: smoother_degree(&problem.resolved, mesh),
            p1,
            saddle,
            stability: stability::choose(
                (options.stability.named(), problem.has_friction()),
                estimate::saddle_factor(dimension, unknowns).1,
            ),
            response: ResponseChoice::default(),
        })
    }
}

fn contact_sizes(problem: &Problem, vertices: usize) -> ContactSizes {
    let is_frictional = problem.has_friction();
    ContactSizes {
        dimension: problem.units.dimension as u64,
        multipliers: problem.unknowns.contact,
        vertices: vertices as u64,
        has_guides: problem.guided_multipliers > 0,
        needs_one_level: problem.is_floating() || problem.guided_multipliers > 0 || is_frictional,
        is_frictional,
        known: None,
    }
}

/// The vertices whose compliance is known, where it is not that of all.
fn known_vertices(
    problem: &Problem,
    sizes: ContactSizes,
    steps: &[Step],
    mesh: &Mesh,
) -> Option<Vec<u32>> {
    let most = sizes.vertices_to_know()?;
    let pairs = problem.pairs.iter();
    let pairs = pairs.flat_map(|pair| [&pair.carrier, &pair.other]);
    let ties = problem.ties.iter().flat_map(PlannedTie::sides);
    let guided = surfaces::vertices_of(mesh, problem.patches().chain(pairs).chain(ties));
    let body = ScaledMesh {
        mesh,
        units: &problem.units,
    };
    near::near(body, &problem.obstacles, steps, &guided, most)
}

fn p1_sizes(problem: &Problem) -> P1Sizes {
    P1Sizes {
        dimension: problem.units.dimension,
        vertices: problem.vertices as u64,
        is_frictional: problem.has_friction(),
        contrast: problem.contrast(),
        quality: problem.quality,
    }
}

/// The method of the linear systems, from what both preconditioners ask of it.
fn saddle_for(problem: &Problem, demands: [Demand; 2]) -> SaddleChoice {
    let unknowns = problem.unknowns;
    let needs = SaddleNeeds {
        has_multipliers: unknowns.pressure + unknowns.contact > 0,
        demand: if demands.contains(&Demand::Flexible) {
            Demand::Flexible
        } else {
            Demand::None
        },
    };
    saddle::choose(problem.scene.solver.saddle, needs)
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
