//! Friction on the obstacles with friction: tractions with their slip and their bounds.
//!
//! ```text
//! S_i = int phi_i [ x - Q x0 ] dS + Q r_i,   s_i = T_i S_i,   T_i = I - n_i n_i^T
//! |t_i| <= mu n_i;   s_i = 0 within,   t_i = -mu n_i s_i / |s_i| on the edge
//! ```
//!
//! x0 is where the increment began, r_i what its point had moved until then and no slip
//! explained (within the tolerance: `note_slip`), Q what the obstacle has done since: Q x0 is where its
//! material point is now that stood at x0. n_i is the mean normal of the obstacle at the end,
//! so that everything is implicit, and body and obstacle turned together slip by nothing. The
//! functions and the weights are those of the pressure: over the undeformed surface of a linear
//! body, over the deformed one of a body of finite strain. What a
//! support holds at the node of a point drops out of its traction and its slip.
//!
//! Between bodies the slip is that along the other one's surface ([`between`]).
//!
//! Points stand obstacle by obstacle in the order of its multipliers, then contact by contact between
//! bodies; where two frictional
//! obstacles have a common multiplier each has a point of its own on its own faces. Numbers
//! of a point lie side by side, after all pressures.
//! Cost: the mass of the traces once; then a sparse product, and mean normals of curved
//! obstacles, an evaluation.

mod area;
mod between;
mod frame;
mod points;
mod traces;
mod turning;

use std::sync::Arc;

use super::Model;
use super::drive::Drive;
use super::state::State;
use crate::contact::ContactSurface;
use crate::contact::gap::Deformed;
use crate::geometry::Matrix3;
use crate::geometry::rigid_motion::multiply;
use crate::geometry::vector3::{add, dot, scale, sub};
use crate::obstacle::Moving;
use crate::plan::Plan;
use crate::saddle::{Components, FrictionBound, Status};
use between::PairPoints;
use frame::{frame, normals};
use points::{guided, points_of};
use traces::Traces;

pub(crate) use frame::Frame;
pub(crate) use points::Point;

/// Coefficient over the tolerance up to which tractions are within what a residual may leave.
const NEGLIGIBLE: f64 = 0.1;

/// The frictional obstacles' points.
#[derive(Clone, Debug)]
pub(crate) struct Friction {
    /// The points, in the order of their multipliers.
    pub(crate) points: Vec<Point>,
    /// Tractions of a point.
    pub(crate) components: Components,
    /// Number of the first traction among all multipliers: that of all pressures.
    pub(crate) first: usize,
    /// The pressure of each point `[points]`.
    pub(crate) partners: Arc<[u32]>,
    /// Integrals over the undeformed surface.
    at_rest: Arc<Traces>,
    /// Number of the points on obstacles, which come first.
    pub(crate) on_obstacles: usize,
    /// Frictional contacts between bodies.
    pub(crate) pairs: Vec<PairPoints>,
}

/// Where an increment began.
#[derive(Clone, Debug)]
pub(crate) struct SlipStart {
    /// Displacement `[displacement unknowns]`.
    displacement: Vec<f64>,
    /// Poses of the obstacles, and what else drove the body.
    drive: Drive,
    /// Slip that no traction had answered, weighted `[points * 3]`.
    residue: Vec<f64>,
}

impl SlipStart {
    /// At `state`.
    pub(crate) fn at(state: &State) -> Self {
        Self {
            displacement: state.displacement.clone(),
            drive: state.drive.clone(),
            residue: state.slip.residue.clone(),
        }
    }

    /// Displacement there `[displacement unknowns]`.
    pub(crate) fn displacement(&self) -> &[f64] {
        &self.displacement
    }

    /// What drove the body there.
    pub(crate) fn drive(&self) -> &Drive {
        &self.drive
    }

    /// Slip that no traction had answered there, weighted `[points][3]`.
    pub(crate) fn residue(&self) -> &[[f64; 3]] {
        self.residue.as_chunks().0
    }
}

/// Slip and its derivative at a state.
pub(crate) struct Slips {
    /// s in the frames of the points, weighted `[points * components]`.
    pub(crate) slip: Vec<f64>,
    /// Rows of -ds/du `[points * components]`.
    pub(crate) rows: Vec<Vec<(u32, f64)>>,
}

/// The points' pressures and how far their tractions may go.
#[derive(Clone, Debug)]
pub(crate) struct Law {
    /// Number of pressures of all obstacles, frictional or not.
    pub(crate) normals: usize,
    /// The pressure of each point `[points]`.
    pub(crate) partners: Arc<[u32]>,
    /// Bounds `[points]`.
    pub(crate) bounds: Vec<FrictionBound>,
    /// Tractions of a point.
    pub(crate) components: Components,
}

impl Law {
    /// Largest traction of each point under all `multipliers`.
    pub(crate) fn radii(&self, multipliers: &[f64]) -> Vec<f64> {
        let points = self.partners.iter().zip(&self.bounds);
        let radius =
            |(&partner, bound): (&u32, &FrictionBound)| bound.radius(multipliers[partner as usize]);
        points.map(radius).collect()
    }

    /// Number of tractions.
    pub(crate) fn tractions(&self) -> usize {
        self.bounds.len() * self.components.count()
    }
}

impl Friction {
    /// Of the interfaces of `plan`, multipliers and surface, on the undeformed `body`; none
    /// where no obstacle is frictional.
    pub(crate) fn new(
        plan: &Plan,
        body: &Deformed<'_>,
        list: &[(&[u32], &ContactSurface)],
    ) -> Option<Self> {
        let first = plan.normal_multipliers();
        let components = match plan.problem.units.dimension {
            2 => Components::One,
            _ => Components::Two,
        };
        let (mut points, mut partners) = (Vec::new(), Vec::new());
        let mut surfaces = Vec::new();
        let (obstacles, others) = list.split_at(plan.problem.obstacles.len());
        let patches: usize = plan.problem.patches().count();
        let guides = others.iter().skip(plan.problem.pairs.len()).take(patches);
        let guided = guided(guides.map(|(_, surface)| *surface));
        for (obstacle, (multipliers, surface)) in obstacles.iter().enumerate() {
            if !plan.problem.obstacles[obstacle].is_frictional {
                continue;
            }
            let components = body.space.components;
            points.extend(points_of((plan, &guided), components, (obstacle, surface)));
            partners.extend_from_slice(multipliers);
            surfaces.push(*surface);
        }
        let on_obstacles = points.len();
        let mut pairs = Vec::new();
        for (pair, planned) in plan.problem.pairs.iter().enumerate() {
            let interface = obstacles.len() + pair;
            let Some((multipliers, surface)) =
                list.get(interface).filter(|_| planned.is_frictional())
            else {
                continue;
            };
            let first = points.len();
            let components = body.space.components;
            points.extend(points_of((plan, &guided), components, (interface, surface)));
            partners.extend_from_slice(multipliers);
            pairs.push(PairPoints {
                interface,
                points: first..points.len(),
            });
        }
        (!points.is_empty()).then(|| Self {
            on_obstacles,
            pairs,
            points,
            components,
            first,
            partners: partners.into(),
            at_rest: Arc::new(Traces::new(body, surfaces.into_iter())),
        })
    }

    /// Number of tractions.
    pub(crate) fn size(&self) -> usize {
        self.points.len() * self.components.count()
    }

    /// The law where `drive` has the coefficients.
    pub(crate) fn law(&self, plan: &Plan, drive: &Drive) -> Law {
        let obstacles = &plan.problem.obstacles;
        let bound = |point: &Point| match tresca(plan, point.obstacle) {
            Some(bound) => FrictionBound::Tresca(bound / plan.problem.units.stress),
            None => {
                let coefficient = match point.obstacle.checked_sub(obstacles.len()) {
                    None => drive.friction[point.obstacle],
                    Some(pair) => plan.problem.pairs[pair].friction,
                };
                let is_felt = coefficient > NEGLIGIBLE * plan.problem.settings.tolerance;
                FrictionBound::Coulomb(if is_felt { coefficient } else { 0.0 })
            }
        };
        Law {
            normals: self.first,
            partners: self.partners.clone(),
            bounds: self.points.iter().map(bound).collect(),
            components: self.components,
        }
    }

    /// Gives the tractions what belongs to their pressures, `[multipliers]`.
    pub(crate) fn take_over(&self, values: &mut [f64]) {
        let width = self.components.count();
        for (point, &partner) in self.partners.iter().enumerate() {
            let own = self.first + point * width..self.first + (point + 1) * width;
            let value = values[partner as usize];
            values[own].fill(value);
        }
    }

    /// The traction of a point in its frame, and what the point does.
    fn traction(&self, state: &State, number: usize) -> ([f64; 2], Status) {
        let width = self.components.count();
        let first = self.first + number * width;
        let own = &state.multiplier[first..first + width];
        let component = |a: usize| own.get(a).copied().unwrap_or(0.0);
        ([component(0), component(1)], state.status[first])
    }

    /// The integrals at a state: over the deformed surface of a body of finite strain.
    pub(crate) fn traces(&self, model: &Model<'_>, state: &State) -> Arc<Traces> {
        if !model.is_rubber() {
            return self.at_rest.clone();
        }
        let body = model.deformed(&state.displacement);
        let frictional = model.frictional().map(|(_, interface)| &interface.surface);
        Arc::new(Traces::new(&body, frictional))
    }

    /// Weighted slips since `start` `[points]`, not projected.
    pub(crate) fn travels(
        &self,
        traces: &Traces,
        (model, state): (&Model<'_>, &State),
        start: &SlipStart,
    ) -> Vec<[f64; 3]> {
        let c = model.prepared.space.components;
        let change: Vec<f64> = state
            .displacement
            .iter()
            .zip(&start.displacement)
            .map(|(now, before)| now - before)
            .collect();
        let moved = traces.moved(c, &change);
        let before = traces.moments(c, &start.displacement);
        let length = model.plan.problem.units.length;
        let [from, to] =
            [&start.drive, &state.drive].map(|drive| model.interfaces.obstacles(drive, length));
        let points = self.points.iter().zip(&traces.weights);
        let points = points.zip(before).zip(moved).zip(start.residue());
        points
            .map(|((((point, &weight), before), moved), residue)| {
                let pair = [&from[point.obstacle], &to[point.obstacle]];
                let travel = sub(moved, carried(pair, before, weight));
                add(travel, turned(pair, *residue))
            })
            .collect()
    }

    /// How far all points have moved along their tangents since `start`, weighted, and their weights.
    fn ways(
        &self,
        (model, state): (&Model<'_>, &State),
        frames: &[Frame],
        start: &SlipStart,
    ) -> Vec<([f64; 2], f64)> {
        let traces = self.traces(model, state);
        let travels = self.travels(&traces, (model, state), start);
        let tools = frames.iter().zip(travels).zip(&traces.weights);
        let mut ways: Vec<([f64; 2], f64)> = tools
            .map(|((frame, travel), &weight)| (frame.map(|t| dot(t, travel)), weight))
            .collect();
        for own in self.between(model, state) {
            let slips = own.sliding.slips.chunks_exact(self.components.count());
            let along = slips.zip(&own.sliding.weights);
            ways.extend(along.map(|(slip, &weight)| {
                let second = slip.get(1).copied().unwrap_or(0.0);
                ([slip[0], second], weight)
            }));
        }
        ways
    }

    /// Tangents of all points at a state `[points]`.
    pub(crate) fn frames(&self, model: &Model<'_>, state: &State) -> Vec<Frame> {
        let mut frames = Vec::with_capacity(self.points.len());
        let body = model.deformed(&state.displacement);
        let mut points = &self.points[..];
        for (index, (interface, met)) in model.placed(&state.drive).enumerate() {
            let Some(obstacle) = met.obstacle() else {
                continue;
            };
            if !model.plan.problem.obstacles[index].is_frictional {
                continue;
            }
            let (own, rest) = points.split_at(interface.multipliers.len());
            let normals = normals(&body, &interface.surface, obstacle);
            let dimension = model.plan.problem.units.dimension;
            frames.extend(
                own.iter()
                    .zip(normals)
                    .map(|(point, n)| frame(point, n, dimension)),
            );
            points = rest;
        }
        frames.extend(self.frames_between(model, state));
        frames
    }

    /// Slip since the increment began and its rows at a state, columns of `held` unknowns left out.
    pub(crate) fn linearised(&self, model: &Model<'_>, state: &State, held: &[bool]) -> Slips {
        let frames = self.frames(model, state);
        let traces = self.traces(model, state);
        let mut slips = Slips {
            slip: self.slips_on_obstacles((&frames, &traces), model, state),
            rows: self.rows((&frames, &traces), model, held),
        };
        self.add_between((model, state), held, &mut slips);
        slips
    }

    /// Slip since the increment began in given frames `[points * components]`; zero where
    /// none has.
    pub(crate) fn slips(
        &self,
        (frames, traces): (&[Frame], &Traces),
        model: &Model<'_>,
        state: &State,
    ) -> Vec<f64> {
        let mut slips = self.slips_on_obstacles((frames, traces), model, state);
        let between = self.between(model, state).into_iter();
        slips.extend(between.flat_map(|own| own.sliding.slips));
        slips
    }

    /// The same on obstacles.
    fn slips_on_obstacles(
        &self,
        (frames, traces): (&[Frame], &Traces),
        model: &Model<'_>,
        state: &State,
    ) -> Vec<f64> {
        let width = self.components.count();
        let travels = match &model.conditions.slip_start {
            Some(start) => self.travels(traces, (model, state), start),
            None => vec![[0.0; 3]; self.on_obstacles],
        };
        let pairs = frames.iter().zip(travels);
        pairs
            .flat_map(|(frame, travel)| {
                let along = frame.map(|tangent| dot(tangent, travel));
                along.into_iter().take(width)
            })
            .collect()
    }

    /// Rows of -ds/du in given frames, of points on obstacles.
    pub(crate) fn rows(
        &self,
        (frames, traces): (&[Frame], &Traces),
        model: &Model<'_>,
        held: &[bool],
    ) -> Vec<Vec<(u32, f64)>> {
        let c = model.prepared.space.components;
        let mut rows = Vec::with_capacity(self.size());
        for (point, frame) in frames.iter().take(self.on_obstacles).enumerate() {
            let (nodes, values) = traces.rows.row(point);
            for tangent in &frame[..self.components.count()] {
                let mut row = Vec::new();
                for (&node, value) in nodes.iter().zip(values) {
                    let along = (0..c).filter(|&i| tangent[i] != 0.0);
                    let own = along.map(|i| (node * c as u32 + i as u32, -value * tangent[i]));
                    row.extend(own.filter(|&(unknown, _)| !held[unknown as usize]));
                }
                rows.push(row);
            }
        }
        rows
    }
}

/// Bound on tractions at an obstacle, or at a contact between bodies after all of these.
fn tresca(plan: &Plan, number: usize) -> Option<f64> {
    let obstacles = &plan.problem.obstacles;
    match number.checked_sub(obstacles.len()) {
        None => obstacles[number].tresca,
        Some(pair) => plan.problem.pairs[pair].tresca,
    }
}

/// Notes in the state how far its points have slipped since the increment began, what that
/// has cost, and what of their way no slip explains: within the tolerance points move that
/// stick, and where that was forgotten, ten thousand small increments would drag them anywhere.
pub(crate) fn note_slip(model: &Model<'_>, state: &mut State) {
    let (Some(friction), Some(start)) = (&model.interfaces.friction, &model.conditions.slip_start)
    else {
        return;
    };
    let frames = friction.frames(model, state);
    let ways = friction.ways((model, state), &frames, start);
    state.slip.increment.fill(0.0);
    for (number, point) in friction.points.iter().enumerate() {
        let (frame, (along, weight)) = (&frames[number], ways[number]);
        let vector = |[a, b]: [f64; 2]| add(scale(a, frame[0]), scale(b, frame[1]));
        let (traction, status) = friction.traction(state, number);
        let slip = slip(along, traction, status);
        let left = [along[0] - slip[0], along[1] - slip[1]];
        let is_pressed = state.multiplier[friction.partners[number] as usize] > 0.0;
        let (travel, residue) = if is_pressed && weight > 0.0 {
            let residue = if number < friction.on_obstacles {
                vector(left)
            } else {
                [left[0], left[1], 0.0]
            };
            (scale(weight.recip(), vector(slip)), residue)
        } else {
            Default::default()
        };
        state.slip.increment[point.obstacle] -= traction[0] * slip[0] + traction[1] * slip[1];
        state.slip.travel[3 * number..3 * number + 3].copy_from_slice(&travel);
        state.slip.residue[3 * number..3 * number + 3].copy_from_slice(&residue);
    }
    let sums = state.slip.total.iter_mut().zip(&state.slip.increment);
    sums.for_each(|(total, increment)| *total += increment);
}

/// What of a point's way is slip: all of it where nothing resists, none where it sticks, and
/// on the edge of its disc what points against its traction.
fn slip(along: [f64; 2], traction: [f64; 2], status: Status) -> [f64; 2] {
    let square = traction[0].powi(2) + traction[1].powi(2);
    let work = along[0] * traction[0] + along[1] * traction[1];
    match status {
        Status::Open => along,
        Status::Slip if work < 0.0 && square > 0.0 => traction.map(|t| t * (work / square)),
        Status::Slip | Status::Stick => [0.0; 2],
    }
}

/// How far the obstacle has carried a point since the start, weighted: int phi (Q x0 - x0) dS
/// of a moment int phi x0 dS.
fn carried([from, to]: [&Moving; 2], moment: [f64; 3], weight: f64) -> [f64; 3] {
    let [before, after] = [from.motion(), to.motion()];
    let turn = turn(&before.matrix(), &after.matrix());
    let centre = add(before.about, before.translation);
    let arm = sub(moment, scale(weight, centre));
    let shift = sub(after.translation, before.translation);
    add(sub(multiply(&turn, arm), arm), scale(weight, shift))
}

/// A vector of the obstacle, turned as the obstacle has turned since.
fn turned([from, to]: [&Moving; 2], vector: [f64; 3]) -> [f64; 3] {
    let turn = turn(&from.motion().matrix(), &to.motion().matrix());
    multiply(&turn, vector)
}

/// R1 R0^T; exactly the identity where nothing turns.
fn turn(before: &Matrix3, after: &Matrix3) -> Matrix3 {
    if before == after {
        return [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    }
    after.map(|row| before.map(|other| dot(row, other)))
}
