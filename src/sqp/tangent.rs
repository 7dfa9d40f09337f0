//! The tangent of a body of finite strain at one state, and the motion of its
//! supports that is still to come.

use std::sync::Arc;

use super::drive::Drive;
use super::evaluate::{Context, Evaluation, mask};
use super::state::State;
use crate::assembly::Constrained;
use crate::assembly::grid::{Basis, Rows};
use crate::assembly::strain::{TangentBody, TangentDivergence, TangentStiffness};
use crate::contact::gap::evaluate_gaps;
use crate::linalg::Workspace;
use crate::linalg::vector::add_scaled;

/// A and B about one state.
pub(super) struct Tangent {
    pub(super) stiffness: Constrained<TangentStiffness>,
    pub(super) coupling: TangentDivergence,
    pub(super) body: Constrained<TangentBody>,
}

impl Tangent {
    /// About the present state; none for a linear body.
    pub(super) fn new(
        context: &Context<'_>,
        state: &mut State,
        work: &mut Workspace,
    ) -> Option<Self> {
        let cells = state.cells(context.prepared)?.clone();
        // In place once the tangent before is gone.
        let at = Arc::make_mut(&mut state.linearised);
        cells.linearise((&state.displacement, &state.pressure), at, work);
        let at = state.linearised.clone();
        let (size, vertices) = (state.displacement.len(), state.pressure.len());
        let held = context.prepared.held.clone();
        Some(Self {
            stiffness: Constrained {
                free: TangentStiffness {
                    cells: cells.clone(),
                    at: at.clone(),
                    basis: Basis::Hierarchical,
                    volumetric: 0.0,
                    size,
                },
                held: held.clone(),
            },
            coupling: TangentDivergence {
                cells: cells.clone(),
                at: at.clone(),
                vertices,
                size,
            },
            body: Constrained {
                free: TangentBody {
                    cells,
                    at,
                    vertices,
                    size,
                },
                held,
            },
        })
    }

    /// `evaluation` after the held entries have moved by `motion`, to first order
    /// inside the body.
    pub(super) fn after(
        &self,
        motion: &[f64],
        context: &Context<'_>,
        state: &State,
        evaluation: &Evaluation,
        work: &mut Workspace,
    ) -> Evaluation {
        let mut moved = evaluation.clone();
        let pressure = work.zeros(state.pressure.len());
        let mut force = work.scratch(motion.len());
        let mut volume = work.scratch(pressure.len());
        self.body.free.cells.tangent(
            &self.body.free.at,
            Rows::All,
            (motion, &pressure),
            (&mut force, &mut volume),
            work,
        );
        mask(&context.prepared.held, &mut force);
        add_scaled(&mut moved.force, -1.0, &force);
        add_scaled(&mut moved.constraint, -1.0, &volume);
        for vector in [pressure, force, volume] {
            work.give(vector);
        }
        if !moved.gap.is_empty() {
            let mut displacement = state.displacement.clone();
            add_scaled(&mut displacement, 1.0, motion);
            moved.gap = gaps(context, &state.drive, &displacement);
            if !context.relief.is_empty() {
                add_scaled(&mut moved.gap, 1.0, context.relief);
            }
        }
        moved
    }
}

fn gaps(context: &Context<'_>, drive: &Drive, displacement: &[f64]) -> Vec<f64> {
    let body = context.deformed(displacement);
    let obstacles = context
        .interfaces
        .obstacles(drive, context.plan.units.length);
    let list = context.interfaces.list.iter().zip(&obstacles);
    list.flat_map(|(interface, obstacle)| evaluate_gaps(&body, &interface.surface, obstacle).0)
        .collect()
}
