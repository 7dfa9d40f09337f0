//! A goal whose poses q follow from pushes F = T. The pushes are met on every mesh, so that its
//! error is that of a goal at fixed poses,
//!
//! ```text
//! J - sum of a_c F_c,   y - sum of a_c y_c,   a = (dJ/dq) (dF/dq)^-1
//! ```
//!
//! which no pose changes: what the mesh makes of the forces moves the tools. A force that is itself
//! a push has no error. Non-dimensional but for what is said to be in the caller's units.

use super::dual::Dual;
use super::resolved::ResolvedGoal;
use crate::linalg::vector::add_scaled;
use crate::model::Model;
use crate::model::evaluate::Evaluation;
use crate::model::interfaces::Interface;
use crate::model::state::State;
use crate::results::geometry_error::largest_sagitta;
use crate::sqp::fields::Fields;

/// A goal freed of the poses that follow.
pub(super) struct Freed<'a> {
    /// y less those of the pushes.
    pub(super) fields: Fields,
    /// The goal and the pushes with their factors.
    parts: Vec<(f64, &'a Dual)>,
}

impl<'a> Freed<'a> {
    /// Of a goal and what it has of each push, a in the caller's units.
    pub(super) fn new(dual: &'a Dual, pushed: &'a [Dual], shares: &[f64]) -> Self {
        let mut parts = vec![(1.0, dual)];
        for (one, share) in pushed.iter().zip(shares) {
            let factor = -share * one.goal.unit() / dual.goal.unit();
            if one.name == dual.name {
                parts[0].0 += factor;
            } else {
                parts.push((factor, one));
            }
        }
        let mut fields = dual.fields.clone();
        let scaled = |own: &mut Vec<f64>| own.iter_mut().for_each(|value| *value *= parts[0].0);
        [
            &mut fields.displacement,
            &mut fields.pressure,
            &mut fields.multiplier,
        ]
        .into_iter()
        .for_each(scaled);
        for (factor, one) in &parts[1..] {
            add_scaled(&mut fields.displacement, *factor, &one.fields.displacement);
            add_scaled(&mut fields.pressure, *factor, &one.fields.pressure);
            add_scaled(&mut fields.multiplier, *factor, &one.fields.multiplier);
        }
        Self { fields, parts }
    }

    fn goal(&self) -> &'a ResolvedGoal {
        &self.parts[0].1.goal
    }

    /// What brings values to the caller's units.
    pub(super) fn unit(&self) -> f64 {
        self.goal().unit()
    }

    /// Whether the goal is the energy of the body.
    pub(super) fn is_energy(&self) -> bool {
        self.goal().is_energy()
    }

    /// y . R.
    pub(super) fn work(&self, state: &State, now: &Evaluation) -> f64 {
        let parts = self.parts.iter();
        parts
            .map(|(factor, one)| factor * one.work(state, now))
            .sum()
    }

    /// What of y is smooth where the exact one is, with the same error.
    pub(super) fn smooth(&self, model: &Model<'_>) -> Vec<f64> {
        let mut smooth = self.fields.displacement.clone();
        for (factor, one) in &self.parts {
            one.goal.add_support_motion(model, -factor, &mut smooth);
        }
        smooth
    }

    /// y less what the obstacle of that number holds it to, from its `smooth` part: its normal part
    /// is zero on closed contact.
    pub(super) fn relative(
        &self,
        (model, state): (&Model<'_>, &State),
        (obstacle, smooth): (usize, &[f64]),
    ) -> Vec<f64> {
        let mut relative = smooth.to_vec();
        for (factor, one) in &self.parts {
            let of = (obstacle, *factor);
            one.goal.add_motion_of((model, state), of, &mut relative);
        }
        relative
    }

    /// What flat facets in the place of curved surfaces make of the goal, in the caller's units: of forces
    /// their part of how far contact is pushed, of others the gaps that they are off by times what these do,
    ///
    /// ```text
    /// sum of |m_j| w_j s,   m = dJ/dG, w the area of the function, s the sagitta
    /// ```
    pub(super) fn geometry(&self, model: &Model<'_>, state: &State) -> f64 {
        if !self.goal().is_of_obstacle() {
            return self.unit() * self.by_gaps(model, state);
        }
        let one = |(factor, one): &(f64, &Dual)| {
            let unit = self.unit() / one.goal.unit();
            factor.abs() * unit * one.goal.geometry(model, state)
        };
        self.parts.iter().map(one).sum()
    }

    fn by_gaps(&self, model: &Model<'_>, state: &State) -> f64 {
        let contacts = model.interfaces.list.iter().filter(|one| one.is_contact());
        let of_one = |interface: &Interface| {
            let dual = interface.own(&self.fields.multiplier);
            let terms = dual.iter().zip(&interface.surface.weights);
            let sum: f64 = terms.map(|(m, weight)| m.abs() * weight).sum();
            sum * largest_sagitta(model, state, interface)
        };
        contacts.map(of_one).sum()
    }
}
