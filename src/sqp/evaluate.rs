//! Residuals of the nonlinear problem at a state, and the four criteria.

use super::constraints::Interfaces;
use super::drive::Drive;
use super::pressures::add_pressures;
use super::state::State;
use super::touching::Touching;
use crate::assembly::grid::{Basis, Rows};
use crate::assembly::strain::Response;
use crate::contact::gap::{Deformed, linearise};
use crate::inequality::QpScales;
use crate::linalg::vector::{add_scaled, dot, norm};
use crate::linalg::{LinearOperator, SparseRows, SparseRowsBuilder, Workspace};
use crate::mesh::Mesh;
use crate::plan::{Plan, TaylorHoodData as Prepared};
use crate::report::Residuals;

/// What a session reads while it solves.
#[derive(Clone, Copy)]
pub(crate) struct Context<'a> {
    pub(crate) plan: &'a Plan,
    pub(crate) mesh: &'a Mesh,
    pub(crate) prepared: &'a Prepared,
    pub(crate) interfaces: &'a Interfaces,
    /// Dead load at factor one.
    pub(crate) load: &'a [f64],
    /// Weighted gaps that count as closed beside zero; empty where none does.
    pub(crate) relief: &'a [f64],
    /// Bound on all four residuals.
    pub(crate) tolerance: f64,
}

impl<'a> Context<'a> {
    /// Whether one program solves an increment.
    pub(crate) fn is_linear(&self) -> bool {
        self.prepared.strain.is_none() && self.interfaces.are_flat()
    }

    /// The deformed body, for contact integrals.
    pub(crate) fn deformed(&self, displacement: &'a [f64]) -> Deformed<'a> {
        Deformed {
            mesh: self.mesh,
            scale: self.plan.units.coordinate_scale,
            space: &self.prepared.space,
            displacement,
            rule: &self.interfaces.rule,
        }
    }

    /// The body at `state` on its obstacles.
    pub(super) fn touching(&self, state: &'a State) -> Touching<'a> {
        Touching {
            plan: self.plan,
            interfaces: self.interfaces,
            state,
            body: self.deformed(&state.displacement),
        }
    }
}

/// Residuals at a state.
#[derive(Clone, Debug, Default)]
pub(crate) struct Evaluation {
    /// Free rows of f - A u - B^T p - C^T l.
    pub(crate) force: Vec<f64>,
    /// -(B u - S p).
    pub(crate) constraint: Vec<f64>,
    /// Weighted gap.
    pub(crate) gap: Vec<f64>,
    /// C = -dg/du on free columns.
    pub(crate) coupling: SparseRows,
    /// Norm of the external load on free rows.
    pub(crate) load_norm: f64,
    /// Norm of the contact load on free rows.
    pub(crate) contact_norm: f64,
    /// Norm of the reactions, where supports prescribe a motion.
    pub(crate) reaction_norm: f64,
    /// Deepest penetration at a point of the rule.
    pub(crate) max_penetration: f64,
    /// Least J at the points of the rule; none for linear bodies.
    pub(crate) least_jacobian: Option<f64>,
}

/// Zeroes held entries.
pub(crate) fn mask(held: &[u32], x: &mut [f64]) {
    for &index in held {
        x[index as usize] = 0.0;
    }
}

/// Euclidean norm of the held entries.
pub(crate) fn norm_of(held: &[u32], x: &[f64]) -> f64 {
    let entries = held.iter().map(|&index| x[index as usize]);
    entries.map(|value| value * value).sum::<f64>().sqrt()
}

/// Residuals of `state` under `drive`.
pub(crate) fn evaluate(
    context: &Context<'_>,
    state: &State,
    drive: &Drive,
    work: &mut Workspace,
) -> Evaluation {
    let mut out = Evaluation::default();
    add_contact(context, state, drive, &mut out);
    let prepared = context.prepared;
    let mut force = context.load.to_vec();
    force.iter_mut().for_each(|value| *value *= drive.load);
    add_pressures(context, &state.displacement, drive.load, &mut force);
    mask(&prepared.held, &mut force);
    out.load_norm = norm(&force);
    let inside = internal(context, state, work);
    add_scaled(&mut force, -1.0, &inside.force);
    if !state.multiplier.is_empty() {
        let mut contact = work.scratch(force.len());
        out.coupling
            .apply_transposed(&state.multiplier, &mut contact, work);
        out.contact_norm = norm(&contact);
        add_scaled(&mut force, -1.0, &contact);
        work.give(contact);
    }
    if drive.moves_supports() {
        out.reaction_norm = norm_of(&prepared.held, &force);
    }
    mask(&prepared.held, &mut force);
    out.force = force;
    out.constraint = inside.constraint;
    out.least_jacobian = inside.response.map(|response| response.least_jacobian);
    out
}

/// What the body itself brings to the residuals.
#[derive(Clone, Debug)]
pub(crate) struct Internal {
    /// A u + B^T p or what takes its place, all rows.
    pub(crate) force: Vec<f64>,
    /// -(B u - S p).
    pub(crate) constraint: Vec<f64>,
    /// None for linear bodies.
    pub(crate) response: Option<Response>,
}

/// Forces and volumes of the body at a state.
pub(crate) fn internal(context: &Context<'_>, state: &State, work: &mut Workspace) -> Internal {
    let Some(cells) = state.cells(context.prepared) else {
        return Internal {
            force: linear_force(context, state, work),
            constraint: constraint(context, state, work),
            response: None,
        };
    };
    let mut force = vec![0.0; state.displacement.len()];
    let mut residual = vec![0.0; state.pressure.len()];
    let fields = (&state.displacement[..], &state.pressure[..]);
    let response = cells.respond(fields, (&mut force, &mut residual), work);
    finish_constraint(context, state, &mut residual, work);
    Internal {
        force,
        constraint: residual,
        response: Some(response),
    }
}

/// A u + B^T p, all rows.
fn linear_force(context: &Context<'_>, state: &State, work: &mut Workspace) -> Vec<f64> {
    let grid = &context.prepared.grid;
    let mut force = vec![0.0; state.displacement.len()];
    grid.stiffness(
        Basis::Hierarchical,
        Rows::All,
        &state.displacement,
        &mut force,
        work,
    );
    if !state.pressure.is_empty() {
        let mut part = work.scratch(force.len());
        grid.divergence_transposed(Rows::All, &state.pressure, &mut part, work);
        add_scaled(&mut force, 1.0, &part);
        work.give(part);
    }
    force
}

/// -(B u - S p).
fn constraint(context: &Context<'_>, state: &State, work: &mut Workspace) -> Vec<f64> {
    let mut residual = vec![0.0; state.pressure.len()];
    if !residual.is_empty() {
        let grid = &context.prepared.grid;
        grid.divergence(Rows::All, &state.displacement, &mut residual, work);
        finish_constraint(context, state, &mut residual, work);
    }
    residual
}

/// From B u to -(B u - S p).
fn finish_constraint(
    context: &Context<'_>,
    state: &State,
    residual: &mut [f64],
    work: &mut Workspace,
) {
    residual.iter_mut().for_each(|value| *value = -*value);
    let block = context.prepared.pressure.as_ref();
    if let Some(stabilisation) = block.and_then(|block| block.stabilisation.as_ref()) {
        let mut product = work.scratch(residual.len());
        stabilisation.apply(&state.pressure, &mut product, work);
        add_scaled(residual, 1.0, &product);
        work.give(product);
    }
}

fn add_contact(context: &Context<'_>, state: &State, drive: &Drive, out: &mut Evaluation) {
    let body = context.deformed(&state.displacement);
    let obstacles = context
        .interfaces
        .obstacles(drive, context.plan.units.length);
    let mut builder = SparseRowsBuilder::new(state.displacement.len());
    for (interface, obstacle) in context.interfaces.list.iter().zip(&obstacles) {
        let held = &context.prepared.is_held;
        let mut part = linearise(&body, &interface.surface, obstacle, held);
        out.gap.append(&mut part.gap);
        out.max_penetration = out.max_penetration.max(part.max_penetration);
        part.rows.iter_mut().for_each(|row| builder.push_row(row));
    }
    if !context.relief.is_empty() {
        add_scaled(&mut out.gap, 1.0, context.relief);
    }
    out.coupling = builder.finish();
}

impl Evaluation {
    /// Norm of what is wrong with the gaps: negative, or open under pressure.
    pub(crate) fn gap_norm(&self, active: &[bool]) -> f64 {
        let wrong = |(gap, &active): (&f64, &bool)| if active { *gap } else { gap.min(0.0) };
        let square: f64 = self.gap.iter().zip(active).map(wrong).map(|g| g * g).sum();
        square.sqrt()
    }

    /// Scale of the force residual: the largest load at hand. A prescribed
    /// motion loads the body by its reactions.
    pub(crate) fn force_scale(&self, first: f64) -> f64 {
        self.load_norm
            .max(self.contact_norm)
            .max(self.reaction_norm)
            .max(first)
    }

    /// The four criteria.
    pub(crate) fn residuals(
        &self,
        state: &State,
        first_force: f64,
        scales: &QpScales,
    ) -> Residuals {
        let pressure_norm = norm(&state.multiplier);
        let products = self
            .gap
            .iter()
            .zip(&state.multiplier)
            .map(|(g, l)| (g * l).abs());
        let negative = state
            .multiplier
            .iter()
            .map(|l| l.min(0.0))
            .collect::<Vec<_>>();
        Residuals {
            equilibrium: ratio(norm(&self.force), self.force_scale(first_force)),
            incompressibility: ratio(norm(&self.constraint), scales.constraint),
            complementarity: ratio(products.sum(), pressure_norm * scales.gap)
                + ratio(dot(&negative, &negative).sqrt(), pressure_norm),
            gap: ratio(self.gap_norm(&state.active), scales.gap),
        }
    }
}

/// value / scale, zero when there is nothing to scale.
pub(crate) fn ratio(value: f64, scale: f64) -> f64 {
    if value == 0.0 {
        0.0
    } else {
        value / scale.max(f64::MIN_POSITIVE)
    }
}
