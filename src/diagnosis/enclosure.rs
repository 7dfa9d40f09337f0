//! Whether an increment asks a body that keeps its volume for another one: supports and obstacles
//! are on all its sides, and obstacles at the goal take more room than the body leaves them,
//!
//! ```text
//! sum over faces of int d(x + u) dS < 0,   d the distance from the obstacle at the goal
//! ```
//!
//! u is the last good displacement, areas those of the contact of the body: what overlaps has to
//! outweigh what is open by a share. Cost: the gaps of all faces, once a failure.

use crate::assembly::load::facet_measure;
use crate::contact::ContactSurface;
use crate::linalg::vector::{add_scaled, dot};
use crate::linalg::{LinearOperator, Workspace};
use crate::model::Model;
use crate::model::drive::Drive;
use crate::model::state::State;
use crate::obstacle::{Contact, Derivatives, Obstacle};

constants! {
    /// Share of what overlaps and is open by which one has to exceed the other: what is left of the
    /// volumes by faces that are not flat.
    const UNEVEN: f64 = 0.02;
    /// Cosine of the angle up to which an obstacle is in front of a face.
    const FACING: f64 = 0.5;
    /// Share of a constant pressure's forces that is rounding.
    const CLOSED: f64 = 1e-6;
}

/// Whether no side of a body that keeps its volume is free, and obstacles at `goal` face all that
/// they may touch and overlap it, as `state` has it, by more than they leave open.
pub(crate) fn is_full(model: &Model<'_>, state: &State, goal: &Drive) -> bool {
    if !is_covered(model) {
        return false;
    }
    let body = model.deformed(&state.displacement);
    let contacts = model.placed(goal);
    let contacts = contacts.filter(|(interface, _)| interface.is_contact());
    let (mut net, mut all) = (0.0, 0.0);
    for (interface, met) in contacts {
        let Some(obstacle) = met.obstacle() else {
            return false;
        };
        if !faces_all(model, (state, &interface.surface), obstacle) {
            return false;
        }
        let (gaps, _) = met.gaps(&body, &interface.surface);
        net += gaps.iter().sum::<f64>();
        all += gaps.iter().map(|gap| gap.abs()).sum::<f64>();
    }
    net < -UNEVEN * all
}

/// Whether an obstacle is in front of every face of `surface`: beside it a body gives way.
fn faces_all(
    model: &Model<'_>,
    (state, surface): (&State, &ContactSurface),
    obstacle: &dyn Obstacle,
) -> bool {
    surface.faces.iter().all(|face| {
        let share = 1.0 / face.corners.len() as f64;
        let mut middle = [0.0; 3];
        for &corner in &face.corners {
            let place = model.place(corner as usize, &state.displacement);
            add_scaled(&mut middle, share, &place);
        }
        let mut met = [Contact::default()];
        obstacle.probe(&[middle], Derivatives::Normal, &mut met);
        let (_, outwards) = facet_measure(model.mesh, &face.corners, 1.0);
        dot(&met[0].normal, &outwards) < -FACING
    })
}

/// Whether a body that keeps its volume has no face but those that supports hold along the
/// normal and those of one obstacle each.
fn is_covered(model: &Model<'_>) -> bool {
    let Some(mut pushed) = constant_pressure_force(model, &mut Workspace::new()) else {
        return false;
    };
    let c = model.prepared.space.components;
    let largest = pushed.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    let interfaces = model.interfaces.list.iter();
    let mut facets: Vec<u32> = Vec::new();
    for interface in interfaces {
        facets.extend(&interface.facets);
        for face in &interface.surface.faces {
            for &node in &face.nodes {
                let first = node as usize * c;
                pushed[first..first + c].fill(0.0);
            }
        }
    }
    let count = facets.len();
    facets.sort_unstable();
    facets.dedup();
    let is_free = |x: &f64| x.abs() > CLOSED * largest;
    facets.len() == count && !pushed.iter().any(is_free)
}

/// B^T 1 at rest `[displacement]`: what a constant pressure pushes; none of a body that may
/// change its volume.
pub(super) fn constant_pressure_force(model: &Model<'_>, work: &mut Workspace) -> Option<Vec<f64>> {
    let fixed = model.prepared.pressure.as_ref();
    let block = fixed.filter(|block| block.stabilisation.is_none())?;
    let mut force = vec![0.0; block.coupling.size];
    let ones = vec![1.0; block.coupling.vertices];
    block.coupling.apply_transposed(&ones, &mut force, work);
    Some(force)
}
