//! The state of a session on the refined mesh.
//!
//! ```text
//! u, p                    the same functions                                        exact
//! contact pressure        b_ij = P_i . F P_j on the halves of a face                exact, not negative
//! traction, travel        vectors by the same shares, then in the frames of the new points
//! residue of slip         its mean over a function by the same shares
//! status                  closed where there is pressure; slips where all it comes from slip
//! wet nodes               where all earlier nodes about them are wet
//! ```
//!
//! Shares are not negative and sum to one, so that no pressure is negative and tractions stay in
//! their discs. Functions whose nodes supports hold have no multiplier of their own: beside them
//! the pressure is that of the refined space, close to the earlier one. Units: those of the refined plan, whose length
//! is another one where curved edges bulge beyond the earlier vertices. Cost: some operations a
//! node.

use std::collections::HashMap;

use super::Lineage;
use super::surface::FacetOrigin;
use crate::fluid::surface::FluidSurface;
use crate::geometry::vector3::{add, dot, scale};
use crate::model::Model;
use crate::model::friction::Frame;
use crate::model::interfaces::{Interface, Role};
use crate::model::state::{SlipState, State};
use crate::plan::Plan;
use crate::saddle::Status;

/// Local corners of the edges of a face, in the order of its nodes.
const EDGES: [(usize, usize); 3] = [(0, 1), (0, 2), (1, 2)];

/// Corners (i, j) of function `k` of a face with that many corners; the same twice for a vertex.
fn corners_of(k: usize, corners: usize) -> (usize, usize) {
    match k.checked_sub(corners) {
        None => (k, k),
        Some(edge) => EDGES.get(edge).copied().unwrap_or_default(),
    }
}

/// Share of function `q` of the earlier face in function `k` of a face with those places.
fn share([k, q]: [usize; 2], origin: &FacetOrigin, [corners, functions]: [usize; 2]) -> f64 {
    let rows = &origin.corners;
    if functions == corners {
        return rows[k][q];
    }
    let ((i, j), (a, b)) = (corners_of(k, corners), corners_of(q, corners));
    if a == b {
        rows[i][a] * rows[j][a]
    } else {
        rows[i][a] * rows[j][b] + rows[i][b] * rows[j][a]
    }
}

/// What one multiplier of a surface comes from: number of the earlier interface, multiplier within
/// it, share.
type Sources = Vec<(usize, u32, f64)>;

/// Both sides of a refinement.
struct Between<'a> {
    before: &'a Model<'a>,
    lineage: &'a Lineage,
    /// Interface and face of each earlier facet, by what it meets.
    faces: HashMap<(Met, u32), (usize, usize)>,
}

/// What a surface meets: number of the obstacle, of the support, or of the contact between bodies.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
enum Met {
    Obstacle(usize),
    Support(usize),
    Pair(usize),
    /// Number of the interface.
    Tie(usize),
}

impl Met {
    /// Of the interface of that number.
    fn of(number: usize, interface: &Interface) -> Self {
        match interface.role {
            Role::Contact(_) => Self::Obstacle(number),
            Role::Support(support) => Self::Support(support),
            Role::Pair(_) => Self::Pair(number),
            Role::Tie(_) => Self::Tie(number),
        }
    }
}

impl<'a> Between<'a> {
    fn new(before: &'a Model<'a>, lineage: &'a Lineage) -> Self {
        let mut faces = HashMap::new();
        for (number, interface) in before.interfaces.list.iter().enumerate() {
            let met = Met::of(number, interface);
            for (face, &facet) in interface.facets.iter().enumerate() {
                faces.insert((met, facet), (number, face));
            }
        }
        Self {
            before,
            lineage,
            faces,
        }
    }

    /// The sources of the multipliers of an interface of the refined body.
    fn sources(&self, number: usize, interface: &Interface) -> Vec<Sources> {
        let met = Met::of(number, interface);
        let surface = &interface.surface;
        let mut sources = vec![Sources::new(); surface.multipliers()];
        for (face, &facet) in surface.faces.iter().zip(&interface.facets) {
            let origin = &self.lineage.facets()[facet as usize];
            let Some(&from) = self.faces.get(&(met, origin.facet)) else {
                continue;
            };
            for (k, &function) in face.functions.iter().enumerate() {
                let own = surface.shares.of(function).find(|&(_, share)| share > 0.99);
                let Some((multiplier, _)) = own else {
                    continue;
                };
                let slot = &mut sources[multiplier as usize];
                if slot.is_empty() {
                    *slot = self.of_function(from, origin, [k, face.corners.len()]);
                }
            }
        }
        sources
    }

    /// The sources of function `k` of a face that lies in the earlier face `from`.
    fn of_function(
        &self,
        (number, face): (usize, usize),
        origin: &FacetOrigin,
        [k, corners]: [usize; 2],
    ) -> Sources {
        let surface = &self.before.interfaces.list[number].surface;
        let functions = &surface.faces[face].functions;
        let mut found = Sources::new();
        for (q, &function) in functions.iter().enumerate() {
            let own = share([k, q], origin, [corners, functions.len()]);
            if own > 0.0 {
                let multipliers = surface.shares.of(function);
                found.extend(multipliers.map(|(m, part)| (number, m, own * part)));
            }
        }
        found
    }
}

/// The state on the refined body: `before` and `after` are of one scene, with the mesh of
/// `lineage` and the one that it leads to.
pub(crate) fn carried(
    (before, state): (&Model<'_>, &State),
    after: &Model<'_>,
    lineage: &Lineage,
) -> State {
    let [old, new] = [before, after].map(|model| &model.plan.problem.units);
    let longer = old.length / new.length;
    let space = &after.prepared.space;
    let mut next = State {
        drive: state.drive.clone(),
        scales: state.scales,
        force_scale: state.force_scale,
        penalty: state.penalty,
        wet: wet(before.plan, state, (after.plan, lineage)),
        ..State::undeformed(after.plan)
    };
    next.displacement = lineage.quadratic(&state.displacement, space.components);
    next.displacement.iter_mut().for_each(|u| *u *= longer);
    if !state.pressure.is_empty() {
        next.pressure = lineage.linear(&state.pressure);
    }
    let between = Between::new(before, lineage);
    let sources = after.interfaces.list.iter().enumerate();
    let sources: Vec<Vec<Sources>> = sources
        .map(|(number, interface)| between.sources(number, interface))
        .collect();
    press((before, state), (after, &mut next), &sources);
    rub((before, state), (after, &mut next), &sources);
    next
}

/// Sets pressures of obstacles and tractions of guides, with their statuses.
fn press(
    (before, state): (&Model<'_>, &State),
    (after, next): (&Model<'_>, &mut State),
    sources: &[Vec<Sources>],
) {
    let own = before.interfaces.list.iter();
    let own: Vec<_> = own.map(|one| one.own(&state.multiplier)).collect();
    for (interface, sources) in after.interfaces.list.iter().zip(sources) {
        for (place, sources) in interface.places().zip(sources) {
            let parts = sources.iter();
            let value = parts.map(|&(from, m, share)| share * own[from][m as usize]);
            next.multiplier[place] = value.sum();
            if interface.is_contact() {
                next.status[place] = Status::of_contact(next.multiplier[place] > 0.0);
            }
        }
    }
}

/// Number of the first point of friction of each interface; `None` of those without.
fn first_points(model: &Model<'_>) -> Vec<Option<usize>> {
    let mut first = vec![None; model.interfaces.list.len()];
    let mut next = 0;
    for (number, interface) in model.frictional() {
        first[number] = Some(next);
        next += interface.multipliers.len();
    }
    first
}

/// What the points of friction of a body have, as vectors.
struct Points {
    first: Vec<Option<usize>>,
    traction: Vec<[f64; 3]>,
    status: Vec<Status>,
    /// Residue over the weight of its function.
    residue: Vec<[f64; 3]>,
}

impl Points {
    fn of(model: &Model<'_>, state: &State) -> Option<Self> {
        let friction = model.interfaces.friction.as_ref()?;
        let width = friction.components.count();
        let frames = friction.frames(model, state);
        let tractions = state.multiplier.get(friction.first..)?.chunks(width);
        let vector = |(own, frame): (&[f64], &Frame)| {
            let parts = own.iter().zip(frame);
            parts.fold([0.0; 3], |sum, (t, axis)| add(sum, scale(*t, *axis)))
        };
        let first = state.status.get(friction.first..)?;
        let weights = friction.traces(model, state);
        let residues = state.slip.residue.as_chunks::<3>().0.iter();
        let residue = residues.zip(&weights.weights);
        Some(Self {
            first: first_points(model),
            traction: tractions.zip(&frames).map(vector).collect(),
            status: first.iter().step_by(width).copied().collect(),
            residue: residue.map(|(r, w)| scale(w.recip(), *r)).collect(),
        })
    }

    /// The sources of a point as earlier points with their shares.
    fn places(&self, sources: &Sources) -> Vec<(usize, f64)> {
        let places = sources.iter().filter_map(|&(from, m, share)| {
            let first = self.first[from]?;
            Some((first + m as usize, share))
        });
        places.collect()
    }
}

/// The mean of vectors by shares.
fn mean(values: &[[f64; 3]], shares: &[(usize, f64)]) -> [f64; 3] {
    let parts = shares.iter();
    parts.fold([0.0; 3], |sum, &(place, share)| {
        add(sum, scale(share, values[place]))
    })
}

/// Sets tractions of friction and what friction did.
fn rub(
    (before, state): (&Model<'_>, &State),
    (after, next): (&Model<'_>, &mut State),
    sources: &[Vec<Sources>],
) {
    let (Some(old), Some(friction)) = (Points::of(before, state), &after.interfaces.friction)
    else {
        return;
    };
    let [from, to] = [before, after].map(|model| &model.plan.problem.units);
    let (longer, work) = (from.length / to.length, from.energy() / to.energy());
    let frames = friction.frames(after, next);
    let weights = friction.traces(after, next);
    let own = after.frictional().flat_map(|(number, _)| &sources[number]);
    let travel = state.slip.travel.as_chunks::<3>().0;
    let mut slip = SlipState {
        increment: state.slip.increment.iter().map(|w| w * work).collect(),
        total: state.slip.total.iter().map(|w| w * work).collect(),
        ..SlipState::default()
    };
    let width = friction.components.count();
    for (point, sources) in own.enumerate() {
        let shares = old.places(sources);
        let traction = mean(&old.traction, &shares);
        let first = friction.first + point * width;
        let is_closed = next.multiplier[friction.partners[point] as usize] > 0.0;
        let closed = shares.iter().map(|&(place, _)| old.status[place]);
        let mut closed = closed.filter(|status| status.is_closed());
        let status = match (is_closed, closed.all(|status| status == Status::Slip)) {
            (false, _) => Status::Open,
            (true, true) => Status::Slip,
            (true, false) => Status::Stick,
        };
        for (axis, tangent) in frames[point][..width].iter().enumerate() {
            next.multiplier[first + axis] = dot(*tangent, traction);
            next.status[first + axis] = status;
        }
        let residue = scale(weights.weights[point], mean(&old.residue, &shares));
        slip.travel.extend(scale(longer, mean(travel, &shares)));
        slip.residue.extend(scale(longer, residue));
    }
    next.slip = slip;
}

/// Whether each node of each fluid's surface is wet.
fn wet(before: &Plan, state: &State, (after, lineage): (&Plan, &Lineage)) -> Vec<Vec<bool>> {
    let [old, new] = [before, after].map(|plan| &plan.problem.fluid_surfaces);
    let reached = [before, after].map(|plan| &plan.problem.resolved.fluids);
    let of_fluid = |(number, surface): (usize, &FluidSurface)| {
        let mut wet = surface.sources.clone();
        let (Some(earlier), Some(known)) = (old.get(number), state.wet.get(number)) else {
            return wet;
        };
        let facets = [&reached[0][number].facets, &reached[1][number].facets];
        let place = facets[0].iter().zip(&earlier.facets);
        let place: HashMap<u32, &Vec<u32>> = place.map(|(&facet, own)| (facet, own)).collect();
        for (facet, own) in facets[1].iter().zip(&surface.facets) {
            let origin = &lineage.facets()[*facet as usize];
            let Some(nodes) = place.get(&origin.facet) else {
                continue;
            };
            for (k, &node) in own.iter().enumerate() {
                wet[node as usize] |= is_wet(k, origin, |q| known[nodes[q] as usize]);
            }
        }
        wet
    };
    new.iter().enumerate().map(of_fluid).collect()
}

/// Whether node `k` of a facet is wet by the nodes of the earlier one: as the one that it was,
/// else if all are about it.
fn is_wet(k: usize, origin: &FacetOrigin, was_wet: impl Fn(usize) -> bool) -> bool {
    let corners = origin
        .corners
        .iter()
        .filter(|row| row.iter().sum::<f64>() > 0.5);
    let corners = corners.count();
    let nodes = corners * (corners + 1) / 2;
    let (i, j) = corners_of(k, corners);
    let at = add(scale(0.5, origin.corners[i]), scale(0.5, origin.corners[j]));
    // Both are dyadic, so that the comparison is exact.
    let same = (0..nodes).find(|&q| {
        let (a, b) = corners_of(q, corners);
        let unit = |corner: usize| -> [f64; 3] {
            std::array::from_fn(|i| f64::from(u8::from(i == corner)))
        };
        at.map(f64::to_bits) == add(scale(0.5, unit(a)), scale(0.5, unit(b))).map(f64::to_bits)
    });
    match same {
        Some(same) => was_wet(same),
        None => (0..nodes).all(|q| {
            let (a, b) = corners_of(q, corners);
            at[a] == 0.0 || at[b] == 0.0 || was_wet(q)
        }),
    }
}
