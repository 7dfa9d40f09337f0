//! Values of other codes that drive a body: over supports, over tractions, over the body.
//!
//! Part of a drive: they ramp from the end of one step to that of the next as all of it does.
//! A list is empty where nothing is given; what a list lacks is zero. Units are the caller's.

use crate::mesh::Mesh;
use crate::plan::Plan;
use crate::scene::Step;
use crate::scene::validate::{Faults, Ground, Spread, resolve_values};

/// Values by support, by traction and over the body.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Given {
    /// Displacement, length, in the order of the supports.
    pub(crate) supports: Vec<Spread>,
    /// Stress at load factor one, in the order of the tractions.
    pub(crate) tractions: Vec<Spread>,
    /// Force per volume at load factor one; none or one.
    pub(crate) body_force: Vec<Spread>,
}

impl Given {
    /// Those of the scene.
    pub(crate) fn of_scene(plan: &Plan) -> Self {
        let resolved = &plan.problem.resolved;
        let body = std::iter::once(&resolved.body_force_values);
        Self {
            supports: unless_none(resolved.supports.iter().map(|one| &one.values)),
            tractions: unless_none(resolved.tractions.iter().map(|one| &one.values)),
            body_force: unless_none(body),
        }
    }

    /// With those that a step names, which has been checked.
    pub(crate) fn after(&self, (plan, mesh): (&Plan, &Mesh), step: &Step) -> Self {
        let mut next = self.clone();
        let resolved = &plan.problem.resolved;
        // Faults have been told when the step was checked.
        let mut told = Faults::default();
        let mut spread = |values, ground| resolve_values(values, (ground, mesh), "", &mut told);
        for target in &step.supports {
            let mut supports = resolved.supports.iter();
            let index = supports.position(|one| one.name == target.name);
            if let (Some(values), Some(index)) = (&target.values, index) {
                let facets = &resolved.supports[index].facets;
                *slot(&mut next.supports, index) = spread(values, Ground::Surface(facets));
            }
        }
        for target in &step.tractions {
            let mut tractions = resolved.tractions.iter();
            let index = tractions.position(|one| one.name.as_ref() == Some(&target.name));
            if let Some(index) = index {
                let facets = &resolved.tractions[index].facets;
                *slot(&mut next.tractions, index) = spread(&target.values, Ground::Facets(facets));
            }
        }
        if let Some(values) = &step.body_force {
            *slot(&mut next.body_force, 0) = spread(values, Ground::Body);
        }
        next
    }

    /// Whether no load is given.
    pub(crate) fn is_unloaded(&self) -> bool {
        let mut loads = self.tractions.iter().chain(&self.body_force);
        loads.all(Spread::is_zero)
    }

    /// Whether no displacement is given.
    pub(crate) fn is_at_rest(&self) -> bool {
        self.supports.iter().all(Spread::is_zero)
    }

    /// A fraction of the way to `end`. Loads whose factor is zero at one end have the values
    /// of the other all the way, so that their product is linear.
    pub(crate) fn towards(&self, end: &Self, fraction: f64, factors: [f64; 2]) -> Self {
        let loads = |own: &[Spread], end: &[Spread]| match factors {
            [0.0, _] => end.to_vec(),
            [_, 0.0] => own.to_vec(),
            _ => mixed(own, end, fraction),
        };
        Self {
            supports: mixed(&self.supports, &end.supports, fraction),
            tractions: loads(&self.tractions, &end.tractions),
            body_force: loads(&self.body_force, &end.body_force),
        }
    }

    /// Numbers of rows of all lists, one after the other.
    pub(crate) fn shape(&self) -> Vec<[usize; 2]> {
        self.spreads().map(Spread::shape).collect()
    }

    /// All values one after the other.
    pub(crate) fn numbers(&self) -> impl Iterator<Item = f64> + '_ {
        self.spreads().flat_map(Spread::numbers)
    }

    /// Bytes held.
    pub(crate) fn bytes(&self) -> u64 {
        self.spreads().map(Spread::bytes).sum()
    }

    fn spreads(&self) -> impl Iterator<Item = &Spread> {
        let loads = self.tractions.iter().chain(&self.body_force);
        self.supports.iter().chain(loads)
    }
}

/// The list, or none where all of it is without rows.
fn unless_none<'a>(spreads: impl Iterator<Item = &'a Spread>) -> Vec<Spread> {
    let all: Vec<Spread> = spreads.cloned().collect();
    if all.iter().all(|one| one.shape() == [0, 0]) {
        Vec::new()
    } else {
        all
    }
}

/// One of a list, which grows to have it.
fn slot(list: &mut Vec<Spread>, index: usize) -> &mut Spread {
    if list.len() <= index {
        list.resize(index + 1, Spread::default());
    }
    &mut list[index]
}

fn mixed(start: &[Spread], end: &[Spread], fraction: f64) -> Vec<Spread> {
    let none = Spread::default();
    let of = |list: &[Spread], index: usize| list.get(index).unwrap_or(&none).clone();
    let all = 0..start.len().max(end.len());
    all.map(|index| of(start, index).towards(&of(end, index), fraction))
        .collect()
}
