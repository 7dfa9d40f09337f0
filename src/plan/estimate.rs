//! Predicted memory and work, from sizes alone.
//!
//! The factor of A11 by nested dissection was measured at 4.9 M entries and
//! 2.4 Gflop for 4096 vertices of a cube; entries grow like n^1.43, flops like
//! n^2.06. Plane meshes: n log n and n^1.5.

use crate::linalg::cholesky::Precision;
use crate::plan::Plan;
use crate::report::Unknowns;
use crate::scene::{MetricKind, P1Solver, ToleranceRule};

/// Vertices of the cube that the other figures were measured on.
const CUBE_VERTICES: f64 = 4096.0;
/// Entries of its scalar Cholesky factor.
const CUBE_ENTRIES: f64 = 4.9e6;
/// Floating-point operations of that factor.
const CUBE_FLOPS: f64 = 2.4e9;
/// Vectors of displacement length that a step holds at its peak: with them 43, 182 and 312 MB are
/// predicted for indented cubes of 12, 20 and 24 cells a side, which hold 48, 163 and 312.
const VECTORS: u64 = 60;
/// The same of a certificate by Lanczos steps beside it: most take twenty.
const CERTIFICATE_VECTORS: u64 = 40;
/// Bytes per cell of the matrix-free operator in both precisions and of the geometry it is made
/// from.
const CELL_BYTES: u64 = 400;

/// Entries of the factor of a saddle point over those of a P1 stiffness of that size: 3.9
/// million for 6934 unknowns of a cube, 4.8 million for 7605.
const SADDLE_FILL: f64 = 2.0;
/// Flops of that factor over those of the stiffness: 2.0 and 2.7 Gflop.
const SADDLE_WORK: f64 = 3.5;

/// Iterations that finding the entries of a tangent by products, ordering and turning cost: 4, 3 and
/// 10 ms on an X-ring, where an iteration takes 1.1 ms, 3.5 ms on a lip, where it takes 0.4 ms. More
/// in space (100 of 1 ms on a breast), where the other terms decide.
const ENTRIES_BY_PRODUCTS: f64 = 20.0;
/// Flops of a dense factor in the time that one iteration takes for each unknown, which waits for
/// memory: 1.1 ms for 5867 unknowns of a plane body where 344 solutions of 0.8 million entries take
/// 39 ms, and 0.95 ms for 8641 in space where a factor of 4 Gflop and 700 solutions take 0.8 s.
const ITERATION_FLOPS: [f64; 2] = [5e3, 2e3];
/// Share of the multipliers that are near what they may touch: 344 of 1260 on an X-ring, 94 of 416 on
/// a tyre, 31 of 84 on a lip; in space three quarters (684 of 879 on a gripper, 225 of 259 on a ball).
const NEAR_SHARE: f64 = 0.33;

/// Bytes per vertex that building a multigrid hierarchy takes at its peak.
const AMG_BYTES: f64 = 5000.0;
/// Flops per vertex to build one: mostly the products A P and P^T A P.
const AMG_FLOPS: f64 = 3e4;

/// Bytes per vertex of A11 and its incomplete factor, and flops to make it.
const IC_BYTES: f64 = 1600.0;
/// Floating-point operations per vertex to make that factor.
const IC_FLOPS: f64 = 3e3;
/// Bytes per cell that assembling and holding the edge block takes at its peak.
const EDGE_BLOCK_BYTES: u64 = 2400;
/// Residual that the discretisation error deserves on usual meshes.
const DISCRETISATION_TOLERANCE: f64 = 1e-4;

/// Entries of the factor of A11 and flops to make it.
pub(super) fn factor(dimension: usize, vertices: u64) -> (f64, f64) {
    let n = vertices as f64;
    match dimension {
        2 => {
            let logarithm = n.max(2.0).log2();
            (4.0 * 8.0 * n * logarithm, 8.0 * 10.0 * n.powf(1.5))
        }
        _ => (
            CUBE_ENTRIES * (n / CUBE_VERTICES).powf(1.43),
            CUBE_FLOPS * (n / CUBE_VERTICES).powf(2.06),
        ),
    }
}

/// Floating-point operations of the largest factor of a saddle point: seconds, while
/// nothing can interrupt it.
pub(crate) const MOST_FACTOR_FLOPS: f64 = 2e10;

/// Floating-point operations of the largest factor of a body whose response is kept.
pub(crate) const MOST_RESPONSE_FLOPS: f64 = 2e11;

/// Bytes of the factor of the assembled saddle point and flops to make it: those of a
/// factor on all P2 nodes.
pub(super) fn saddle_factor(dimension: usize, unknowns: Unknowns) -> (f64, f64) {
    let all = unknowns.displacement + unknowns.pressure + unknowns.contact;
    let (entries, flops) = factor(dimension, all / dimension as u64);
    (SADDLE_FILL * 8.0 * entries, SADDLE_WORK * flops)
}

/// Krylov iterations that cost as much as a factor of the body and the compliance of its near
/// contact; none where the factor takes more than it may.
pub(super) fn factor_cost(dimension: usize, unknowns: Unknowns) -> Option<u32> {
    let body = Unknowns {
        contact: 0,
        ..unknowns
    };
    let (bytes, flops) = saddle_factor(dimension, body);
    let all = (body.displacement + body.pressure) as f64;
    let solutions = 4.0 * (bytes / 8.0) * NEAR_SHARE * unknowns.contact as f64;
    let iterations = ENTRIES_BY_PRODUCTS
        + (flops + solutions) / (ITERATION_FLOPS[usize::from(dimension > 2)] * all);
    (flops <= MOST_FACTOR_FLOPS).then_some(iterations as u32)
}

/// Bytes of the P1 solver at its peak, and flops to make it.
pub(super) fn p1_solver(plan: &Plan, vertices: u64) -> (f64, f64) {
    match plan.decisions.p1.solver {
        P1Solver::Direct => {
            let (entries, flops) = factor(plan.problem.units.dimension, vertices);
            let number = match plan.factor_precision().0 {
                Precision::Single => 4.0,
                Precision::Double => 8.0,
            };
            (number * 1.2 * entries, flops)
        }
        P1Solver::Amg => (AMG_BYTES * vertices as f64, AMG_FLOPS * vertices as f64),
        P1Solver::IcCg => (IC_BYTES * vertices as f64, IC_FLOPS * vertices as f64),
    }
}

/// Bytes of prepared data and one session's state at their peak.
pub(super) fn bytes(plan: &Plan, vertices: u64) -> u64 {
    let components = plan.problem.units.dimension as u64;
    let steps = if plan.certifies_by_steps() {
        CERTIFICATE_VECTORS * plan.problem.unknowns.displacement
    } else {
        0
    };
    let vectors =
        VECTORS * (plan.problem.unknowns.displacement + plan.problem.unknowns.pressure) + steps;
    let blocks = plan.problem.unknowns.displacement * components;
    let edge_block = if plan.decisions.displacement.is_hierarchical() {
        EDGE_BLOCK_BYTES * plan.problem.cells as u64
    } else {
        0
    };
    p1_solver(plan, vertices).0 as u64
        + 8 * (dense_numbers(plan) + vectors + blocks)
        + CELL_BYTES * plan.problem.cells as u64
        + edge_block
        + 200 * vertices
        + plan.rubber_bytes(vertices)
        + plan.predicted_response_bytes()
}

/// Numbers in the dense matrices of contact at their peak: while the inverse of A11 is made at the
/// traces, or while parts of the metric are factorised. A vertex has one trace, the normal of its
/// surface, and with friction one in each direction; a factor is made by all components of the
/// vertices.
fn dense_numbers(plan: &Plan) -> u64 {
    let square = |n: u64| n.saturating_mul(n);
    let components = plan.problem.units.dimension as u64;
    let vertices = plan.decisions.contact_vertices.len() as u64;
    let traces = if plan.has_friction() {
        components * vertices
    } else {
        vertices
    };
    let made_by = match plan.decisions.p1.solver {
        P1Solver::Direct => components * vertices,
        P1Solver::Amg | P1Solver::IcCg => traces,
    };
    let choice = &plan.decisions.contact;
    let multipliers = plan.problem.unknowns.contact;
    // Quadratic multipliers without friction have their part on the vertices.
    let is_split = choice.metric == MetricKind::Compliance
        && !plan.has_friction()
        && 2 * vertices <= multipliers;
    let rows = match (choice.method.needs_dense(choice.metric), is_split) {
        (false, _) => 0,
        (true, true) => traces,
        (true, false) => multipliers,
    };
    // The matrix beside what it is made by; it beside a part and the factor of that.
    (2 * square(made_by)).max(square(traces) + 3 * square(rows))
}

/// Digits to which a dual solution is found: for bounds alone, and for derivatives at usual tolerances.
const DUAL_DIGITS: [f64; 2] = [4.0, 6.0];

/// Applications of the displacement preconditioner that one dual solution takes.
pub(super) fn dual_applications(plan: &Plan) -> u32 {
    let mut questions = plan.problem.scene.questions.iter();
    let asks_for_derivatives = questions.any(|one| !one.parameters.is_empty());
    let digits = DUAL_DIGITS[usize::from(asks_for_derivatives)];
    (digits * per_digit(plan) * relative_applications(plan)).ceil() as u32
}

/// Applications of the displacement preconditioner to reach the tolerance.
pub(super) fn applications(plan: &Plan) -> u32 {
    let solver = &plan.problem.settings;
    let tolerance = match solver.tolerance_rule {
        ToleranceRule::Fixed => solver.tolerance,
        ToleranceRule::Discretisation => solver.tolerance.max(DISCRETISATION_TOLERANCE),
    };
    let digits = -tolerance.log10();
    let contact = if plan.problem.unknowns.contact > 0 {
        1.5
    } else {
        1.0
    };
    (digits * per_digit(plan) * contact * relative_applications(plan)).ceil() as u32
}

/// Applications for a digit of a linear system by the usual methods.
fn per_digit(plan: &Plan) -> f64 {
    if plan.problem.resolved.mixed {
        3.2
    } else {
        1.7
    }
}

/// Those of the plan's methods over that.
fn relative_applications(plan: &Plan) -> f64 {
    plan.decisions.displacement.relative_applications()
        * plan.decisions.saddle.method.relative_applications()
}
