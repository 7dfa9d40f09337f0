//! Contact of nearly incompressible bodies with rigid obstacles.
//!
//! Solves, on tetrahedra or triangles (plane strain),
//!
//! ```text
//! -div(2 mu eps(u) - p I) = f      in the body
//! -div u - p / lambda = 0          in the body (lambda infinite at Poisson ratio 1/2)
//! g(u) >= 0, l >= 0, l g(u) = 0    on the candidate surface, l the contact pressure
//! ```
//!
//! with P2 displacements, P1 pressure and P1 contact multipliers; in hierarchical
//! form P2 = P1 + edge corrections, with a P1 solve inside every preconditioner.
//! The method grew out of M. Fortin and A. El Maliki, *A hierarchical
//! preconditioner for Stokes and connected problems* (2007).
//!
//! # Code map
//!
//! | part | rooms |
//! |---|---|
//! | ground | [`report`] words of all reports; [`linalg`] vectors, sparse and dense factors, the only door to faer; [`geometry`] points, tensors, rigid motions |
//! | numbers wing | [`precond`] p-multigrid, P1 solvers, Schur metrics; [`krylov`] CG and GCR; [`saddle`] multiplier blocks; [`inequality`] the same with admissible sets |
//! | mechanics wing | [`mesh`]; [`element`] rules and analytic fields; [`space`] numbering; [`material`]; [`obstacle`]; [`assembly`] operators, masses, loads; [`contact`] gaps and resultants |
//! | hall | [`scene`] the problem as data; [`plan`] decisions and prepared data; [`sqp`] load steps |
//!
//! The wings never import each other; `tests/architecture.rs` holds the table.
//!
//! # From a scene to a result
//!
//! [`Mesh::new`] checks arrays. [`Plan::new`] validates a [`Scene`] and decides.
//! [`Prepared::build`] does what is expensive, once for all sessions with the
//! same [`PreparedKey`]. A [`Session`] owns the state; [`Session::begin_step`]
//! and [`Session::advance`] return one [`StepReport`] per increment.
//!
//! # Notation
//!
//! | symbol | name in code | shape | unit inside |
//! |---|---|---|---|
//! | u | `displacement` | nodes x components, vertices first | length of the body |
//! | c_e | edge correction: midpoint minus mean of the ends | as u | as u |
//! | p | `pressure`, positive in compression | vertices | smallest shear modulus |
//! | l | `multiplier`, contact pressure | candidates of all obstacles | as p |
//! | g_i = int phi_i d(x + u) dS | `gap` | as l | length^dimension |
//! | A, A11 | `stiffness`, its P1 block | | |
//! | B | `divergence`: (B u)_i = -int lambda_i div u | vertices x unknowns | |
//! | C = -dg/du | `coupling` | candidates x unknowns | |
//! | S | `stabilisation`: mass over lambda | vertices x vertices | |
//! | K | `compliance`: metric of l | candidates x candidates | |
//! | A^ | `PMultigrid`, the displacement preconditioner | | |
//!
//! # Invariants
//!
//! 1. The library does no input or output, starts no thread, and reads the
//!    clock for reports and deadlines only.
//! 2. [`Prepared`] is never changed; a session's only mutable thing is its state.
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

pub mod assembly;
pub mod contact;
pub mod element;
pub mod geometry;
pub mod inequality;
pub mod krylov;
pub mod linalg;
pub mod material;
pub mod mesh;
pub mod obstacle;
pub mod plan;
pub mod precond;
pub mod report;
pub mod saddle;
pub mod scene;
pub mod space;
pub mod sqp;

pub use mesh::{CellKind, Group, GroupKind, Mesh, MeshError, MeshId, MeshParts};
pub use plan::{LeftOut, Plan, PlanEntry, PlanReport, PrepareError, Prepared, PreparedKey};
pub use report::{
    CancelToken, Cause, FieldData, FieldName, IterationRecord, Observer, Residuals, Silent,
    StepReport, Termination,
};
pub use scene::{Scene, SceneError, Step, Violation};
pub use sqp::{ObstaclePose, Reuse, Session, StepRun};
