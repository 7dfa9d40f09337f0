//! The body at a state: what drives it, its obstacles and loads, and the residuals
//!
//! ```text
//! f - A u - B^T p - C(u)^T l,   -(B u - S p),   g(u)
//! ```
//!
//! Everything is non-dimensional inside but for [`drive`], which speaks the caller's
//! units. Nothing here solves anything.

pub(crate) mod carry;
pub(crate) mod conditions;
pub(crate) mod contact_moduli;
pub(crate) mod counters;
pub(crate) mod drive;
pub(crate) mod ending;
pub(crate) mod energy;
pub(crate) mod evaluate;
pub(crate) mod fluid_drive;
pub(crate) mod fluids;
pub(crate) mod friction;
pub(crate) mod given;
pub(crate) mod given_loads;
pub(crate) mod held;
pub(crate) mod inside_out;
pub(crate) mod interfaces;
pub(crate) mod internal;
pub(crate) mod joined;
pub(crate) mod lending;
pub(crate) mod loads;
pub(crate) mod mean_pressure;
pub(crate) mod nodal_contact;
pub(crate) mod open_gap;
pub(crate) mod placed;
pub(crate) mod prescribed;
pub(crate) mod pressures;
pub(crate) mod proximal;
pub(crate) mod push;
pub(crate) mod remainder;
pub(crate) mod state;
pub(crate) mod surface_metric;
pub(crate) mod tangent;
pub(crate) mod travel;
pub(crate) mod values;

use std::sync::Arc;

use crate::contact::Measure;
use crate::contact::gap::Deformed;
use crate::mesh::Mesh;
use crate::plan::Plan;
use crate::prepare::TaylorHoodData;
use conditions::Conditions;
use drive::Drive;
use interfaces::{Interface, Interfaces};
use placed::Placed;
use state::State;

/// The body on its obstacles, as everything reads it that solves for a state or
/// reports one. Cheap to clone.
#[derive(Clone)]
pub(crate) struct Model<'a> {
    /// Decisions, resolved names and units of the scene.
    pub(crate) plan: &'a Plan,
    /// The checked mesh of the plan, undeformed.
    pub(crate) mesh: &'a Mesh,
    /// Operators and approximate inverses at rest, shared by all sessions.
    pub(crate) prepared: &'a TaylorHoodData,
    /// Surfaces with multipliers, and the obstacles or supports that they meet.
    pub(crate) interfaces: &'a Interfaces,
    /// Dead load at load factor one `[displacement unknowns]`.
    pub(crate) load: &'a [f64],
    /// What an equilibrium shall meet.
    pub(crate) conditions: Conditions,
}

impl<'a> Model<'a> {
    /// Whether one quadratic program solves an increment: a linear body whose gaps are
    /// linear too.
    pub(crate) fn is_linear(&self) -> bool {
        !self.is_rubber() && self.interfaces.are_flat()
    }

    /// Whether the body is of finite strain.
    pub(crate) fn is_rubber(&self) -> bool {
        self.prepared.strain.is_some()
    }

    /// The body deformed by `displacement` `[displacement unknowns]`, for contact
    /// integrals.
    pub(crate) fn deformed<'b>(&self, displacement: &'b [f64]) -> Deformed<'b>
    where
        'a: 'b,
    {
        Deformed {
            mesh: self.mesh,
            scale: self.plan.problem.units.coordinate_scale,
            space: &self.prepared.space,
            displacement,
            rule: &self.interfaces.rule,
            measure: if self.is_rubber() {
                Measure::Deformed
            } else {
                Measure::Undeformed
            },
        }
    }

    /// Place of a vertex displaced by `displacement` `[displacement unknowns]`, hierarchical: of
    /// an edge that of its middle less the mean of its ends.
    pub(crate) fn place(&self, node: usize, displacement: &[f64]) -> [f64; 3] {
        self.deformed(displacement).place(node)
    }

    /// The interfaces of frictional obstacles with the numbers of these, in the order of the
    /// points of friction.
    pub(crate) fn frictional(&self) -> impl Iterator<Item = (usize, &'a Interface)> {
        let obstacles = self
            .plan
            .problem
            .obstacles
            .iter()
            .zip(&self.interfaces.list);
        let frictional = obstacles
            .enumerate()
            .filter(|(_, (one, _))| one.is_frictional);
        frictional.map(|(index, (_, interface))| (index, interface))
    }

    /// The interfaces of frictional contacts between bodies, in the order of their points.
    pub(crate) fn frictional_pairs(&self) -> impl Iterator<Item = &'a Interface> {
        let problem = &self.plan.problem;
        let list = self.interfaces.list.iter().skip(problem.obstacles.len());
        let rough = list
            .zip(&problem.pairs)
            .filter(|(_, pair)| pair.is_frictional());
        rough.map(|(interface, _)| interface)
    }

    /// Every surface with what it meets now, and what it met at `last`, from where tools have moved
    /// on; none of the latter where nothing presses on the body.
    pub(crate) fn placed_from(
        &self,
        state: &State,
        last: &Drive,
    ) -> Vec<(&'a Interface, Placed, Option<Placed>)> {
        let is_pressed = state.multiplier.iter().any(|&l| l != 0.0);
        let both = self.placed(&state.drive);
        let both = both.zip(self.placed_inside(last, &self.conditions.admitted_penetration[0]));
        both.map(|((interface, now), (_, before))| (interface, now, is_pressed.then_some(before)))
            .collect()
    }

    /// Every surface with what it meets where `drive` has it, in the order of the
    /// multipliers.
    pub(crate) fn placed(&self, drive: &Drive) -> impl Iterator<Item = (&'a Interface, Placed)> {
        self.placed_inside(drive, &self.conditions.admitted_penetration[1])
    }

    /// The same where the body is let in by those depths `[multipliers]`.
    fn placed_inside(
        &self,
        drive: &Drive,
        depths: &Arc<[f64]>,
    ) -> impl Iterator<Item = (&'a Interface, Placed)> {
        let depths = depths.clone();
        let rule = &self.interfaces.rule;
        let placed = self
            .interfaces
            .placed(drive, self.plan.problem.units.length);
        placed.map(move |(interface, met)| {
            if depths.is_empty() {
                (interface, met)
            } else {
                let own = interface.own(&depths);
                (interface, met.admitting(&interface.surface, rule, &own))
            }
        })
    }
}
