//! Whether an increment asks a body that keeps its volume for another one: supports and obstacles
//! are on all its sides, and obstacles at the goal take more room than the body leaves them,
//!
//! ```text
//! sum over faces of int d(x + u) dS < 0,   d the distance from the obstacle at the goal
//! ```
//!
//! u is the last good displacement, areas those of the undeformed body: what overlaps has to
//! outweigh what is open by a share. Cost: the gaps of all faces, once a failure.

use super::run::Run;
use crate::assembly::load::facet_measure;
use crate::contact::ContactSurface;
use crate::contact::gap::evaluate_gaps;
use crate::linalg::vector::dot;
use crate::linalg::{LinearOperator, Workspace};
use crate::model::Model;
use crate::model::drive::Drive;
use crate::model::state::State;
use crate::obstacle::{Contact, Obstacle, What};

/// Share of what overlaps and is open by which one has to exceed the other: areas are those of
/// the undeformed body.
const UNEVEN: f64 = 0.2;
/// Cosine of the angle up to which an obstacle is in front of a face.
const FACING: f64 = 0.5;
/// Share of a constant pressure's forces that is rounding.
const CLOSED: f64 = 1e-6;

/// Whether no side of a body that keeps its volume is free, and obstacles at `goal` face all that
/// they may touch and overlap it, as it is, by more than they leave open.
pub(crate) fn is_full(run: &Run<'_>, goal: &Drive) -> bool {
    let model = &run.model;
    if !is_covered(model) {
        return false;
    }
    let body = model.deformed(&run.state.displacement);
    let contacts = model.placed(goal);
    let contacts = contacts.filter(|(interface, _)| interface.is_contact());
    let (mut net, mut all) = (0.0, 0.0);
    for (interface, met) in contacts {
        let Some(obstacle) = met.obstacle() else {
            return false;
        };
        if !faces_all(model, (run.state, &interface.surface), obstacle) {
            return false;
        }
        let (gaps, _) = evaluate_gaps(&body, &interface.surface, &met);
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
    let (c, scale) = (
        model.prepared.space.components,
        model.plan.units.coordinate_scale,
    );
    surface.faces.iter().all(|face| {
        let mut middle = [0.0; 3];
        for &corner in &face.corners {
            let at = model.mesh.coordinates()[corner as usize];
            let moved = &state.displacement[corner as usize * c..][..c];
            for (i, sum) in middle.iter_mut().enumerate() {
                let place = scale * at[i] + moved.get(i).unwrap_or(&0.0);
                *sum += place / face.corners.len() as f64;
            }
        }
        let mut met = [Contact::default()];
        obstacle.probe(&[middle], What::Normal, &mut met);
        let (_, outwards) = facet_measure(model.mesh, &face.corners, 1.0);
        dot(&met[0].normal, &outwards) < -FACING
    })
}

/// Whether a body that keeps its volume has no face but those that supports hold along the
/// normal and those of one obstacle each.
fn is_covered(model: &Model<'_>) -> bool {
    let fixed = model.prepared.pressure.as_ref();
    let Some(block) = fixed.filter(|block| block.stabilisation.is_none()) else {
        return false;
    };
    let c = model.prepared.space.components;
    let mut pushed = vec![0.0; block.coupling.size];
    let ones = vec![1.0; block.coupling.vertices];
    let mut work = Workspace::new();
    block
        .coupling
        .apply_transposed(&ones, &mut pushed, &mut work);
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
