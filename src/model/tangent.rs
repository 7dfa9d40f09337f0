//! The tangent of a body of finite strain at one state, and the motion of its
//! supports that is still to come.
//!
//! ```text
//! A = d(internal force)/du,   B = -d(volume)/du
//! ```
//!
//! A `[displacement, displacement]` acts without being assembled, in space from what the
//! state left at the quadrature points, in the plane by the matrices of the cells; B is
//! `[pressures, displacement]`. Cost: one pass over the cells to linearise, in the plane
//! twelve, one for each product.

use std::sync::Arc;

use crate::assembly::Constrained;
use crate::assembly::grid::{Basis, Rows};
use crate::assembly::strain::{
    Linearised, Mixed, StrainGrid, TangentBody, TangentDivergence, TangentProducts,
    TangentStiffness,
};
use crate::linalg::Workspace;
use crate::linalg::vector::add_scaled;
use crate::model::Model;
use crate::model::evaluate::Evaluation;
use crate::model::held::mask;
use crate::model::mean_pressure::balance_volumes;
use crate::model::prescribed::Motion;
use crate::model::state::State;

/// A and B about one state.
pub(crate) struct Tangent {
    /// Cells of the body.
    pub(crate) cells: Arc<StrainGrid>,
    /// What the state left for products.
    pub(crate) at: Arc<Linearised>,
    /// A with held rows and columns the identity `[displacement, displacement]`.
    pub(crate) stiffness: Constrained<TangentStiffness>,
    /// B about the state, held columns left out `[pressures, displacement]`.
    pub(crate) coupling: TangentDivergence,
    /// The body's own part of A, without pressures and contact, whose block diagonal
    /// the inverse is made from.
    pub(crate) body: Constrained<TangentBody>,
}

impl Tangent {
    /// About the present state, written over `linearised`; none for a linear body.
    pub(crate) fn new(
        model: &Model<'_>,
        state: &State,
        linearised: &mut Arc<Linearised>,
        work: &mut Workspace,
    ) -> Option<Self> {
        let cells = state.cells(model.prepared)?;
        // In place once the tangent before is gone.
        let at = Arc::make_mut(linearised);
        cells.linearise((&state.displacement, &state.pressure), at, work);
        let at = linearised.clone();
        let (size, vertices) = (state.displacement.len(), state.pressure.len());
        let products = TangentProducts::new(&cells, &at, 0.0);
        let stiffness = TangentStiffness {
            products: products.clone(),
            basis: Basis::Hierarchical,
            size,
        };
        let coupling = TangentDivergence {
            products: products.clone(),
            vertices,
            size,
        };
        let body = TangentBody {
            products,
            vertices,
            size,
        };
        let held = || model.prepared.held.clone();
        Some(Self {
            cells,
            at,
            stiffness: Constrained {
                free: stiffness,
                held: held(),
            },
            coupling,
            body: Constrained {
                free: body,
                held: held(),
            },
        })
    }

    /// `evaluation` of `state` after `motion`, to first order inside the body; its gaps before what
    /// is carried along ([`Motion::move_gaps`]).
    pub(crate) fn after(
        &self,
        motion: &Motion,
        (model, state): (&Model<'_>, &State),
        evaluation: &Evaluation,
        work: &mut Workspace,
    ) -> Evaluation {
        let mut moved = evaluation.clone();
        let pressure = work.zeros(state.pressure.len());
        let whole = motion.whole();
        let mut force = work.scratch(whole.len());
        let mut volume = work.scratch(pressure.len());
        let tangent = self.cells.about(&self.at);
        tangent.apply(
            Rows::All,
            (&whole, &pressure),
            Mixed {
                displacement: &mut force,
                pressure: &mut volume,
            },
            work,
        );
        mask(&model.prepared.held, &mut force);
        add_scaled(&mut moved.force, -1.0, &force);
        add_scaled(&mut moved.constraint, -1.0, &volume);
        balance_volumes(model, &mut moved.constraint);
        for vector in [pressure, force, volume] {
            work.give(vector);
        }
        if !moved.gap.is_empty() {
            let mut after = state.clone();
            add_scaled(&mut after.displacement, 1.0, &motion.held);
            moved.gap = gaps(model, &after);
        }
        moved
    }
}

/// Weighted gaps of all multipliers.
fn gaps(model: &Model<'_>, state: &State) -> Vec<f64> {
    let body = model.deformed(&state.displacement);
    let mut gaps = vec![0.0; model.plan.unknowns().contact as usize];
    for (interface, obstacle) in model.placed(&state.drive) {
        let (own, _) = obstacle.gaps(&body, &interface.surface);
        interface.add_own(&own, &mut gaps);
    }
    if let Some(friction) = &model.interfaces.friction {
        let frames = friction.frames(model, state);
        let traces = friction.traces(model, state);
        let slips = friction.slips((&frames, &traces), model, state);
        gaps[friction.first..friction.first + slips.len()].copy_from_slice(&slips);
    }
    gaps
}
