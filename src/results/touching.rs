//! What a state says of contact: resultants of the obstacles,
//! and pressure, gap and state on the candidate surfaces, in the caller's units.
//!
//! Everything is read from multipliers and the trace of the displacement `[nodes]`. Lists go interface by interface in the order of the
//! multipliers; results are by name. Cost: one probe a quadrature point and a node of each surface.

use std::borrow::Cow;
use std::collections::BTreeMap;

use crate::contact::gap::Deformed;
use crate::contact::resultant::{Acting, Resultant, resultant};
use crate::contact::{self, extent};
use crate::geometry::vector3::add;
use crate::linalg::vector::scale;
use crate::model::Model;
use crate::model::interfaces::{Interface, Interfaces};
use crate::model::placed::Placed;
use crate::model::state::State;
use crate::obstacle::Obstacle;
use crate::pairs::PairSurface;
use crate::plan::Plan;
use crate::plan::Units;
use crate::report::{BodyContactResult, ContactInterval, ObstacleResult};

/// Contact state of vertices that carry no multiplier.
const NOT_A_CANDIDATE: f64 = -1.0;
/// Numbers of a point of the pressure's path: obstacle, interval, way, pressure, place [2].
pub(crate) const PATH: usize = 6;

/// A body on its obstacles.
pub(crate) struct Touching<'a> {
    /// Decisions, resolved names and units of the scene.
    pub(crate) plan: &'a Plan,
    /// Surfaces with multipliers and what they meet.
    pub(crate) interfaces: &'a Interfaces,
    /// Multipliers, statuses and poses.
    pub(crate) state: &'a State,
    /// The deformed surface: the trace of the displacement on the mesh.
    pub(crate) body: Deformed<'a>,
}

impl<'a> Touching<'a> {
    /// The body of `model` at `state`.
    pub(crate) fn of(model: &Model<'a>, state: &'a State) -> Self {
        Self {
            plan: model.plan,
            interfaces: model.interfaces,
            state,
            body: model.deformed(&state.displacement),
        }
    }

    /// Each interface with what it meets, in the pose of the state.
    fn placed(&self) -> impl Iterator<Item = (&'a Interface, Placed)> {
        let length = self.plan.problem.units.length;
        self.interfaces.placed(&self.state.drive, length)
    }

    /// Results of all obstacles; `complete` adds what is known besides,
    /// given what was found there.
    pub(crate) fn results(
        &self,
        complete: impl Fn(&Interface, &Resultant, &mut ObstacleResult),
    ) -> BTreeMap<String, ObstacleResult> {
        let mut results = BTreeMap::new();
        for (interface, met) in self.placed() {
            let Some(obstacle) = met.obstacle() else {
                continue;
            };
            let reference = obstacle.reference_point();
            let found = self.resultant(interface, &met, reference);
            let mut result = self.result(interface, &met, (&found, reference));
            complete(interface, &found, &mut result);
            results.insert(interface.name.clone(), result);
        }
        results
    }

    /// Results of all contacts between bodies.
    pub(crate) fn between_bodies(&self) -> BTreeMap<String, BodyContactResult> {
        let list = self.interfaces.list.iter();
        let met = list.filter_map(|interface| Some((interface, interface.pair()?)));
        let planned = met.zip(&self.plan.problem.pairs);
        let results = planned.map(|((interface, pair), planned)| {
            let result = self.between(interface, pair, planned.first_carries());
            (interface.name.clone(), result)
        });
        results.collect()
    }

    /// The result of one contact between bodies, with the force on that of the first group.
    fn between(
        &self,
        interface: &Interface,
        pair: &PairSurface,
        first_carries: bool,
    ) -> BodyContactResult {
        let units = &self.plan.problem.units;
        let own = Own::of(interface, self.state);
        let at = own.acting([0.0; 3]);
        let probing = pair.probing(&self.body, &interface.surface);
        let pressed = (&interface.surface, &own.pressure[..]);
        let on_faces = pair.face_forces(&self.body, pressed);
        let met = (&*probing, on_faces.as_deref());
        let extent = extent(&self.body, &interface.surface, met, at);
        let normal_force = pair.normal_force(&self.body, pressed);
        let forces = pair.forces(&self.body, (&interface.surface, &own.pressure));
        let (force, moment, sign) = if first_carries {
            (forces.on_carrier, forces.moment, 1.0)
        } else {
            (forces.on_other, forces.other_moment, -1.0)
        };
        let intervals = extent.intervals.iter().map(|own| {
            let own = in_units(own, units);
            ContactInterval {
                force: own.force.map(|x| sign * x),
                ..own
            }
        });
        let intervals: Vec<ContactInterval> = intervals.collect();
        let area = extent.area * units.area();
        BodyContactResult {
            force: force.map(|x| x * units.force()),
            moment: moment.map(|x| x * units.energy()),
            contact_area: area,
            contact_width: intervals.iter().map(|own| own.width).sum(),
            contact_intervals: intervals,
            mean_pressure: (area > 0.0).then(|| normal_force * units.force() / area),
            peak_pressure: extent.peak.map_or(0.0, |(value, _)| value * units.stress),
            peak_pressure_place: extent.peak.map(|(_, at)| at.map(|x| x * units.length)),
            friction: None,
        }
    }

    /// What the support `name` exerts along its normal: force, and moment about `reference`,
    /// non-dimensional; zeros where it has no multipliers.
    pub(crate) fn guided(&self, name: &str, reference: [f64; 3]) -> [[f64; 3]; 2] {
        let placed = self.placed();
        let own = placed.filter(|(interface, _)| interface.name == name && !interface.is_contact());
        own.fold([[0.0; 3]; 2], |[force, moment], (interface, met)| {
            let found = self.resultant(interface, &met, reference);
            [add(force, found.force), add(moment, found.moment)]
        })
    }

    /// Force and moment about `reference` of one interface on the body,
    /// non-dimensional.
    fn resultant(&self, interface: &Interface, met: &Placed, reference: [f64; 3]) -> Resultant {
        let own = Own::of(interface, self.state);
        resultant(&self.body, &interface.surface, met, own.acting(reference))
    }

    /// A resultant and the extent of contact in the caller's units alone.
    fn result(
        &self,
        interface: &Interface,
        met: &Placed,
        (found, reference): (&Resultant, [f64; 3]),
    ) -> ObstacleResult {
        let units = &self.plan.problem.units;
        let own = Own::of(interface, self.state);
        let extent = extent(
            &self.body,
            &interface.surface,
            (met, None),
            own.acting(reference),
        );
        let area = extent.area * units.area();
        let intervals = extent.intervals.iter().map(|own| in_units(own, units));
        let intervals: Vec<ContactInterval> = intervals.collect();
        let width = intervals.iter().fold(0.0, |sum, own| sum + own.width);
        ObstacleResult {
            force: found.force.map(|x| x * units.force()),
            moment: found.moment.map(|x| x * units.energy()),
            contact_area: found.area * units.area(),
            deformed_contact_area: area,
            contact_width: (units.dimension == 2).then_some(width),
            contact_intervals: intervals,
            max_pressure: found.max_pressure * units.stress,
            peak_pressure: extent.peak.map_or(0.0, |(value, _)| value * units.stress),
            peak_pressure_place: extent.peak.map(|(_, at)| at.map(|x| x * units.length)),
            mean_pressure: (area > 0.0).then(|| found.normal_force * units.force() / area),
            centre_of_pressure: found.centre.map(|x| x * units.length),
            ..ObstacleResult::default()
        }
    }

    /// The pressure along the surfaces of a plane body or a section `[points, PATH]`; none in space.
    pub(crate) fn path(&self) -> Option<Vec<f64>> {
        let units = &self.plan.problem.units;
        if units.dimension != 2 {
            return None;
        }
        let mut rows = Vec::new();
        let contacts = self
            .placed()
            .filter(|(interface, _)| interface.is_contact());
        for (number, (interface, _)) in contacts.enumerate() {
            let surface = &interface.surface;
            let own = Own::of(interface, self.state);
            let (coefficients, pressed) = contact::pressed(surface, own.acting([0.0; 3]));
            for point in contact::path(&self.body, surface, (&coefficients, &pressed)) {
                let [x, y, _] = point.place.map(|x| x * units.length);
                let way = point.arc_length * units.length;
                let pressure = point.pressure * units.stress;
                let row: [f64; PATH] = [number as f64, point.interval as f64, way, pressure, x, y];
                rows.extend(row);
            }
        }
        Some(rows)
    }

    /// Contact pressure at uploaded vertices, and at edges where it is quadratic.
    pub(crate) fn pressure(&self) -> Vec<f64> {
        let interfaces = self.interfaces.list.iter();
        let pressure = interfaces.map(|interface| {
            let mut own = interface.coefficients(&self.state.multiplier);
            scale(&mut own, self.plan.problem.units.stress);
            own
        });
        self.at_nodes(&pressure.collect::<Vec<_>>())
    }

    /// Values of pressures with these coefficients `[interfaces][functions]` at uploaded
    /// vertices, after them at edges where one is quadratic; the largest of several
    /// interfaces, zero off them.
    pub(crate) fn at_nodes(&self, coefficients: &[Vec<f64>]) -> Vec<f64> {
        let (mesh, space) = (self.body.mesh, self.body.space);
        let contacts = self.interfaces.list.iter().zip(coefficients);
        let contacts = contacts.filter(|(interface, _)| interface.is_contact());
        let values = contacts.flat_map(|(interface, own)| interface.surface.at_nodes(own));
        let (vertices, edges): (Vec<_>, Vec<_>) =
            values.partition(|&(node, _)| (node as usize) < space.vertices);
        let mut at_vertices = vec![None; mesh.vertex_count()];
        for (vertex, value) in vertices {
            let uploaded = mesh.used_vertices()[vertex as usize];
            raise(&mut at_vertices[uploaded as usize], value);
        }
        let mut at_edges = vec![
            None;
            if edges.is_empty() {
                0
            } else {
                space.edges.len()
            }
        ];
        for (node, value) in edges {
            raise(&mut at_edges[node as usize - space.vertices], value);
        }
        let all = at_vertices.into_iter().chain(at_edges);
        all.map(Option::unwrap_or_default).collect()
    }

    /// One where a vertex touches, zero where it may, else [`NOT_A_CANDIDATE`].
    pub(crate) fn contact_state(&self) -> Vec<f64> {
        let status = self.state.status.iter();
        let flags: Vec<f64> = status.map(|s| f64::from(u8::from(s.is_closed()))).collect();
        let interfaces = self.interfaces.list.iter();
        let own = interfaces.map(|interface| {
            let shares = interface.coefficients(&flags).into_iter();
            shares.map(f64::ceil).collect()
        });
        self.on_surface(&own.collect::<Vec<_>>(), NOT_A_CANDIDATE, f64::max)
    }

    /// Weighted gap over nodal weight: a length.
    pub(crate) fn gap(&self) -> Vec<f64> {
        let length = self.plan.problem.units.length;
        let mut gaps = Vec::with_capacity(self.interfaces.list.len());
        for (interface, obstacle) in self.placed() {
            let surface = &interface.surface;
            let (weighted, _) = obstacle.gaps(&self.body, surface);
            let weights = surface.weights.iter();
            let own = weighted.iter().zip(weights).map(|(g, w)| g / w * length);
            gaps.push(surface.shares.spread(&own.collect::<Vec<_>>()).into_owned());
        }
        self.on_surface(&gaps, 0.0, f64::min)
    }

    /// Coefficients `[interfaces][functions]` on uploaded vertices, where they are
    /// values; `merge` joins several functions of a vertex.
    pub(crate) fn on_surface(
        &self,
        values: &[Vec<f64>],
        elsewhere: f64,
        merge: fn(f64, f64) -> f64,
    ) -> Vec<f64> {
        let mesh = self.body.mesh;
        let mut out = vec![None; mesh.vertex_count()];
        let contacts = self.interfaces.list.iter().zip(values);
        for (interface, values) in contacts.filter(|(interface, _)| interface.is_contact()) {
            let carriers = interface.surface.carriers.iter();
            for (&vertex, &value) in carriers.zip(values) {
                let Some(&uploaded) = mesh.used_vertices().get(vertex as usize) else {
                    continue; // An edge: fields are values at vertices.
                };
                let slot: &mut Option<f64> = &mut out[uploaded as usize];
                *slot = Some(slot.map_or(value, |old| merge(old, value)));
            }
        }
        out.into_iter()
            .map(|value| value.unwrap_or(elsewhere))
            .collect()
    }
}

/// The pressure of an interface alone.
struct Own<'s> {
    /// Coefficients of the pressure `[multipliers]`.
    pressure: Cow<'s, [f64]>,
    /// Which multipliers are in contact `[multipliers]`.
    active: Vec<bool>,
}

impl<'s> Own<'s> {
    fn of(interface: &Interface, state: &'s State) -> Self {
        let status = interface.own(&state.status);
        Self {
            pressure: interface.own(&state.multiplier),
            active: status.iter().map(|status| status.is_closed()).collect(),
        }
    }

    fn acting(&self, reference: [f64; 3]) -> Acting<'_> {
        Acting {
            reference,
            pressure: &self.pressure,
            active: &self.active,
        }
    }
}

/// An interval in the caller's units.
fn in_units(own: &contact::ContactInterval, units: &Units) -> ContactInterval {
    let [start, end] = own.ends.map(|place| place.map(|x| x * units.length));
    ContactInterval {
        start,
        end,
        width: own.width * units.length,
        force: own.force.map(|x| x * units.force()),
    }
}

/// Takes `value` where there is none or a smaller one.
fn raise(slot: &mut Option<f64>, value: f64) {
    *slot = Some(slot.map_or(value, |old| old.max(value)));
}
