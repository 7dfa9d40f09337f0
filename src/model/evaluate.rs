//! Residuals of the nonlinear problem at a state, and the four criteria:
//!
//! ```text
//! f - A u - B^T p - C(u)^T l,   -(B u - S p),   g(u),   l g(u)
//! ```
//!
//! Non-dimensional, hierarchical; held rows are zero. Cost: one product with the
//! operator and the contact integrals.

use super::Model;
use super::counters::timed;
use super::drive::Drive;
use super::fluids::add_fluids;
use super::friction::Law;
use super::given_loads::dead_load;
use super::held::{mask, norm_of};
use super::interfaces::Interface;
use super::internal::internal;
use super::joined::Joined;
use super::pressures::add_pressures;
use super::state::State;
use crate::contact::Linearisation;
use crate::inequality::QpScales;
use crate::linalg::vector::{add_scaled, dot, norm, ratio};
use crate::linalg::{LinearOperator, SparseRows, Workspace};
use crate::report::{Residuals, Seconds};
use crate::saddle::{AdmissibleSet, Cones, ProductSet, SetPart, SetPoint};
use std::ops::Range;
use std::sync::Arc;

/// Share of the forces below which contact carries nothing.
const LEAST_CONTACT: f64 = 1e-6;

/// Residuals at a state.
#[derive(Clone, Debug, Default)]
pub(crate) struct Evaluation {
    /// Free rows of f - A u - B^T p - C^T l `[displacement]`, non-dimensional; held
    /// rows are zero.
    pub(crate) force: Vec<f64>,
    /// Residual of the volume constraint, -(B u - S p) `[pressures]`, non-dimensional.
    pub(crate) constraint: Vec<f64>,
    /// Weighted gap `[multipliers]`, length^dimension of the scaled body; those of
    /// guides besides.
    pub(crate) gap: Vec<f64>,
    /// C = -dg/du on free columns `[multipliers, displacement]`.
    pub(crate) coupling: SparseRows,
    /// Where the multipliers may be, part by part in their order.
    pub(crate) sets: Vec<SetPart<'static>>,
    /// Bounds of the tractions of friction; none without.
    pub(crate) friction: Option<Law>,
    /// Norm of the external load on free rows, non-dimensional.
    pub(crate) load_norm: f64,
    /// Norm of the contact load on free rows, non-dimensional.
    pub(crate) contact_norm: f64,
    /// Norm of the reactions, where supports prescribe a motion.
    pub(crate) reaction_norm: f64,
    /// Deepest penetration at a point of the rule, in units of the scaled body.
    pub(crate) max_penetration: f64,
    /// Least J at the points of the rule; none for linear bodies.
    pub(crate) least_jacobian: Option<f64>,
    /// How tools have moved on that the body has not followed yet; none once it has.
    pub(crate) advance: Option<Arc<Advance>>,
}

/// The last motion of tools, which the next step takes off the distances.
#[derive(Clone, Debug)]
pub(crate) struct Advance {
    /// The drive from which tools have moved on.
    pub(crate) last: Drive,
    /// What the motion makes of the pressures' force by the change of the area, taken off
    /// `[displacement]`: only the whole curvature of the gaps compensates it.
    pub(crate) force: Vec<f64>,
}

/// Residuals of `state` under its drive. Gaps are booked as contact, the body as
/// assembly.
pub(crate) fn evaluate(
    model: &Model<'_>,
    state: &State,
    seconds: &mut Seconds,
    work: &mut Workspace,
) -> Evaluation {
    let mut out = Evaluation::default();
    timed(&mut seconds.contact, || {
        add_contact(model, state, None, &mut out);
    });
    timed(&mut seconds.assemble, || {
        add_body(model, state, &mut out, work);
    });
    out
}

/// Gaps and coupling at a state.
pub(crate) fn evaluate_contact(model: &Model<'_>, state: &State) -> Evaluation {
    let mut out = Evaluation::default();
    add_contact(model, state, None, &mut out);
    out
}

/// Residuals of a state without contact pressure, gaps left out.
pub(crate) fn evaluate_body(model: &Model<'_>, state: &State, work: &mut Workspace) -> Evaluation {
    let mut out = Evaluation {
        coupling: SparseRows::default(),
        ..Evaluation::default()
    };
    add_body(model, state, &mut out, work);
    out
}

/// Terms of the residuals.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Terms {
    /// Forces and volumes of the body itself.
    Body,
    /// Gaps, slips and contact pressures.
    Contact,
    /// Dead loads and pressures that follow the body.
    Loads,
    /// All of them.
    All,
}

/// Residuals of `terms` alone, zero what is of others; norms are left out but with all.
pub(crate) fn evaluate_terms(
    (model, state): (&Model<'_>, &State),
    terms: Terms,
    work: &mut Workspace,
) -> Evaluation {
    let mut out = Evaluation {
        force: vec![0.0; state.displacement.len()],
        constraint: vec![0.0; state.pressure.len()],
        gap: vec![0.0; state.multiplier.len()],
        ..Evaluation::default()
    };
    match terms {
        Terms::All => return evaluate(model, state, &mut Seconds::default(), work),
        Terms::Body => {
            let inside = internal(model, state, work);
            add_scaled(&mut out.force, -1.0, &inside.force);
            out.constraint = inside.constraint;
        }
        Terms::Contact => {
            add_contact(model, state, None, &mut out);
            let columns = &out.coupling;
            columns.add_transposed(-1.0, &state.multiplier, &mut out.force, work);
        }
        Terms::Loads => out.force = external_force(model, state),
    }
    mask(&model.prepared.held, &mut out.force);
    out
}

/// Adds the residuals of force and volume to gaps and coupling.
fn add_body(model: &Model<'_>, state: &State, out: &mut Evaluation, work: &mut Workspace) {
    let held = &model.prepared.held;
    let mut force = external_force(model, state);
    mask(held, &mut force);
    out.load_norm = norm(&force);
    let inside = internal(model, state, work);
    add_scaled(&mut force, -1.0, &inside.force);
    if out.coupling.rows() > 0 {
        let mut contact = work.scratch(force.len());
        out.coupling
            .apply_transposed(&state.multiplier, &mut contact, work);
        out.contact_norm = norm(&contact);
        add_scaled(&mut force, -1.0, &contact);
        work.give(contact);
    }
    if let Some(proximal) = &model.conditions.proximal {
        proximal.add_force(&state.displacement, &mut force);
    }
    if state.drive.moves_supports() {
        out.reaction_norm = norm_of(held, &force);
    }
    mask(held, &mut force);
    out.force = force;
    out.constraint = inside.constraint;
    out.least_jacobian = inside.response.map(|response| response.least_jacobian);
}

/// Norm of the external load on free rows, non-dimensional.
pub(crate) fn load_norm(model: &Model<'_>, state: &State) -> f64 {
    let mut force = external_force(model, state);
    mask(&model.prepared.held, &mut force);
    norm(&force)
}

/// Dead loads and follower pressures at the state's load factor, and fluids, all rows `[displacement]`.
pub(crate) fn external_force(model: &Model<'_>, state: &State) -> Vec<f64> {
    let load = state.drive.load;
    let mut force = dead_load(model, &state.drive).into_owned();
    force.iter_mut().for_each(|value| *value *= load);
    add_pressures(model, &state.displacement, load, &mut force);
    add_fluids(model, state, &mut force);
    force
}

/// Gap and coupling of every surface, in the order of the multipliers; of tools that have moved on
/// from `last` where there is one.
fn linearised<'a>(
    model: &Model<'a>,
    state: &State,
    last: Option<&Drive>,
) -> Vec<(&'a Interface, Linearisation)> {
    let body = model.deformed(&state.displacement);
    let held = &model.prepared.is_held;
    let Some(last) = last else {
        let placed = model.placed(&state.drive);
        let parts = placed.map(|(one, met)| (one, met.linearise(&body, &one.surface, held)));
        return parts.collect();
    };
    let placed = model.placed_from(state, last).into_iter();
    let parts = placed.map(|(one, now, before)| {
        let at = (&body, &one.surface);
        (one, now.linearise_from(before.as_ref(), at, held))
    });
    parts.collect()
}

/// Adds weighted gaps and their coupling.
fn add_contact(model: &Model<'_>, state: &State, last: Option<&Drive>, out: &mut Evaluation) {
    let mut joined = Joined::new(state.multiplier.len());
    out.sets.clone_from(&model.interfaces.sets);
    for (interface, mut part) in linearised(model, state, last) {
        for &multiplier in &interface.idle {
            part.gap[multiplier as usize] = 0.0;
            part.rows[multiplier as usize].clear();
        }
        if interface.is_contact() {
            out.max_penetration = out.max_penetration.max(part.max_penetration);
        }
        joined.add(interface, part);
    }
    if let Some(friction) = &model.interfaces.friction {
        joined.add_friction(
            friction,
            friction.linearised(model, state, &model.prepared.is_held),
        );
        out.friction = Some(friction.law(model.plan, &state.drive));
    }
    let (gap, coupling) = joined.finish(state.displacement.len());
    (out.gap, out.coupling) = (gap, model.prepared.held.project_columns(coupling));
}

impl Evaluation {
    /// Takes the coupling that a step from `state` sees, whose tools have moved on from `last` and
    /// whose body has not ([`crate::contact::linearise_advanced`]).
    pub(crate) fn advance_from(
        &mut self,
        last: Drive,
        (model, state): (&Model<'_>, &State),
        work: &mut Workspace,
    ) {
        let mut out = Self::default();
        add_contact(model, state, Some(&last), &mut out);
        let mut force = vec![0.0; self.force.len()];
        let mut limited = work.zeros(force.len());
        self.coupling
            .apply_transposed(&state.multiplier, &mut force, work);
        out.coupling
            .apply_transposed(&state.multiplier, &mut limited, work);
        add_scaled(&mut force, -1.0, &limited);
        work.give(limited);
        mask(&model.prepared.held, &mut force);
        self.coupling = out.coupling;
        self.advance = Some(Arc::new(Advance { last, force }));
    }

    /// The drive from which tools have moved on and the body has not; none once it has.
    pub(crate) fn last_drive(&self) -> Option<&Drive> {
        self.advance.as_ref().map(|advance| &advance.last)
    }

    /// Norm of what is wrong with the gaps: negative, or open under pressure.
    pub(crate) fn gap_norm(&self, state: &State) -> f64 {
        let wrong = self.contact_set().misfit(SetPoint {
            multiplier: &state.multiplier,
            residual: &self.gap,
            status: &state.status,
        });
        let square: f64 = wrong.iter().map(|g| g * g).sum();
        square.sqrt()
    }

    /// Where the contact pressures may be.
    pub(crate) fn contact_set(&self) -> ProductSet<'_> {
        let Some(law) = &self.friction else {
            return ProductSet::Parts(&self.sets);
        };
        let cones = Cones {
            normals: law.normals,
            partners: &law.partners,
            bounds: &law.bounds,
            components: law.components,
        };
        let frictional = law.normals + law.tractions();
        ProductSet::Pair([
            SetPart {
                size: frictional,
                set: AdmissibleSet::Cones(cones),
            },
            SetPart {
                size: self.gap.len() - frictional,
                set: AdmissibleSet::Free,
            },
        ])
    }

    /// Which multipliers are tractions of friction.
    fn tractions(&self) -> Range<usize> {
        let law = self.friction.as_ref();
        law.map_or(0..0, |law| law.normals..law.normals + law.tractions())
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
        let scale = self.force_scale(first_force);
        let pressure_scale = pressure_scale(norm(&state.multiplier), self.contact_norm, scale);
        // Slip under traction is what friction is.
        let tractions = self.tractions();
        let pairs = self.gap.iter().zip(&state.multiplier).enumerate();
        let products = pairs
            .filter(|(index, _)| !tractions.contains(index))
            .map(|(_, (g, l))| (g * l).abs());
        let negative = self.contact_set().violation(&state.multiplier);
        Residuals {
            equilibrium: ratio(norm(&self.force), scale),
            incompressibility: ratio(norm(&self.constraint), scales.constraint),
            complementarity: ratio(products.sum(), pressure_scale * scales.gap)
                + ratio(dot(&negative, &negative).sqrt(), pressure_scale),
            gap: ratio(self.gap_norm(state), scales.gap),
        }
    }
}

/// What complementarity is measured by: the norm of the pressures, unless all that contact
/// carries is nothing beside the forces at hand, as where a tool has come back to just touch
/// and the sign of a pressure is noise; then what would carry those forces.
pub(crate) fn pressure_scale(pressure_norm: f64, contact_norm: f64, force_scale: f64) -> f64 {
    let carries = contact_norm >= LEAST_CONTACT * force_scale;
    if carries || contact_norm == 0.0 {
        pressure_norm
    } else {
        pressure_norm * (force_scale / contact_norm)
    }
}
