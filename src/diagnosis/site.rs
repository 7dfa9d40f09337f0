//! Where an increment lost its equilibrium, for the people who look for the cause:
//!
//! | cause | point | motion |
//! |---|---|---|
//! | unstable equilibrium, limit point, step too small | moves most in the softest motion | its direction there |
//! | negative Jacobian | middle of the cell of least volume ratio | |
//! | inside out | least det F at the state that was refused | |
//! | no equilibrium | | sum of forces, less what pressure of the obstacles can take up |
//! | others, where the state is out of balance | vertex of the largest force out of balance | its direction |
//!
//! Read from the state that is kept. Cost: one evaluation at most.

use crate::contact::gap::mean_normals;
use crate::geometry::vector3::{add, dot, normalised, scale};
use crate::linalg::vector::norm;
use crate::model::Model;
use crate::model::drive::Drive;
use crate::model::ending::{Ending, Site};
use crate::model::state::State;
use crate::report::Cause;
use crate::results::finite_strain::volume_ratio;
use crate::sqp::run::Run;

constants! {
    /// Passes over the normals of all obstacles; each brings the sum nearer to its least.
    const MOST_SWEEPS: usize = 100;
    /// Sum of forces over their norm below which they are a couple, or rounding.
    const BALANCED: f64 = 1e-6;
}

/// Where the cause of `ending` lies on the way to `goal`; none where nothing is known.
pub(crate) fn locate(run: &mut Run<'_>, ending: &Ending, goal: &Drive) -> Option<Site> {
    match ending.cause? {
        Cause::UnstableEquilibrium | Cause::LimitPoint | Cause::StepTooSmall => of_mode(run),
        Cause::NegativeJacobian => of_cells(run),
        Cause::NoEquilibrium => of_sum(run, goal),
        // The place of an inside-out cell or a leak was found at the state that was refused.
        Cause::EnclosedVolume | Cause::NotFinite | Cause::InsideOut | Cause::Leaks => None,
        Cause::Stagnation
        | Cause::IterationLimit
        | Cause::ActiveSetCycle
        | Cause::LineSearch
        | Cause::IndefiniteTangent => of_forces(run, ending),
    }
}

/// Of the softest motion.
fn of_mode(run: &Run<'_>) -> Option<Site> {
    let mode = run.learned.lowest_mode.as_ref()?;
    of_motion(&run.model, &mode.motion)
}

/// The vertex where `motion` `[displacement]` is largest, and its direction there.
fn of_motion(model: &Model<'_>, motion: &[f64]) -> Option<Site> {
    let space = &model.prepared.space;
    let vertices = motion.chunks_exact(space.components).take(space.vertices);
    let lengths = vertices.map(norm).enumerate();
    let (vertex, length) = lengths.max_by(|a, b| a.1.total_cmp(&b.1))?;
    let own = &motion[vertex * space.components..][..space.components];
    (length > 0.0 && length.is_finite()).then(|| Site {
        point: Some(model.mesh.coordinates()[vertex]),
        motion: Some(direction(own, length)),
        ..Site::default()
    })
}

/// A vector over its length `[3]`.
fn direction(vector: &[f64], length: f64) -> [f64; 3] {
    let mut unit = [0.0; 3];
    unit.iter_mut()
        .zip(vector)
        .for_each(|(unit, x)| *unit = x / length);
    unit
}

/// Of the cell that has least of its volume left.
fn of_cells(run: &Run<'_>) -> Option<Site> {
    let model = &run.model;
    let ratio = |cell: usize| volume_ratio(model, run.state, cell);
    let cells = (0..model.mesh.cell_count()).map(|cell| (cell, ratio(cell)));
    let (cell, _) = cells.min_by(|a, b| a.1.total_cmp(&b.1))?;
    Some(Site {
        point: Some(middle(model, model.mesh.cell(cell))),
        ..Site::default()
    })
}

/// Middle of some vertices, in the mesh's lengths.
fn middle(model: &Model<'_>, vertices: &[u32]) -> [f64; 3] {
    let mut middle = [0.0; 3];
    for &vertex in vertices {
        let point = model.mesh.coordinates()[vertex as usize];
        let terms = middle.iter_mut().zip(point);
        terms.for_each(|(sum, x)| *sum += x / vertices.len() as f64);
    }
    middle
}

/// Of the forces that are out of balance at the goal, summed: hats of vertices sum to one.
fn of_sum(run: &mut Run<'_>, goal: &Drive) -> Option<Site> {
    let kept = std::mem::replace(&mut run.state.drive, goal.clone());
    let force = run.evaluate().force;
    run.state.drive = kept;
    let space = &run.model.prepared.space;
    let mut sum = [0.0; 3];
    for vertex in force.chunks_exact(space.components).take(space.vertices) {
        sum.iter_mut().zip(vertex).for_each(|(sum, x)| *sum += x);
    }
    if !run.model.plan.has_friction() {
        sum = not_taken_up(&run.model, run.state, sum);
    }
    let length = norm(&sum);
    (length > BALANCED * norm(&force) && length.is_finite()).then(|| Site {
        motion: Some(direction(&sum, length)),
        ..Site::default()
    })
}

/// What of a force on the body no pressure of obstacles can balance, wherever these are beside
/// it now: the least sum of it and of multiples, at least zero, of their normals. The force
/// itself where it is a moment that nothing balances.
fn not_taken_up(model: &Model<'_>, state: &State, force: [f64; 3]) -> [f64; 3] {
    let body = model.deformed(&state.displacement);
    let contacts = model
        .placed(&state.drive)
        .filter(|(_, met)| met.obstacle().is_some());
    let normals = contacts.flat_map(|(one, met)| mean_normals(&body, &one.surface, &met));
    let normals: Vec<[f64; 3]> = normals.filter_map(normalised).collect();
    let mut pressures = vec![0.0; normals.len()];
    let mut left = force;
    // One after the other: each takes up what it can of what is left.
    for _ in 0..MOST_SWEEPS {
        for (pressure, &normal) in pressures.iter_mut().zip(&normals) {
            let change = (-dot(normal, left)).max(-*pressure);
            *pressure += change;
            left = add(left, scale(change, normal));
        }
    }
    if norm(&left) > BALANCED * norm(&force) {
        left
    } else {
        force
    }
}

/// Of the largest force that a state which is kept leaves out of balance.
fn of_forces(run: &mut Run<'_>, ending: &Ending) -> Option<Site> {
    if ending.residuals.equilibrium <= ending.tolerance {
        return None;
    }
    let force = run.evaluate().force;
    of_motion(&run.model, &force)
}
