//! The words in which every room reports: iteration records, step reports,
//! terminations with typed causes, the observer and the cancel token.
//!
//! Plain data in the caller's units; residuals are non-dimensional. Nothing
//! here computes, so every module may depend on it.

mod attempt;
mod ending;
mod field;
mod fluid;
mod goal;
mod warning;

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicU8, Ordering};

pub use attempt::{Attempt, Strategy};
pub use ending::{Cause, CauseSite, Snapped, Stability, Termination};
pub use field::{FieldData, FieldName};
pub use fluid::{FluidResult, LeakPathResult, Tightness};
pub use goal::{GoalBound, GoalReport};
pub use warning::{Warning, WarningKind};

/// The four convergence criteria, each relative to its load or first
/// residual. A block the scene does not have reports zero.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Residuals {
    /// Norm of the force residual over that of the load: balance of the displacement
    /// equations.
    pub equilibrium: f64,
    /// Norm of the volume constraint's residual, over the largest seen.
    pub incompressibility: f64,
    /// Norm of what is left of contact pressure times gap.
    pub complementarity: f64,
    /// Weighted gap: negative anywhere, or non-zero under contact pressure.
    pub gap: f64,
}

impl Residuals {
    /// The largest of the four; not a number if one of them is not.
    pub fn largest(&self) -> f64 {
        let all = [
            self.equilibrium,
            self.incompressibility,
            self.complementarity,
            self.gap,
        ];
        if all.iter().any(|value| value.is_nan()) {
            f64::NAN
        } else {
            all.into_iter().fold(0.0, f64::max)
        }
    }
}

/// One line per Krylov iteration.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct IterationRecord {
    /// Number of the step, from 1.
    pub step: u32,
    /// Number of the increment within the step, from 1.
    pub increment: u32,
    /// Number of cut-backs so far in this increment.
    pub attempt: u32,
    /// Load factor of the increment being solved; 1 is the full load of the scene.
    pub load: f64,
    /// Number of the SQP iteration, from 1.
    pub sqp_iteration: u32,
    /// Number of Krylov iterations so far in this increment.
    pub krylov_iterations: u32,
    /// Applications of the displacement preconditioner so far.
    pub preconditioner_applications: u32,
    /// Residuals of the current iterate; complementarity is measured between
    /// quadratic programs only and zero here.
    pub residuals: Residuals,
    /// Number of vertices in contact on the present face.
    pub active_vertices: u32,
    /// Number of revisions of the active set so far.
    pub active_set_changes: u32,
    /// Accepted step length of the line search, in (0, 1]; 1 is the whole step.
    pub step_length: f64,
    /// Wall seconds since the step was accepted.
    pub seconds: f64,
}

/// Wall seconds by phase.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Seconds {
    /// Numbering, geometry, patterns, eigenvalue estimates.
    pub prepare: f64,
    /// Wall seconds of assembling: A11, masses, loads, and the forces of the body
    /// itself.
    pub assemble: f64,
    /// Wall seconds of ordering and factorising the P1 block.
    pub factorise: f64,
    /// Wall seconds of Krylov iterations with their preconditioner.
    pub krylov: f64,
    /// Gap integrals, compliance, small dense problems.
    pub contact: f64,
    /// Whether the equilibrium is a minimum: eigenvalues of the tangent, or its factor.
    pub stability: f64,
    /// Norms of the error against a manufactured field, which nobody asks of a
    /// solver in use; part of the total.
    pub error_norms: f64,
    /// From the accepted update to the finished increment.
    pub total: f64,
}

impl Seconds {
    /// Those of all phases of a solve but its certificate.
    pub(crate) fn of_solving(&self) -> f64 {
        self.prepare + self.assemble + self.factorise + self.krylov + self.contact
    }
}

/// What one obstacle does to the body.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ObstacleResult {
    /// Force that the obstacle exerts on the body `[3]`.
    pub force: [f64; 3],
    /// Estimated discretisation error of the length of `force`, a force, with what overlaps
    /// hide that the mesh does not feel; none where [`StepReport::error_estimate`] is.
    pub force_error: Option<f64>,
    /// Distance of the facets in contact from the curved surface that they stand for,
    /// over how far contact has pushed it; none where the surface is flat or given.
    pub geometry_error: Option<f64>,
    /// Its moment about the obstacle's current reference point `[3]`.
    pub moment: [f64; 3],
    /// Area carried by vertices in contact: deformed for bodies of finite strain, undeformed for
    /// linear ones. It counts whole vertices; `deformed_contact_area` ends inside faces.
    pub contact_area: f64,
    /// Area of the deformed surface in contact, whose edge is found inside the faces from the gap
    /// beyond it: per unit thickness in the plane, of the full turn about an axis; zero without
    /// contact.
    pub deformed_contact_area: f64,
    /// Length of the deformed surface in contact in the plane or the section, the sum of the
    /// intervals' widths; none in space.
    pub contact_width: Option<f64>,
    /// Intervals of contact along the surface in the plane or the section; empty in space and
    /// without contact.
    pub contact_intervals: Vec<ContactInterval>,
    /// Largest value of the field of contact pressure, which may lie between the vertices: per the
    /// same area as `max_pressure`; zero without contact.
    pub peak_pressure: f64,
    /// Where that is in the deformed body `[3]`; none without contact.
    pub peak_pressure_place: Option<[f64; 3]>,
    /// Integral of the contact pressure, the normal force without regard to its direction, over
    /// `deformed_contact_area`; none without contact.
    pub mean_pressure: Option<f64>,
    /// Largest vertex value of the contact pressure: per deformed area for bodies of finite
    /// strain.
    pub max_pressure: f64,
    /// The same; none for linear kinematics.
    pub max_pressure_deformed: Option<f64>,
    /// Largest vertex value of the contact pressure per undeformed area; none for linear
    /// kinematics.
    pub max_pressure_undeformed: Option<f64>,
    /// Pressure-weighted mean position in the deformed body `[3]`; zero without contact.
    pub centre_of_pressure: [f64; 3],
    /// Number of contact multipliers that are pressed and stick; zero without friction.
    pub stick_vertices: u32,
    /// Number of those that are pressed and slip; zero without friction.
    pub slip_vertices: u32,
    /// Number of those that are open; zero without friction.
    pub open_vertices: u32,
    /// Largest mean slip of a multiplier that is pressed in this increment, a length.
    pub max_slip: f64,
    /// Least 1 - |t| / (mu p) of what sticks; none where nothing does.
    pub stick_margin: Option<f64>,
    /// Part of `force` that friction exerts `[3]`.
    pub tangential_force: [f64; 3],
    /// Energy that slip has dissipated in this increment.
    pub dissipated_energy: f64,
    /// The same from the start.
    pub dissipated_total: f64,
}

/// Contact without a break along the surface of a plane body, or of the section of a body of
/// revolution.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ContactInterval {
    /// Where it begins in the deformed body `[3]`, the body on the left of who goes to the end.
    pub start: [f64; 3],
    /// Where it ends in the deformed body `[3]`.
    pub end: [f64; 3],
    /// Length of the deformed surface between.
    pub width: f64,
    /// Force of the contact pressure on the body there, without friction `[3]`: per unit
    /// thickness, or of the full turn about an axis.
    pub force: [f64; 3],
}

/// Contact between two bodies.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BodyContactResult {
    /// Force on the body of the group that the scene names first `[3]`; the other one has the
    /// opposite force. About an axis of the full turn, radial forces summed along x.
    pub force: [f64; 3],
    /// Its moment about the origin `[3]`; zero about an axis.
    pub moment: [f64; 3],
    /// Area of the deformed surface in contact, per unit thickness in the plane; zero without
    /// contact.
    pub contact_area: f64,
    /// Length of the deformed surface in contact in the plane, the sum of the intervals' widths.
    pub contact_width: f64,
    /// Intervals of contact along the surface that carries the pressure, with the force on the body
    /// named first.
    pub contact_intervals: Vec<ContactInterval>,
    /// Integral of the pressure over `contact_area`; none without contact.
    pub mean_pressure: Option<f64>,
    /// Largest contact pressure; zero without contact.
    pub peak_pressure: f64,
    /// Where that is in the deformed body `[3]`; none without contact.
    pub peak_pressure_place: Option<[f64; 3]>,
    /// What friction does; none without.
    pub friction: Option<BodyFriction>,
}

/// Friction between two bodies.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BodyFriction {
    /// Part of the contact's force that tractions exert `[3]`, on the body named first.
    pub tangential_force: [f64; 3],
    /// Points of the pressure that stick.
    pub stick_vertices: u32,
    /// Points that slip.
    pub slip_vertices: u32,
    /// Points without pressure.
    pub open_vertices: u32,
    /// Largest slip of the increment, length.
    pub max_slip: f64,
    /// Least share of its bound that the traction of a point that sticks has left; none where none
    /// sticks.
    pub stick_margin: Option<f64>,
    /// Energy that friction has dissipated in the increment.
    pub dissipated_energy: f64,
    /// The same from the start.
    pub dissipated_total: f64,
}

/// A tie between two bodies.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TieResult {
    /// Force on the body of the group that the scene names first `[3]`; the other one has the
    /// opposite force. About an axis of the full turn, along it.
    pub force: [f64; 3],
    /// Its moment on the deformed body about the origin `[3]`; zero about an axis.
    pub moment: [f64; 3],
    /// Undeformed area that is tied, per unit thickness in the plane.
    pub area: f64,
    /// How far the undeformed surfaces are apart, or inside each other, at most: length.
    pub gap: f64,
    /// Largest traction, per undeformed area.
    pub peak_traction: f64,
    /// Where that is in the deformed body `[3]`.
    pub peak_traction_place: [f64; 3],
}

/// Reaction of one support.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SupportResult {
    /// Force that the support exerts on the body `[3]`.
    pub force: [f64; 3],
    /// Its moment on the deformed body about the reference point `[3]`; zero about an axis of
    /// revolution and of flows.
    pub moment: [f64; 3],
    /// Where the reference point is now `[3]`, length: `about`, the origin where nothing has given
    /// one, moved by the translation.
    pub reference_point: [f64; 3],
    /// Translation of the support `[3]`, length: as steps lead it, or as its force asks for.
    pub translation: [f64; 3],
    /// Rotation vector about the reference point `[3]`, radians.
    pub rotation: [f64; 3],
}

/// Values at one probe.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ProbeResult {
    /// Displacement of the point `[3]`, length.
    pub displacement: [f64; 3],
    /// Internal pressure; none when the scene has no pressure unknown.
    pub pressure: Option<f64>,
}

/// Error norms against a manufactured field.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ManufacturedErrors {
    /// Norm of the displacement error, ‖u_h − u‖ in L2.
    pub displacement_l2: f64,
    /// Norm of the gradient's error, ‖∇(u_h − u)‖ in L2.
    pub displacement_h1: f64,
    /// ‖p_h − p‖ in L2; none without a pressure unknown.
    pub pressure_l2: Option<f64>,
    /// Energy norm of u_h − u over that of u: what [`StepReport::error_estimate`]
    /// estimates.
    pub relative_energy: f64,
}

/// Unknowns by kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Unknowns {
    /// Displacement components (P2), held ones included.
    pub displacement: u64,
    /// Number of internal pressures (P1); zero in displacement form.
    pub pressure: u64,
    /// Contact multipliers (P1 on the contact surface).
    pub contact: u64,
}

/// The result of one increment. The default is the report of nothing done: counts
/// and results zero or absent, not converged.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StepReport {
    /// Number of the step, from 1.
    pub step: u32,
    /// Number of the increment within the step, from 1.
    pub increment: u32,
    /// Step − 1 + the fraction of the step reached, so that 1.5 is the middle of the
    /// second.
    pub time: f64,
    /// Load factor reached; 1 is the full load of the scene.
    pub load: f64,
    /// How the increment ended.
    pub termination: Termination,
    /// Why the increment did not converge; none when it did.
    pub cause: Option<Cause>,
    /// Where the cause lies, or a fluid is about to leak; none when neither is, or nothing is known.
    pub cause_site: Option<CauseSite>,
    /// The snap-through from a lost equilibrium to the next minimum; none where every
    /// equilibrium was followed.
    pub snapped: Option<Snapped>,
    /// What a mechanic would doubt.
    pub warnings: Vec<Warning>,
    /// Number of SQP iterations: quadratic programs solved.
    pub sqp_iterations: u32,
    /// Number of Krylov iterations over all programs.
    pub krylov_iterations: u32,
    /// Applications of the displacement preconditioner inside Krylov methods.
    pub preconditioner_applications: u32,
    /// Operator applications spent on eigenvalue estimates.
    pub eigenvalue_applications: u32,
    /// Number of compliance columns computed, each one solve with the P1 block.
    pub compliance_columns: u32,
    /// Products with the exact compliance of contact, one inner solve each; none
    /// for methods on one level.
    pub contact_products: u32,
    /// Number of revisions of the active set.
    pub active_set_changes: u32,
    /// Steps of Newton's method for friction in the dense problems that choose what sticks
    /// and slips; zero without friction.
    pub newton_steps: u32,
    /// Passes of the iteration on the threshold of friction; zero for all other methods.
    pub threshold_passes: u32,
    /// Number of cut-backs inside this increment: parts that were tried and halved.
    pub cut_backs: u32,
    /// What failed inside this increment, in order, and what followed; empty where the first
    /// attempt converged.
    pub attempts: Vec<Attempt>,
    /// Number of factorisations of the P1 block.
    pub factorisations: u32,
    /// Number of vertices in contact.
    pub active_vertices: u32,
    /// Stored elastic energy, force times length; of a fluid, half of the dissipated
    /// power.
    pub strain_energy: f64,
    /// Deformed over undeformed volume of the body.
    pub volume_ratio: f64,
    /// Smallest det F at a quadrature point; none for linear kinematics.
    pub min_jacobian: Option<f64>,
    /// Least Bernstein coefficient of det F over all cells: det F is nowhere in
    /// the body below it. None for linear kinematics.
    pub min_jacobian_bound: Option<f64>,
    /// What kind of equilibrium a converged increment is; none for linear
    /// kinematics and where it was not found out.
    pub stability: Option<Stability>,
    /// Weight of the volume penalty in units of the shear modulus; zero where there
    /// is none.
    pub penalty: f64,
    /// Deepest penetration at a quadrature point of the contact surface.
    pub max_penetration: f64,
    /// The four convergence criteria at the end.
    pub residuals: Residuals,
    /// Bound on them that counts as converged: the scene's, or what the estimated
    /// discretisation error deserves.
    pub tolerance: f64,
    /// What each obstacle does to the body, by its name.
    pub obstacles: BTreeMap<String, ObstacleResult>,
    /// Contacts between bodies, by their names.
    pub contacts: BTreeMap<String, BodyContactResult>,
    /// Ties between bodies, by their names.
    pub ties: BTreeMap<String, TieResult>,
    /// Reaction of each support, by its name.
    pub supports: BTreeMap<String, SupportResult>,
    /// What each fluid does to the body, by its name.
    pub fluids: BTreeMap<String, FluidResult>,
    /// Goals of the scene; empty where it has none or there is no answer.
    pub goals: Vec<GoalReport>,
    /// Which goals or parameters have no answer, and why; none where all have, or there are none.
    pub goals_refused: Option<String>,
    /// Values at each probe, by its name.
    pub probes: BTreeMap<String, ProbeResult>,
    /// Estimate of the discretisation error: energy norm of u_h − u over that of
    /// u, without the volume energy where a pressure unknown carries it. None for
    /// an increment that did not converge or where the scene asks for none.
    pub error_estimate: Option<f64>,
    /// Errors against the manufactured field, when the scene has one.
    pub errors: Option<ManufacturedErrors>,
    /// Wall seconds by phase.
    pub seconds: Seconds,
    /// Number of unknowns by kind.
    pub unknowns: Unknowns,
    /// Bytes held by the prepared data and the session state.
    pub memory_bytes: u64,
    /// Parts taken over from the cache instead of being built.
    pub reused: Vec<String>,
    /// The kernels that ran: `portable`, later `avx2`, `avx512`.
    pub instruction_set: String,
    /// What the scene's [`crate::scene::ReportScope`] has left out, by the names of this report;
    /// numbers among it are not a number. Empty in a report on the whole body.
    pub left_out: Vec<&'static str>,
    /// Residuals recomputed by the independent assembled path, when asked for.
    pub verification: Option<Residuals>,
}

impl StepReport {
    /// Whether no further increment follows in a step of that many: all are done, this one has
    /// failed, or a fluid is about to leak.
    pub fn ends_step(&self, increments: u32) -> bool {
        let mut fluids = self.fluids.values();
        self.increment >= increments
            || self.termination != Termination::Converged
            || fluids.any(|fluid| fluid.tightness == Tightness::Leaks)
    }
}

/// Receives reports while a step runs. Must be quick and must not block.
pub trait Observer {
    /// Called once per Krylov iteration.
    fn iteration(&mut self, _record: &IterationRecord) {}
}

/// An observer that listens to nothing.
#[derive(Clone, Copy, Debug, Default)]
pub struct Silent;

impl Observer for Silent {}

/// State of a token that nobody has stopped.
const RUNNING: u8 = 0;
/// State of a token that a caller has cancelled.
const CANCELLED: u8 = 1;
/// State of a token whose deadline has passed.
const DEADLINE: u8 = 2;

/// Tells a running solve to stop; clones share one flag. Solvers poll it every
/// Krylov iteration.
#[derive(Clone, Debug, Default)]
pub struct CancelToken(Arc<AtomicU8>);

impl CancelToken {
    /// A token that nobody has cancelled.
    pub fn new() -> Self {
        Self::default()
    }

    /// Asks the solve to stop; the first reason given stays.
    pub fn cancel(&self) {
        self.stop(CANCELLED);
    }

    /// Asks the solve to stop because its time is up.
    pub fn expire(&self) {
        self.stop(DEADLINE);
    }

    /// Stops the token for that reason, unless it has one already.
    fn stop(&self, reason: u8) {
        // Losing the race means that another reason already stands.
        let _first = self
            .0
            .compare_exchange(RUNNING, reason, Ordering::SeqCst, Ordering::SeqCst);
    }

    /// Whether the solve has to stop, and how it then reports.
    pub fn stopped(&self) -> Option<Termination> {
        match self.0.load(Ordering::SeqCst) {
            RUNNING => None,
            CANCELLED => Some(Termination::Cancelled),
            _ => Some(Termination::DeadlineExceeded),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_residual_that_is_not_a_number_is_the_largest() {
        let residuals = |gap| Residuals {
            equilibrium: 0.5,
            gap,
            ..Residuals::default()
        };
        assert!(residuals(f64::NAN).largest().is_nan());
        assert!((residuals(0.25).largest() - 0.5).abs() < 1e-15);
        let first = Residuals {
            equilibrium: f64::NAN,
            gap: 2.0,
            ..Residuals::default()
        };
        assert!(first.largest().is_nan());
    }
}
