//! A goal on a body: its value and its derivative with respect to the state,
//!
//! ```text
//! contact    J = -l . C w          J_u = K w + [f x a],  J_l = -C w,   f = -C^T l
//! support    J = w . (A u + B^T p + C^T l - load)        J_x = M^T w
//! probe      J = u(X) . e
//! pressure   J = sum of w_k l_k                         the largest value at a node, which stays that
//! energy     J = int W - p . (B u - S p / 2)            J_u = A u + B^T p, J_p = B u - S p = 0
//! ```
//!
//! contact: of an obstacle, or of two bodies. w the rigid motion of the whole body that the goal does work
//! on, of a support and of two bodies that of its nodes, or of those of the surface of the body named first,
//! alone; K the curvature of the obstacle's gaps under its pressure with what turns its tractions, M the matrix of the
//! dual problem with the rows and columns of what is held; [f x a] for moments about a only.
//! Non-dimensional, all rows, held ones included. Cost: one pass over the obstacle's surface, of a
//! support one product with the tangent besides.

use super::error::GoalError;
use super::own_contact::OwnContact;
use super::transposed::{transposed, zeros};
use crate::contact::shares::add_equal_columns;
use crate::geometry::vector3::{cross, sub};
use crate::linalg::vector::{add_scaled, dot};
use crate::linalg::{LinearOperator, Workspace};
use crate::mesh::locate::Located;
use crate::model::Model;
use crate::model::energy::strain_energy;
use crate::model::evaluate::Terms;
use crate::model::internal::internal;
use crate::model::state::State;
use crate::model::values::{displacement_at, gradient_at};
use crate::obstacle::Obstacle;
use crate::pairs::Meets;
use crate::results::geometry_error::geometry_error;
use crate::results::nodal_force::{contact_force, reaction};
use crate::scene::{Goal, GoalKind};
use crate::sqp::fields::Fields;

/// A goal with its names resolved.
#[derive(Clone, Debug)]
pub(super) struct ResolvedGoal {
    what: What,
    axis: usize,
    /// What brings its value to the caller's units.
    unit: f64,
}

/// What is measured.
#[derive(Clone, Debug)]
enum What {
    /// Force of the obstacle of that number.
    Force(usize),
    /// Its moment.
    Moment(usize),
    /// Force of a contact between bodies on the one named first: its interface, and the sign of the
    /// force on its carrier.
    Between(usize, f64),
    /// Force of the support of that number.
    Reaction(usize),
    /// Displacement of a place.
    Displacement(Located),
    /// Largest pressure of an obstacle: multipliers with their weights.
    MaxPressure(Vec<(usize, f64)>),
    /// Energy of the body.
    StrainEnergy,
}

impl ResolvedGoal {
    /// Of a goal of the scene; at a node of the surface of the `state`, where pressures are.
    ///
    /// # Errors
    /// [`GoalError::Unknown`] and [`GoalError::Absent`].
    pub(super) fn new(
        (model, state): (&Model<'_>, &State),
        goal: &Goal,
    ) -> Result<Self, GoalError> {
        let problem = &model.plan.problem;
        let unknown = || GoalError::Unknown {
            text: goal.to_string(),
            what: goal.kind.owner(),
        };
        let obstacle = || {
            let mut all = problem.obstacles.iter();
            let found = all.position(|one| one.name == goal.name);
            found.ok_or_else(unknown)
        };
        let (what, unit) = match goal.kind {
            GoalKind::Force => (
                obstacle()
                    .map(What::Force)
                    .or_else(|error| between(model, &goal.name).ok_or(error))?,
                problem.units.force(),
            ),
            GoalKind::Moment => (What::Moment(obstacle()?), problem.units.energy()),
            GoalKind::Reaction => {
                let mut all = problem.resolved.supports.iter();
                let found = all.position(|one| one.name == goal.name);
                (
                    What::Reaction(found.ok_or_else(unknown)?),
                    problem.units.force(),
                )
            }
            GoalKind::Displacement => {
                let mut all = problem.resolved.probes.iter();
                let found = all.find(|one| one.name == goal.name).ok_or_else(unknown)?;
                (What::Displacement(found.place), problem.units.length)
            }
            GoalKind::MaxPressure => {
                let place = largest_pressure(model, state, obstacle()?);
                (What::MaxPressure(place), problem.units.stress)
            }
            GoalKind::StrainEnergy => (What::StrainEnergy, problem.units.energy()),
        };
        let axis = usize::from(goal.axis);
        let resolved = Self { what, axis, unit };
        resolved.check(model, goal).map(|()| resolved)
    }

    fn check(&self, model: &Model<'_>, goal: &Goal) -> Result<(), GoalError> {
        let absent = |cause: &str| {
            Err(GoalError::Absent {
                text: goal.to_string(),
                cause: cause.to_owned(),
            })
        };
        let plan = model.plan;
        if let Some(cause) = goal.absent(plan.problem.resolved.kind) {
            return absent(cause);
        }
        if let What::Between(index, _) = &self.what {
            let pairs = &plan.problem.pairs;
            let own = index.checked_sub(plan.problem.obstacles.len());
            let own = own.and_then(|place| pairs.get(place));
            return if own.is_some_and(|pair| pair.meets != Meets::AnotherBody) {
                absent("a body exerts no force on itself")
            } else {
                Ok(())
            };
        }
        let What::Reaction(support) = &self.what else {
            return Ok(());
        };
        let own = &plan.problem.resolved.supports[*support];
        if own.oblique.is_empty() && own.patches.is_empty() {
            Ok(())
        } else {
            absent("the support holds the normal of a surface that is across no axis")
        }
    }

    /// What brings a value to the caller's units.
    pub(super) fn unit(&self) -> f64 {
        self.unit
    }

    /// Adds `factor` of the motion of the nodes of a support, which the mesh has made: a dual solution
    /// less that is smooth where the exact one is, with the same error.
    pub(super) fn add_support_motion(&self, model: &Model<'_>, factor: f64, to: &mut [f64]) {
        if let What::Reaction(support) = &self.what {
            add_scaled(to, factor, &self.support_motion(model, *support));
        }
    }

    /// Adds `factor` of the motion that the goal does work on, of a goal about that obstacle.
    pub(super) fn add_motion_of(
        &self,
        (model, state): (&Model<'_>, &State),
        (obstacle, factor): (usize, f64),
        to: &mut [f64],
    ) {
        let is_own =
            matches!(&self.what, What::Force(index) | What::Moment(index) if *index == obstacle);
        let own = OwnContact::new(model, state, obstacle).filter(|_| is_own);
        if let Some(own) = own {
            add_scaled(to, factor, &self.motion(model, state, &own));
        }
    }

    /// Whether it is a force or a moment of an obstacle.
    pub(super) fn is_of_obstacle(&self) -> bool {
        matches!(self.what, What::Force(_) | What::Moment(_))
    }

    /// What flat facets in the place of a curved surface make of the goal, in the caller's units.
    pub(super) fn geometry(&self, model: &Model<'_>, state: &State) -> f64 {
        let (What::Force(index) | What::Moment(index)) = &self.what else {
            return 0.0;
        };
        let interface = model.interfaces.list.get(*index);
        let relative = interface.and_then(|one| geometry_error(model, state, one));
        relative.map_or(0.0, |relative| {
            relative * self.value(model, state).abs() * self.unit
        })
    }

    /// Whether J itself depends on `terms` at a given state.
    pub(super) fn reads(&self, terms: Terms) -> bool {
        match &self.what {
            What::Reaction(_) => true,
            What::Force(_) | What::Moment(_) => matches!(terms, Terms::Contact | Terms::All),
            What::StrainEnergy => matches!(terms, Terms::Body | Terms::All),
            What::Displacement(_) | What::MaxPressure(_) | What::Between(..) => terms == Terms::All,
        }
    }

    /// J, non-dimensional.
    pub(super) fn value(&self, model: &Model<'_>, state: &State) -> f64 {
        match &self.what {
            What::Force(index) | What::Moment(index) => {
                let own = OwnContact::new(model, state, *index);
                own.map_or(0.0, |own| {
                    dot(&own.force(state), &self.motion(model, state, &own))
                })
            }
            What::Between(index, sign) => {
                let own = OwnContact::new(model, state, *index);
                own.map_or(0.0, |own| {
                    sign * dot(&own.force(state), &self.carrier_motion(model, *index))
                })
            }
            What::Reaction(support) => {
                let inside = internal(model, state, &mut Workspace::new()).force;
                let contact = contact_force(model, state);
                let found = reaction(model, state, inside, &contact);
                dot(&found, &self.support_motion(model, *support))
            }
            What::Displacement(at) => {
                displacement_at(model, state, at.cell as usize, &at.barycentric)[self.axis]
            }
            What::MaxPressure(places) => {
                let parts = places.iter();
                parts.map(|(place, w)| w * state.multiplier[*place]).sum()
            }
            What::StrainEnergy => {
                let work = &mut Workspace::new();
                let inside = internal(model, state, work);
                let energy = strain_energy(model, state, &inside, work);
                energy - dot(&state.pressure, &inside.constraint)
            }
        }
    }

    /// dJ/dx.
    pub(super) fn derivative(
        &self,
        model: &Model<'_>,
        state: &State,
        work: &mut Workspace,
    ) -> Fields {
        match &self.what {
            What::Force(index) | What::Moment(index) => {
                let own = OwnContact::new(model, state, *index);
                own.map_or_else(|| zeros(state), |own| self.of_obstacle(model, state, &own))
            }
            What::Between(index, sign) => self.of_bodies((model, state), (*index, *sign)),
            What::Reaction(support) => {
                let motion = self.support_motion(model, *support);
                transposed(model, state, &motion, work)
            }
            What::Displacement(at) => self.of_place(model, state, at),
            What::MaxPressure(places) => {
                let mut out = zeros(state);
                for (place, weight) in places {
                    out.multiplier[*place] = *weight;
                }
                out
            }
            What::StrainEnergy => {
                let inside = internal(model, state, work);
                let mut out = zeros(state);
                add_scaled(&mut out.pressure, -1.0, &inside.constraint);
                out.displacement = inside.force;
                out
            }
        }
    }

    fn of_obstacle(&self, model: &Model<'_>, state: &State, own: &OwnContact<'_>) -> Fields {
        let motion = self.motion(model, state, own);
        let mut out = zeros(state);
        let curvature = own.curvature(model, state);
        let work = &mut Workspace::new();
        curvature.apply_transposed(&motion, &mut out.displacement, work);
        self.add_turned(model, &own.force(state), &mut out.displacement);
        own.add_work(-1.0, &motion, &mut out.multiplier);
        out
    }

    fn of_bodies(
        &self,
        (model, state): (&Model<'_>, &State),
        (index, sign): (usize, f64),
    ) -> Fields {
        let mut out = zeros(state);
        let Some(own) = OwnContact::new(model, state, index) else {
            return out;
        };
        let mut motion = self.carrier_motion(model, index);
        motion.iter_mut().for_each(|x| *x *= sign);
        let curvature = own.curvature(model, state);
        curvature.apply_transposed(&motion, &mut out.displacement, &mut Workspace::new());
        own.add_work(-1.0, &motion, &mut out.multiplier);
        out
    }

    fn of_place(&self, model: &Model<'_>, state: &State, at: &Located) -> Fields {
        let (space, mut out) = (&model.prepared.space, zeros(state));
        let (c, cell) = (space.components, at.cell as usize);
        for (&vertex, share) in model.mesh.cell(cell).iter().zip(at.barycentric) {
            out.displacement[vertex as usize * c + self.axis] += share;
        }
        for (node, (a, b)) in space.edge_nodes_of(model.mesh, cell) {
            let share = 4.0 * at.barycentric[a] * at.barycentric[b];
            out.displacement[node * c + self.axis] += share;
        }
        out
    }

    /// Whether the goal is the energy of the body.
    pub(super) fn is_energy(&self) -> bool {
        matches!(self.what, What::StrainEnergy)
    }

    /// The rigid motion that the goal does work on, where it is of that obstacle.
    pub(super) fn of_own_motion(
        &self,
        model: &Model<'_>,
        state: &State,
        obstacle: usize,
    ) -> Option<Vec<f64>> {
        let is_own =
            matches!(&self.what, What::Force(index) | What::Moment(index) if *index == obstacle);
        let own = OwnContact::new(model, state, obstacle).filter(|_| is_own)?;
        Some(self.motion(model, state, &own))
    }

    /// Adds f x a of a moment about a: how its motion turns with the places of the nodes.
    pub(super) fn add_turned(&self, model: &Model<'_>, forces: &[f64], field: &mut [f64]) {
        if let What::Moment(_) = &self.what {
            let mut about = [0.0; 3];
            about[self.axis] = 1.0;
            let c = model.prepared.space.components;
            for (own, force) in field.chunks_exact_mut(c).zip(forces.chunks_exact(c)) {
                let turned = cross(in_space(force), about);
                own.iter_mut().zip(turned).for_each(|(x, t)| *x += t);
            }
        }
    }

    /// Adds what a fixed place of a probe sees of vertices that move on.
    pub(super) fn add_place(&self, model: &Model<'_>, state: &State, sums: &mut [[f64; 3]]) {
        if let What::Displacement(at) = &self.what {
            let cell = at.cell as usize;
            let gradient = gradient_at(model, state, cell, &at.barycentric);
            for (&vertex, share) in model.mesh.cell(cell).iter().zip(at.barycentric) {
                let sum = &mut sums[vertex as usize];
                let row = gradient[self.axis];
                let components = 0..model.prepared.space.components;
                components.for_each(|i| sum[i] -= share * row[i]);
            }
        }
    }

    /// The rigid motion of the body that the goal does work on, hierarchical `[displacement]`.
    fn motion(&self, model: &Model<'_>, state: &State, own: &OwnContact<'_>) -> Vec<f64> {
        let space = &model.prepared.space;
        let c = space.components;
        let mut motion = vec![0.0; space.displacement_unknowns()];
        let mut along = [0.0; 3];
        along[self.axis] = 1.0;
        let reference = own.met.obstacle().map(Obstacle::reference_point);
        for (node, row) in motion.chunks_exact_mut(c).enumerate() {
            let is_vertex = node < space.vertices;
            let is_turn = matches!(self.what, What::Moment(_));
            let value = match (is_turn, is_vertex) {
                (true, _) => {
                    let place = model.place(node, &state.displacement);
                    let about = reference.filter(|_| is_vertex).unwrap_or_default();
                    cross(along, sub(place, about))
                }
                (false, true) => along,
                (false, false) => [0.0; 3],
            };
            row.copy_from_slice(&value[..c]);
        }
        motion
    }

    /// One along the axis at the vertices of an interface, hierarchical `[displacement]`.
    fn carrier_motion(&self, model: &Model<'_>, index: usize) -> Vec<f64> {
        let space = &model.prepared.space;
        let mut motion = vec![0.0; space.displacement_unknowns()];
        let interface = model.interfaces.list.get(index);
        let facets = interface.map_or(&[][..], |one| &one.facets);
        let vertices = facets.iter().flat_map(|&f| model.mesh.facet(f as usize));
        vertices.for_each(|&v| motion[v as usize * space.components + self.axis] = 1.0);
        motion
    }

    /// One at the nodes that a support holds along the axis, hierarchical `[displacement]`.
    fn support_motion(&self, model: &Model<'_>, support: usize) -> Vec<f64> {
        let space = &model.prepared.space;
        let c = space.components;
        let mut nodal = vec![0.0; space.displacement_unknowns()];
        for &(unknown, holder) in &model.plan.problem.held {
            let unknown = unknown as usize;
            if usize::from(holder) == support && unknown % c == self.axis {
                nodal[unknown] = 1.0;
            }
        }
        for (edge, ends) in space.edges.iter().enumerate() {
            let [a, b] = ends.map(|vertex| nodal[vertex as usize * c + self.axis]);
            nodal[(space.vertices + edge) * c + self.axis] -= 0.5 * (a + b);
        }
        nodal
    }
}

/// The force of the contact between bodies of that name; none where there is none.
fn between(model: &Model<'_>, name: &str) -> Option<What> {
    let problem = &model.plan.problem;
    let place = problem.pairs.iter().position(|one| one.name == name)?;
    let sign = if problem.pairs[place].first_carries() {
        1.0
    } else {
        -1.0
    };
    Some(What::Between(problem.obstacles.len() + place, sign))
}

/// The largest pressure at a node of an obstacle's surface as the sum that it is of multipliers.
fn largest_pressure(model: &Model<'_>, state: &State, index: usize) -> Vec<(usize, f64)> {
    let Some(interface) = model.interfaces.list.get(index) else {
        return Vec::new();
    };
    let surface = &interface.surface;
    let functions = surface.largest_as_sum(&interface.coefficients(&state.multiplier));
    let places: Vec<usize> = interface.places().collect();
    let shares = functions.iter().flat_map(|&(function, weight)| {
        let own = surface.shares.of(function);
        own.map(move |(multiplier, share)| (multiplier, weight * share))
    });
    let mut all: Vec<(u32, f64)> = shares.collect();
    add_equal_columns(&mut all);
    let all = all.into_iter();
    all.map(|(multiplier, weight)| (places[multiplier as usize], weight))
        .collect()
}

fn in_space(row: &[f64]) -> [f64; 3] {
    std::array::from_fn(|i| row.get(i).copied().unwrap_or(0.0))
}
