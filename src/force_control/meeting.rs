//! Bodies that supports push where nothing resists: each is led along what nothing balances until it
//! meets an obstacle or another body,
//!
//! ```text
//! s = sum of s_k,   s_k = min g_i(x + s e) / w_i   over the open functions i that e closes
//! ```
//!
//! g weighted gaps, w the weights of their functions, e first the direction that nothing balances, then
//! the normal of what is met that way: a rough body that comes to its floor aslant has slipped along it
//! before it is pressed. What presses already balances nothing more, and is passed. Bodies go one after
//! the other, as many times as there are bodies, for one that is met may go on. Non-dimensional. Cost:
//! two evaluations of the gaps a distance.

use std::collections::BTreeSet;

use super::approach::{ADVANCES, FARTHEST, MOST_DISTANCES, TOUCH};
use super::by_difference::MOTION;
use crate::geometry::vector3::{add, scale};
use crate::linalg::vector::norm;
use crate::model::push::{Control, Part};
use crate::scene::validate::joined_parts;
use crate::sqp::run::Run;

/// The step `[controls]` that leads the bodies of pushed supports along `lost` `[controls]`, the
/// direction in which nothing balances their pushes; none where no body meets anything new.
pub(super) fn lead_bodies(run: &Run<'_>, controls: &[Control], lost: &[f64]) -> Option<Vec<f64>> {
    let mut bodies = pushed_bodies(run, controls, lost);
    let mut displacement = run.state.displacement.clone();
    for _ in 0..bodies.len() {
        for body in &mut bodies {
            body.lead(run, &mut displacement);
        }
    }
    // What is nearer has shown in the differences, which go along axes: to oblique planes by less.
    if bodies.iter().all(|body| norm(&body.way) <= 0.5 * MOTION) {
        return None;
    }
    let way = |control: &Control| match control.part {
        Part::Support(support) if control.axis < 3 => bodies
            .iter()
            .find(|body| body.supports.contains(&support))
            .map_or(0.0, |body| {
                body.way[control.axis] + body.advance()[control.axis]
            }),
        Part::Support(_) | Part::Obstacle(_) => 0.0,
    };
    Some(controls.iter().map(way).collect())
}

/// A body, or some that common supports hold.
struct Pushed {
    /// Supports that push it.
    supports: BTreeSet<usize>,
    /// Its parts of the mesh.
    parts: BTreeSet<u32>,
    /// Which vertices are its own `[vertices]`.
    vertices: Vec<bool>,
    /// The direction in which nothing balances it.
    lost: [f64; 3],
    /// Whether a push moves it along each axis.
    is_free: [bool; 3],
    /// How far it has been led.
    way: [f64; 3],
}

impl Pushed {
    /// Leads the body on until it meets something, at right angles to that where it may.
    fn lead(&mut self, run: &Run<'_>, displacement: &mut Vec<f64>) {
        let Some(along) = unit(self.lost) else {
            return;
        };
        let Some(found) = self.meets(run, displacement, along) else {
            return;
        };
        let normal = self.normal(run, (&found.0, along));
        let is_free = |normal: &[f64; 3]| {
            self.closing(run, (displacement, *normal), |l| l != 0.0)
                .is_empty()
        };
        let straight = normal.filter(is_free);
        let straight = straight.and_then(|normal| self.meets(run, displacement, normal));
        let (moved, way) = straight.unwrap_or(found);
        *displacement = moved;
        self.way = add(self.way, way);
    }

    /// Where the body meets something along `direction`, and the way; none where it meets nothing.
    fn meets(
        &self,
        run: &Run<'_>,
        displacement: &[f64],
        direction: [f64; 3],
    ) -> Option<(Vec<f64>, [f64; 3])> {
        let (mut moved, mut way) = (displacement.to_vec(), 0.0);
        for _ in 0..MOST_DISTANCES {
            let distance = self.distance(run, &moved, direction);
            if distance <= TOUCH {
                return Some((moved, scale(way, direction)));
            }
            way += distance;
            if way.is_nan() || way >= FARTHEST {
                return None;
            }
            self.shift(run, &mut moved, scale(distance, direction));
        }
        None
    }

    /// How far the body may go along `direction` without passing what it may meet.
    fn distance(&self, run: &Run<'_>, displacement: &[f64], direction: [f64; 3]) -> f64 {
        let closing = self.closing(run, (displacement, direction), |l| l == 0.0);
        // One that finds its partner on the way had none, and a gap as wide as the search, here.
        let least = closing
            .iter()
            .map(|(_, [here, ahead])| here.min(ahead + ADVANCES[0]));
        let least = least.fold(f64::INFINITY, f64::min);
        if least.is_finite() {
            return least;
        }
        let widest = mean_gaps(run, displacement, |l| l == 0.0).into_iter();
        let widest = widest.fold(0.0, f64::max);
        if widest > TOUCH {
            widest.min(ADVANCES[1])
        } else {
            f64::INFINITY
        }
    }

    /// The way that closes soonest, of those that the pushes leave free, what the body meets along
    /// `direction`.
    fn normal(
        &self,
        run: &Run<'_>,
        (displacement, direction): (&[f64], [f64; 3]),
    ) -> Option<[f64; 3]> {
        let closing = self.closing(run, (displacement, direction), |l| l == 0.0);
        let nearest = closing.iter().min_by(|a, b| a.1[0].total_cmp(&b.1[0]));
        let &(function, [here, _]) = nearest?;
        let mut slope = [0.0; 3];
        for (axis, slope) in slope
            .iter_mut()
            .enumerate()
            .filter(|(axis, _)| self.is_free[*axis])
        {
            let mut moved = displacement.to_vec();
            let mut motion = [0.0; 3];
            motion[axis] = ADVANCES[0];
            self.shift(run, &mut moved, motion);
            let gaps = mean_gaps(run, &moved, |l| l == 0.0);
            *slope = here - gaps.get(function).unwrap_or(&here);
        }
        unit(slope)
    }

    /// The mean gaps that a motion of the body along `direction` closes, before and after it, with
    /// their numbers among the functions whose pressures count.
    fn closing(
        &self,
        run: &Run<'_>,
        (displacement, direction): (&[f64], [f64; 3]),
        counts: impl Fn(f64) -> bool,
    ) -> Vec<(usize, [f64; 2])> {
        let mut moved = displacement.to_vec();
        self.shift(run, &mut moved, scale(ADVANCES[0], direction));
        let [here, ahead] = [displacement, &moved].map(|place| mean_gaps(run, place, &counts));
        let both = here
            .into_iter()
            .zip(ahead)
            .map(<[f64; 2]>::from)
            .enumerate();
        both.filter(|(_, [here, ahead])| here - ahead > TOUCH)
            .collect()
    }

    /// Moves the body by `motion`: what is linear has no part on edges.
    fn shift(&self, run: &Run<'_>, displacement: &mut [f64], motion: [f64; 3]) {
        let nodes = displacement.chunks_exact_mut(run.model.prepared.space.components);
        for (node, _) in nodes.zip(&self.vertices).filter(|(_, is_own)| **is_own) {
            let parts = node.iter_mut().zip(motion);
            parts.for_each(|(x, part)| *x += part);
        }
    }

    /// What it goes beyond touch, once it has been led.
    fn advance(&self) -> [f64; 3] {
        let size = norm(&self.way);
        let share = if size > TOUCH {
            ADVANCES[0] / size
        } else {
            0.0
        };
        scale(share, self.way)
    }
}

/// `vector` at length one; none without a direction.
fn unit(vector: [f64; 3]) -> Option<[f64; 3]> {
    let size = norm(&vector);
    (size > 0.0).then(|| vector.map(|part| part / size))
}

/// The mean gaps under the functions of contact whose pressures count.
fn mean_gaps(run: &Run<'_>, displacement: &[f64], counts: impl Fn(f64) -> bool) -> Vec<f64> {
    let model = &run.model;
    let body = model.deformed(displacement);
    let mut means = Vec::new();
    for (interface, met) in model.placed(&run.state.drive) {
        if interface.is_contact() {
            let (gaps, _) = met.gaps(&body, &interface.surface);
            let pressures = interface.own(&run.state.multiplier);
            let weights = interface.surface.weights.iter();
            let all = gaps.iter().zip(weights).zip(pressures.iter());
            let counted =
                all.filter(|((_, weight), pressure)| **weight > 0.0 && counts(**pressure));
            means.extend(counted.map(|((gap, weight), _)| gap / weight));
        }
    }
    means
}

/// The bodies that pushed supports hold, with what of `lost` `[controls]` is theirs.
fn pushed_bodies(run: &Run<'_>, controls: &[Control], lost: &[f64]) -> Vec<Pushed> {
    let problem = &run.model.plan.problem;
    let part_of = joined_parts(run.model.mesh, &problem.resolved.ties);
    let mut bodies: Vec<Pushed> = Vec::new();
    for (control, &lost) in controls.iter().zip(lost) {
        let Part::Support(support) = control.part else {
            continue;
        };
        let held = problem.held.iter();
        let held = held.filter(|held| usize::from(held.1) == support);
        let nodes = held.map(|held| held.0 as usize / run.model.prepared.space.components);
        let parts = nodes.filter_map(|node| part_of.get(node).copied());
        let mut body = Pushed::new(support, parts.collect());
        if control.axis < 3 {
            body.lost[control.axis] = lost;
            body.is_free[control.axis] = true;
        }
        let is_common = |other: &mut Pushed| !other.parts.is_disjoint(&body.parts);
        let common: Vec<Pushed> = bodies.extract_if(.., is_common).collect();
        common.into_iter().for_each(|other| body.join(other));
        bodies.push(body);
    }
    for body in &mut bodies {
        body.vertices = part_of
            .iter()
            .map(|part| body.parts.contains(part))
            .collect();
    }
    bodies
}

impl Pushed {
    fn new(support: usize, parts: BTreeSet<u32>) -> Self {
        Self {
            supports: BTreeSet::from([support]),
            parts,
            vertices: Vec::new(),
            lost: [0.0; 3],
            is_free: [false; 3],
            way: [0.0; 3],
        }
    }

    /// Takes over `other`, which moves along.
    fn join(&mut self, other: Self) {
        self.supports.extend(other.supports);
        self.parts.extend(other.parts);
        self.lost = add(self.lost, other.lost);
        self.is_free = std::array::from_fn(|axis| self.is_free[axis] || other.is_free[axis]);
    }
}
