//! Where a tool that grips the body and is turned or led begins: free components follow so that it
//! slips least,
//!
//! ```text
//! min sum b_i^2 |s_i + (D_t z)_i|^2   over the points i that are closed
//! ```
//!
//! s the slips that its given motion makes, D_t those of its free components z, b the largest
//! tractions.
//!
//! A tool that begins by sliding is pulled at by friction alone, whose force no small motion
//! changes: a cylinder that rolls freely under friction 0.05 found no equilibrium. Components that
//! act along the normals more than across them stay, and no motion is longer than a step of the
//! search. Cost: two evaluations of the gaps.

use super::gap_changes::gap_changes;
use crate::linalg::vector::{add_scaled, dot};
use crate::model::drive::Drive;
use crate::model::evaluate::evaluate_contact;
use crate::model::push::Control;
use crate::model::state::State;
use crate::sqp::push_stiffness::PushStiffness;
use crate::sqp::run::Run;

/// The motion `[controls]` of obstacles on the way to `drive`, whose sought components have not
/// moved there; none where nothing that grips slips.
pub(super) fn least_slip(run: &Run<'_>, drive: &Drive, controls: &[Control]) -> Option<Vec<f64>> {
    let grip = Grip::at(run, drive)?;
    let moved = State {
        drive: drive.clone(),
        ..run.state.clone()
    };
    let [before, after] =
        [&*run.state, &moved].map(|state| evaluate_contact(&run.model, state).gap);
    let mut slips = grip.across(&after);
    add_scaled(&mut slips, -1.0, &grip.across(&before));
    if slips.iter().all(|&slip| slip == 0.0) {
        return None;
    }
    let changes = gap_changes(&run.model, run.state, controls);
    let columns = changes.iter().map(|change| grip.column(change));
    let columns: Vec<Vec<f64>> = columns.collect();
    let products = |other: &[f64]| columns.iter().map(|column| dot(column, other)).collect();
    // Solved like a stiffness: directions in which nothing slips are left out, and the motion is
    // no longer than a step.
    let normal_equations = PushStiffness {
        controls: controls.to_vec(),
        columns: columns.iter().map(|column| products(column)).collect(),
    };
    Some(normal_equations.solve(&products(&slips)).step)
}

/// The contacts that are closed.
struct Grip {
    /// Pressures.
    pressures: Vec<usize>,
    /// Tractions with their bounds.
    tractions: Vec<(usize, f64)>,
}

impl Grip {
    /// That of the present state, under the friction of `drive`; none without friction.
    fn at(run: &Run<'_>, drive: &Drive) -> Option<Self> {
        let friction = run.model.interfaces.friction.as_ref()?;
        let bounds = friction.law(run.model.plan, drive);
        let bounds = bounds.radii(&run.state.multiplier);
        let width = friction.components.count();
        let is_closed = |k: &usize| run.state.status[*k].is_closed();
        let tractions = friction.first..friction.first + friction.size();
        let tractions = tractions.filter(is_closed);
        Some(Self {
            pressures: (0..friction.first).filter(is_closed).collect(),
            tractions: tractions
                .map(|k| (k, bounds[(k - friction.first) / width]))
                .collect(),
        })
    }

    /// The slips among `all` `[multipliers]`, each times its bound.
    fn across(&self, all: &[f64]) -> Vec<f64> {
        let tractions = self.tractions.iter();
        tractions.map(|&(k, bound)| bound * all[k]).collect()
    }

    /// The change of the slips by a motion that changes all by `change` `[multipliers]`; zero
    /// where that acts along the normals more than across them.
    fn column(&self, change: &[f64]) -> Vec<f64> {
        let square = |k: usize| change[k] * change[k];
        let along: f64 = self.pressures.iter().map(|&k| square(k)).sum();
        let across: f64 = self.tractions.iter().map(|&(k, _)| square(k)).sum();
        if across > along {
            self.across(change)
        } else {
            vec![0.0; self.tractions.len()]
        }
    }
}
