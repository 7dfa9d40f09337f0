//! Contact of nearly incompressible bodies with rigid obstacles.
//!
//! Solves, on tetrahedra or triangles (plane strain, plane stress, axisymmetric),
//!
//! ```text
//! -div(2 mu eps(u) - p I) = f      in the body
//! -div u - p / lambda = 0          in the body (lambda infinite at Poisson ratio 1/2)
//! g(u) >= 0, l >= 0, l g(u) = 0    on the candidate surface, l the contact pressure
//! ```
//!
//! with P2 displacements, P1 pressure and quadratic contact pressure; a support that holds the
//! normal component does so by P2 multipliers of either sign. The spaces are
//! hierarchical, P2 = P1 + edge corrections, with a P1 solve inside every
//! preconditioner. Rubber at finite strain puts its stress in the place of the first
//! line, its tangent in the place of A, and det F - 1 in the place of div u.
//! The method grew out of M. Fortin and A. El Maliki, *A hierarchical
//! preconditioner for Stokes and connected problems* (2007).
//!
//! # Code map
//!
//! | part | rooms |
//! |---|---|
//! | ground | [`report`] words of all reports; `constants` those of the solver's decisions, listed; [`parallel`] loops over pieces; [`linalg`] vectors, sparse and dense factors, the only door to faer; [`geometry`] points, tensors, rigid motions |
//! | numbers wing | [`precond`] p-multigrid, P1 solvers, Schur metrics; [`krylov`] CG and GCR; [`saddle`] multiplier blocks and their admissible sets; [`inequality`] methods for blocks whose sets are not free |
//! | mechanics wing | [`mesh`]; [`element`] rules and analytic fields; [`space`] numbering and interpolation; [`material`]; [`obstacle`]; [`assembly`] operators, masses, loads; [`contact`] gaps, guides and resultants; [`fluid`] what fluids reach of a surface, and the path of the first leak; [`proximity`] how near a tool is to faces, cells and on its path; [`pairs`] gaps between two surfaces of the body; [`ties`] surfaces that are bonded, whose meshes need not match |
//! | the problem | [`scene`] as data, its choices enums; [`plan`] resolved items, decisions with reasons; [`prepare`] what is expensive and shared |
//! | the solver | `model` the body at a state, its residuals and tangent; `sqp` equilibrium under one drive: programs, search, what is learnt; `force_control` poses from forces; `stability`; `diagnosis` causes and where they lie; `continuation` the load path, and what follows a failure; [`session`] states that steps move |
//! | the answer | `results` reports, fields, error estimates; `goals` functionals of a converged state, their dual solutions and derivatives; `verify` the same residuals by an independent path |
//! | laws from tests | [`calibration`] constants of a law from test curves |
//! | finer meshes | [`refinement`] bisection of marked cells, and fields and states on what follows; [`adapted`] meshes that are refined until goals are known well enough |
//! | beside it | [`comparisons`] methods that a caller brings along: those that the solver is compared with are the crate `signorini-compare` |
//!
//! The wings never import each other, and no two files import each other in a circle;
//! `tests/architecture` holds both.
//!
//! # From a scene to a result
//!
//! [`Mesh::new`] checks arrays. [`Plan::new`] validates a [`Scene`], resolves its names
//! into items with facets and built shapes, and decides. [`Prepared::build`] does what
//! is expensive, once for all sessions with the same [`PreparedKey`]. A [`Session`] owns
//! a state; [`Session::begin_step`] makes a [`StepRun`], and each [`Session::advance`]
//! solves one increment of it and returns its [`StepReport`]. [`Session::export`] and
//! [`Session::import`] carry a session to another process, [`Session::restore`] takes one back.
//!
//! Inside, an increment is one `sqp::run::Run`: the model, the state that it moves, what
//! earlier programs have taught, who watches, counts and scratch. `continuation` takes
//! its load path at once, in bounded parts where a tool could pass, in smaller ones after a failure
//! (`continuation::strategy`); `sqp::increment` solves one part by quadratic programs; `results::step` reads the state into the report.
//!
//! # Where it is decided
//!
//! | question | files |
//! |---|---|
//! | what follows a part of the load path that failed | `src/continuation/strategy.rs`, `src/continuation/parts.rs` |
//! | how long parts may be so that no tool passes | `src/continuation/longest_part.rs` |
//! | the law of friction: radius, projection, status | `src/saddle/set/cones.rs`; slip: `src/model/friction.rs` |
//! | a wire message as a step, a step as the drive at its end | `server/src/convert/step.rs`, `src/session/mod.rs`, `src/model/drive.rs` |
//! | a tool that begins inside the body | before: `src/plan/overlap.rs`, `src/plan/behind.rs`, `src/plan/doubts.rs`; pushed out: `src/continuation/initial_penetration.rs` |
//! | a tool that has passed, or lies inside | `src/results/passage.rs`, `src/results/warnings.rs`, by distances of `src/proximity/mod.rs` |
//! | a new obstacle shape | `src/obstacle/shape.rs`, `src/plan/reach.rs`, `src/session/checkpoint/scene_digest.rs`, `proto/signorini/v1/scene.proto`, `server/src/convert/shape.rs`, `client/src/scene_file/shape.rs`, `client/python/signorini/scene.py` |
//! | a new law of rubber | a function of the invariants: a file beside `src/material/gent.rs`, `src/material/potential.rs`; of the stretches: one beside `src/material/hyperfoam.rs`, `src/material/rubber.rs`; both: `src/scene/material.rs`, `src/scene/validate/rubber.rs`, `src/session/checkpoint/scene_digest.rs`, `src/verify/rubber.rs`, `proto/signorini/v1/scene.proto`, `server/src/convert/material.rs`, `client/src/scene_file/material.rs`, `client/python/signorini/scene.py` |
//!
//! # Notation
//!
//! | symbol | name in code | shape | unit inside |
//! |---|---|---|---|
//! | u | `displacement` | nodes x components, vertices first | length of the body |
//! | c_e | edge correction: midpoint minus mean of the ends | as u | as u |
//! | p | `pressure`, positive in compression | vertices | smallest shear modulus |
//! | l | `multiplier`: contact pressure, normal traction of guides | multipliers of all interfaces | as p |
//! | g_i = int psi_i d(x + u) dS | `gap`, weighted by a multiplier function; da, the deformed area, for bodies of finite strain | as l | length^dimension |
//! | A, A11 | `stiffness`, its P1 block | | |
//! | B | `divergence`: (B u)_i = -int lambda_i div u | vertices x unknowns | |
//! | C = -dg/du | `coupling`, `rows` of a block | multipliers x unknowns | |
//! | S | `stabilisation`: mass over lambda | vertices x vertices | |
//! | K | `compliance`: metric of l | multipliers x multipliers | |
//! | D | `columns` of a block: the forces of its multipliers, transposed; D = C without friction | as C | as C |
//! | x in X | `AdmissibleSet`: `Free`, `NonNegative`, `Discs`, `Cones` | a run of multipliers | |
//! | | `Status`: `Open` x = 0, `Stick` residual zero, `Slip` on the edge of the set | as l | |
//! | s_i = T_i int psi_i (x - Q x0) dS (da as for g) | `slip` of a point of friction, weighted | tractions | length^dimension |
//! | A^ | `PMultigrid`, the displacement preconditioner | | |
//! | m(X) | `RigidMotion` of an obstacle or a support | rotation, translation | radians, length |
//! | s | `penalty`: weight of the volume term of rubber | one number | shear moduli |
//! | | `Run`: one increment under way | | |
//! | | `State`: fields, multipliers, statuses, drive, scales; exactly the checkpoint | | |
//! | | `Learned`: directions, inverse, lowest mode, trend; may be dropped | | |
//!
//! # Vocabulary
//!
//! | term of the field | name in code | where |
//! |---|---|---|
//! | active set, set of closed constraints | `Status`, `closed` | `saddle::set` |
//! | admissible set, convex set of constraints | `AdmissibleSet`, `ProductSet` | `saddle::set` |
//! | approximate inverse about a deformed state | `ApproximateInverse` | `prepare::approximate_inverse` |
//! | bilateral contact, rollers on any surface | `Guide`, `support.normal` | `contact::counterpart` |
//! | candidate face of a contact surface | `ContactFace` | `contact::face` |
//! | certificate of stability, second-order condition | `certify` | `stability` |
//! | checkpoint, restart data | `State` | `model::state` |
//! | compliance, Steklov-Poincare operator of the surface | `compliance` | `precond::compliance` |
//! | contact surface with its multipliers and what it meets | `Interface` | `model::interfaces` |
//! | continuation, extrapolation along the load | `Trend` | `sqp::trend` |
//! | counterpart: what a face meets, master surface | `Counterpart`, `Obstacle` | `contact::counterpart`, `obstacle` |
//! | cut-back, adaptive load stepping | `Parts`, `Checkpoint` | `continuation::parts`, `continuation::checkpoint` |
//! | dual solution, adjoint; sensitivities, goal-oriented error | `solve_dual`; `goals` | `sqp::program::dual`, `goals` |
//! | edge, width and intervals of contact | `portions`, `stretches`, `ContactInterval` | `contact::edge`, `contact::stretches` |
//! | estimate of the discretisation error by recovery | `estimate` | `results::estimate` |
//! | factor of the body, Schur complement on contact | `FactoredBody`, `NearCompliance` | `sqp::factored_body`, `sqp::near_compliance` |
//! | face of the feasible polyhedron | `Face` | `inequality::one_level` |
//! | fluid penetration, wetted front, leak path | `FluidSurface`, `Front`, `Barrier` | `fluid` |
//! | blow-off pressure | `LeakBracket` | `continuation::leak_bracket` |
//! | Doerfler marking, adaptive refinement by the dual weighted residual | `marks`, `adapt` | `adapted` |
//! | force control, prescribed forces on an obstacle or a support | `Balance` | `force_control` |
//! | forcing term of an inexact Newton method | `goal` | `sqp::increment` |
//! | inertia, modified Newton step of an unstable body | `Turned` | `inequality::factorised::turned` |
//! | friction, Coulomb, Tresca | `FrictionBound`, `Cones`; `Friction` for slip | `saddle::set::cones`, `model::friction` |
//! | initial penetration, overclosure at the start | `InitialPenetration` | `continuation::initial_penetration` |
//! | line search | `search` | `sqp::search` |
//! | load path, what follows a failed part | `LoadPath`, `after` | `continuation`, `continuation::strategy` |
//! | load factor, poses, prescribed motion | `Drive` | `model::drive` |
//! | lowest mode, softest motion of the tangent | `LowestMode` | `sqp::lowest_mode` |
//! | mesh refinement, newest vertex bisection, conforming closure | `Hierarchy`, `Lineage` | `refinement` |
//! | multiplier space: hats, quadratic Bernstein functions | `ContactBasis` | `contact::basis` |
//! | preconditioner refresh | `PreconditionerRefresh` | `sqp::preconditioner_refresh` |
//! | quadratic program of an SQP iteration | `QuadraticProgram` | `sqp::program` |
//! | recycled Krylov directions | `Directions` | `krylov::gcr` |
//! | response at the contact surface, static condensation, superelement | `Response` | `sqp::condensation` |
//! | proximal point method, implicit Euler flow to rest | `Flow` | `sqp::proximal_flow` |
//! | rigid predictor, co-rotated start | `RigidPredictor` | `sqp::rigid_predictor` |
//! | snap-through, snap-buckling | `snap_through` | `continuation::snap_through` |
//! | static condensation on the multiplier | `Condensed` | `inequality::condensed` |
//! | curved edges, cells of second order | `EdgeOffset`, `CurvedCell`, `CurvedFacet` | `element`, `mesh` |
//! | trace directions of the compliance | `TraceDirections` | `prepare::traces` |
//! | values of other codes, coupling data | `Given`, `Spread` | `model::given`, `scene::validate` |
//! | weighted gap | `gap` | `contact::gap` |
//!
//! # Invariants
//!
//! 1. The library does no input or output, starts no thread, and reads the
//!    clock for reports and deadlines only.
//! 2. [`Prepared`] is never changed. A session changes its state, which is all that a
//!    resumed session needs, and what it has learnt, which may be dropped.
//! 3. The wings do not import each other; only `linalg` names faer.
//! 4. Displacement vectors are ordered vertices, then edges.
//! 5. Every loop has a typed outcome, and every outcome keeps the best state.
//! 6. What a scene does not use is absent from [`Prepared`].
//! 7. The same request gives the same bits for every number of threads.
//!
//! # Decisions
#![doc = include_str!("decisions/0001-run-time-dimension.md")]
#![doc = include_str!("decisions/0002-multiplier-blocks.md")]
#![doc = include_str!("decisions/0003-kept-directions.md")]
#![doc = include_str!("decisions/0004-blocks-and-determinism.md")]
#![doc = include_str!("decisions/0005-kernels-through-pulp.md")]
#![doc = include_str!("decisions/0006-ordering-from-coordinates.md")]
#![doc = include_str!("decisions/0007-smoothing-interval.md")]
#![doc = include_str!("decisions/0008-dependencies.md")]
#![doc = include_str!("decisions/0009-service-shape.md")]
#![doc = include_str!("decisions/0010-streams-and-slots.md")]
#![doc = include_str!("decisions/0011-p1-solvers.md")]
#![doc = include_str!("decisions/0012-error-estimate.md")]
#![doc = include_str!("decisions/0013-comparison-methods.md")]
#![doc = include_str!("decisions/0014-contact-methods.md")]
#![doc = include_str!("decisions/0015-comparison-elements.md")]
#![doc = include_str!("decisions/0016-hard-bodies.md")]
#![doc = include_str!("decisions/0017-pressure-metric.md")]
#![doc = include_str!("decisions/0018-rule-of-rubber.md")]
#![doc = include_str!("decisions/0019-inverse-at-rest.md")]
#![doc = include_str!("decisions/0020-vertex-gradients.md")]
#![doc = include_str!("decisions/0021-where-programs-start.md")]
#![doc = include_str!("decisions/0022-penalty-of-rubber.md")]
#![doc = include_str!("decisions/0023-run-state-learned.md")]
#![doc = include_str!("decisions/0024-admissible-sets.md")]
#![doc = include_str!("decisions/0025-normal-supports.md")]
#![doc = include_str!("decisions/0026-comparisons-apart.md")]
#![doc = include_str!("decisions/0027-true-surface.md")]
#![doc = include_str!("decisions/0028-second-attempt.md")]
#![doc = include_str!("decisions/0029-contact-space.md")]
#![doc = include_str!("decisions/0030-springs-in-contact.md")]
#![doc = include_str!("decisions/0031-thin-bodies.md")]
#![doc = include_str!("decisions/0032-instability.md")]
#![doc = include_str!("decisions/0033-friction.md")]
#![doc = include_str!("decisions/0034-matrices-of-triangles.md")]
#![doc = include_str!("decisions/0035-loads-without-a-potential.md")]
#![doc = include_str!("decisions/0036-scales-and-rounding.md")]
#![doc = include_str!("decisions/0037-shares-and-gates.md")]
#![doc = include_str!("decisions/0038-triangulated-tools.md")]
#![doc = include_str!("decisions/0039-who-may-do-what.md")]
#![doc = include_str!("decisions/0040-pushed-tools.md")]
#![doc = include_str!("decisions/0041-tools-on-grids.md")]
#![doc = include_str!("decisions/0042-metric-by-its-parts.md")]
#![doc = include_str!("decisions/0043-earlier-directions-stay.md")]
#![doc = include_str!("decisions/0044-values-of-other-codes.md")]
#![doc = include_str!("decisions/0045-motions-of-the-mesh.md")]
#![doc = include_str!("decisions/0046-response-at-the-surface.md")]
#![doc = include_str!("decisions/0047-account-of-an-application.md")]
#![doc = include_str!("decisions/0048-fleet.md")]
#![doc = include_str!("decisions/0049-studies.md")]
#![doc = include_str!("decisions/0050-augmented-linear.md")]
#![doc = include_str!("decisions/0051-branches-and-cell-tangents.md")]
#![doc = include_str!("decisions/0052-multigrid-in-contact.md")]
#![doc = include_str!("decisions/0053-gap-over-the-deformed-surface.md")]
#![doc = include_str!("decisions/0054-a-factor-where-it-is-cheaper.md")]
#![doc = include_str!("decisions/0055-compliance-along-lines.md")]
#![doc = include_str!("decisions/0056-curved-cells.md")]
#![doc = include_str!("decisions/0057-planes-at-nodes.md")]
#![doc = include_str!("decisions/0058-no-second-attempts.md")]
#![doc = include_str!("decisions/0059-comparisons-in-a-crate.md")]
#![doc = include_str!("decisions/0060-one-place-that-decides.md")]
#![doc = include_str!("decisions/0061-loops-compiled-once.md")]
#![doc = include_str!("decisions/0062-laws-by-point.md")]
#![doc = include_str!("decisions/0063-loaded-supports.md")]
#![doc = include_str!("decisions/0064-sheets-and-rings.md")]
#![doc = include_str!("decisions/0065-fluids-by-a-weight.md")]
#![doc = include_str!("decisions/0066-goals-by-one-dual-solution.md")]
#![doc = include_str!("decisions/0067-gaps-by-volume.md")]
#![doc = include_str!("decisions/0069-nested-bisection.md")]
#![doc = include_str!("decisions/0070-ties-by-multipliers.md")]
#![doc = include_str!("decisions/0071-meshes-by-goals.md")]
#![doc = include_str!("decisions/0072-one-surface-that-folds.md")]
#![doc = include_str!("decisions/0073-one-film-between-bodies.md")]

#[macro_use]
mod constants;

pub mod adapted;
pub mod assembly;
pub mod calibration;
pub mod comparisons;
pub mod contact;
mod continuation;
mod diagnosis;
pub mod element;
pub mod fluid;
mod force_control;
pub mod geometry;
mod goals;
pub mod inequality;
pub mod krylov;
pub mod linalg;
pub mod material;
pub mod mesh;
mod model;
pub mod obstacle;
pub mod pairs;
pub mod parallel;
pub mod plan;
pub mod precond;
pub mod prepare;
pub mod proximity;
pub mod refinement;
pub mod report;
mod results;
pub mod saddle;
pub mod scene;
pub mod session;
pub mod space;
mod sqp;
mod stability;
pub mod ties;
mod verify;

pub use comparisons::Comparisons;
pub use constants::Constant;
pub use goals::GoalError;
pub use mesh::{CellKind, EdgeOffset, Group, GroupKind, Mesh, MeshError, MeshId, MeshParts};
pub use plan::{LaterBytes, LeftOut, Plan, PlanEntry, PlanReport, PreparedKey};
pub use prepare::{PrepareError, Prepared};
pub use report::{
    CancelToken, Cause, FieldData, FieldName, IterationRecord, Observer, Residuals, Silent,
    StepReport, Termination,
};
pub use scene::{Scene, SceneError, Step, Violation};
pub use session::{
    CheckpointError, NotCarried, ObstaclePose, Origin, Reuse, Rounding, Session, Snapshot, StepRun,
};

/// The numeric constants of the rooms that search and decide, in the order of their files.
pub fn constants() -> Vec<Constant> {
    let rooms = [
        continuation::constants(),
        diagnosis::constants(),
        force_control::constants(),
        sqp::constants(),
        stability::constants(),
    ];
    let mut all = rooms.concat();
    all.sort_by_key(|one| one.file);
    all
}
